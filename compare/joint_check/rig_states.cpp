#include "compare/joint_check/rig_states.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "cartesian/dynamics/equations.h"
#include "cartesian/solver.h"
#include "compare/joint_check/opinions.h"
#include "relative/dynamics/equations.h"
#include "relative/start/states.h"

namespace concord::compare::joint_check {

namespace {

/// Largest closure residual of a state in the Cartesian solver's own equations: positions, and velocities relative to
/// the largest.
double residual_of(cartesian::Equations& equations, const State& state) {
  VecX q = VecX::Zero(equations.layout().n_q());
  VecX Y = VecX::Zero(equations.layout().n_Y());
  equations.layout().unpack(state, q, Y);
  equations.update(state.t, q, Y);
  if (equations.residual().size() == 0) return 0.0;
  return std::max(equations.residual().lpNorm<Eigen::Infinity>(),
                  equations.velocity_residual().lpNorm<Eigen::Infinity>() / (1.0 + Y.lpNorm<Eigen::Infinity>()));
}

/// The outer body pushed and turned out of its place.
State disturbed(State state, Numbers& numbers) {
  BodyState& body = state.bodies[2];
  body.r += numbers.vector(0.05);
  body.v += numbers.vector(0.3);
  body.omega += numbers.vector(0.3);
  body.p = (body.p + Vec4(numbers.vector(4, 0.05))).normalized();
  return state;
}

/// Coordinates along a way from two and a half turns back to three turns ahead, `s` from 0 to 1; an orientation turns
/// about an axis of no frame; what cannot turn goes to and fro.
VecX coordinates_along(const JointType& type, double s) {
  const double turned = (5.5 * s - 2.5) * 2.0 * std::numbers::pi;
  VecX q(type.n_q());
  for (std::size_t k = 0; k < type.permits.size(); ++k) {
    if (!is_orientation(type.permits[k])) continue;
    const Vec3 axis = Vec3(1.0, -2.0, 0.7).normalized();
    q.segment<4>(first_q(type, static_cast<int>(k))) << std::cos(0.5 * turned), std::sin(0.5 * turned) * axis;
  }
  for (const Coordinate& coordinate : coordinates_of(type)) {
    const double middle = 0.5 * (coordinate.greatest + coordinate.least);
    const double reach = 0.5 * (coordinate.greatest - coordinate.least);
    const bool goes_round = coordinate.is_turn && reach > 3.0 * 2.0 * std::numbers::pi;
    q(coordinate.q) =
        goes_round ? turned / (1.0 + 0.4 * coordinate.u) : middle + 0.8 * reach * std::sin(0.3 * turned + coordinate.u);
  }
  return q;
}

}  // namespace

void exchange_states(Rig& rig, std::uint32_t seed, const std::vector<int>& poses, const std::string& context,
                     Property& property) {
  cartesian::Equations cartesian_equations(rig.open());
  relative::Equations relative_equations(rig.open());
  relative::States relative_states(relative_equations);
  const std::unique_ptr<Solver> cartesian = cartesian::make_solver(rig.open());
  for (const int pose : poses) {
    const State state = rig.state(pose);
    const double residual = residual_of(cartesian_equations, state);
    property.note(residual, pose, [&] {
      return fmt::format("{}: a state made by relative is {:.3g} (m, rad) open in cartesian", context, residual);
    });
    Numbers numbers(seed, streams::kFirstDisturbance + static_cast<std::uint32_t>(pose));
    const std::optional<State> closed = cartesian->close(disturbed(state, numbers));
    property.require(closed.has_value(), pose,
                     [&] { return fmt::format("{}: cartesian does not close a disturbed state", context); });
    if (!closed) continue;
    relative::StateMisfit misfit;
    (void)relative_states.read(*closed, misfit);
    property.note(misfit.largest, pose, [&] {
      return fmt::format("{}: a state closed by cartesian misfits {} by {:.3g} in relative", context, misfit.where,
                         misfit.largest);
    });
  }
}

void follow_turns(Rig& rig, Property& property) {
  constexpr int kSteps = 60;
  const JointType& type = *rig.open().joints[Rig::kTested].type;
  for (const Opinion who : {cartesian_open, tree_open, cut_idle}) {
    const std::unique_ptr<Solver> solver = solver_of(rig, who);
    VecX known = coordinates_along(type, 0.0);
    for (int step = 0; step <= kSteps; ++step) {
      const VecX q = coordinates_along(type, static_cast<double>(step) / kSteps);
      State state = rig.state_at(q);
      state.q[Rig::kTested] = known;
      const std::optional<State> closed = solver->close(state_of(rig, who, state));
      property.require(closed.has_value(), -1, [&] {
        return fmt::format("{}: step {} of {} does not close", kOpinionNames[who], step, kSteps);
      });
      if (!closed) return;
      known = closed->q[Rig::kTested];
      const double error = (known - q).norm();
      property.note(error / (1.0 + q.norm()), -1, [&] {
        return fmt::format("{}: step {} of {}: coordinates {:.3g} (m, rad) off", kOpinionNames[who], step, kSteps,
                           error);
      });
    }
  }
}

void require_rank(Rig& rig, const Arrangement& arrangement, int pose, Property& property) {
  const auto& joint = rig.open().joints[Rig::kTested];
  const int drivers = static_cast<int>(joint.drivers.size());
  const int modes = rig.open().bodies[1].n_modes() + rig.open().bodies[2].n_modes();
  const State open = rig.state(pose);
  for (std::size_t who = 0; who < kOpinions; ++who) {
    const int ball = in_loop(who) ? 3 : 0;
    const int rows = joint.type->rows() + joint.type->nonholonomic_rows() + drivers + ball;
    const int freedom = 6 + joint.type->n_u() - joint.type->nonholonomic_rows() - drivers - ball + modes;
    const RankReport report = solver_of(rig, who)->rank(state_of(rig, who, open));
    bool unique = true;
    for (const auto& side : report.joints[Rig::kTested].unique) {
      unique = unique && std::all_of(side.begin(), side.end(), [](bool component) { return component; });
    }
    const bool right = report.constraints == rows && report.rank == rows && report.degrees_of_freedom == freedom &&
                       !report.undecided && unique;
    property.require(right, pose, [&] {
      return fmt::format("{}: {}: {} constraints of rank {}, {} degrees of freedom, {}; expected {}, {}, {}, unique",
                         describe(arrangement), kOpinionNames[who], report.constraints, report.rank,
                         report.degrees_of_freedom, report.undecided ? "undecided" : (unique ? "unique" : "not unique"),
                         rows, rows, freedom);
    });
  }
}

}  // namespace concord::compare::joint_check
