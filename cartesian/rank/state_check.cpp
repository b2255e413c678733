#include "cartesian/rank/state_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "cartesian/dynamics/state_scales.h"
#include "cartesian/rank/closing.h"
#include "common/error.h"

namespace concord::cartesian {

void require_shape(const Model& model, const State& state) {
  const auto require = [&](std::ptrdiff_t found, std::ptrdiff_t expected, const std::string& what) {
    if (found == expected) return;
    throw SolverError(
        fmt::format("cartesian: the state at t = {:.6g} s has {} {}, expected {}", state.t, found, what, expected));
  };
  require(std::ssize(state.bodies), std::ssize(model.bodies), "bodies, ground among them");
  for (const BodyIndex i : indices_of(model.bodies)) {
    const Body& body = pick(model.bodies, i);
    require(state.bodies[i.value].a.size(), body.n_modes(), fmt::format("modal coordinates of body '{}'", body.name));
    require(state.bodies[i.value].adot.size(), body.n_modes(), fmt::format("modal rates of body '{}'", body.name));
  }
  require(std::ssize(state.q), std::ssize(model.joints), "sets of joint coordinates");
  for (const JointIndex k : indices_of(model.joints)) {
    const Joint& joint = pick(model.joints, k);
    require(state.q[k.value].size(), joint.type->n_q(), fmt::format("coordinates of joint '{}'", joint.name));
  }
}

namespace {

constexpr double kClosureAllowed = 1e-12;  // a handed-over state is refused above this residual

/// Laws of drivers and coordinates of couplings that count many turns are known to their round-off only: where it is
/// more than what is allowed, their residuals may be as much larger. Rows of other drivers have such a share already.
void allow_round_off_of_turns(const Equations& equations, const State& state, RoundOffShares& shares) {
  constexpr double kOfAngles = 4.0 * std::numeric_limits<double>::epsilon() / kClosureAllowed;
  const Model& model = equations.model();
  const auto allow = [&](RowIndex row, double angle) {
    const double size = equations.row_sizes()(row.value);
    if (size > 0.0) shares.terms(row.value) = std::max(shares.terms(row.value), kOfAngles * std::abs(angle) / size);
  };
  for (const JointIndex k : indices_of(model.joints)) {
    const JointEquations& joint = equations.moving_constraints().joint(k);
    for (std::size_t driver = 0; driver < joint.driver_turns.size(); ++driver) {
      if (!joint.driver_turns[driver]) continue;
      const RowIndex row = joint.row(joint.first_driver + static_cast<int>(driver));
      allow(row, evaluate(pick(model.joints, k).drivers[driver].law, state.t).f);
    }
  }
  for (const CouplingIndex g : indices_of(model.couplings)) {
    for (const CouplingTerm& term : pick(model.couplings, g).terms) {
      const int place = first_q(*model.joints[term.joint].type, term.word) + term.component;
      allow(equations.constraints().coupling(g).row, term.factor * state.q[term.joint](place));
    }
  }
}

}  // namespace

void refuse_open(const Equations& equations, const State& state, const VecX& q, const VecX& Y) {
  if (!q.allFinite() || !Y.allFinite()) {
    throw SolverError(fmt::format("cartesian: the state at t = {:.6g} s holds a number that is not finite", state.t));
  }
  RoundOffShares shares(equations.constraints());
  measure_round_off(equations, state.t, q, shares);
  allow_round_off_of_turns(equations, state, shares);
  const double position_residual = largest_residual(equations, equations.residual(), &shares.terms);
  const double rate = largest_residual(equations, equations.velocity_residual(), &shares.reaches);
  const double allowed_rate = kClosureAllowed * largest_rate(equations, state.t, Y);
  double stretch = 0.0;
  for (const BodyState& body : state.bodies) stretch = std::max(stretch, std::abs(body.p.norm() - 1.0));
  if (position_residual <= kClosureAllowed && rate <= allowed_rate && stretch <= kClosureAllowed) return;
  const bool moves = position_residual <= kClosureAllowed;
  const std::string place = name_of_largest(equations, moves ? equations.velocity_residual() : equations.residual());
  throw OpenState(
      fmt::format(
          "cartesian: the state at t = {:.6g} s is not closed: {} residual {:.2g} (of the machine's length, or rad), "
          "velocities {:.2g} of the largest, Euler parameters {:.2g} off unit length; allowed {:.0e}",
          state.t, place, position_residual, rate == 0.0 ? 0.0 : kClosureAllowed * rate / allowed_rate, stretch,
          kClosureAllowed),
      place);
}

bool is_turned_beyond(const Equations& equations, double allowed, const std::vector<VecX>& q) {
  const std::optional<TurnError> error = largest_turn_error(equations, q);
  return error && error->size > allowed;
}

void refuse_other_branch(const Equations& equations, const State& state) {
  if (const std::optional<JointIndex> joint = equations.moving_constraints().first_joint_off_branch()) {
    throw SolverError(
        fmt::format("cartesian: in the state at t = {:.6g} s joint '{}' stands on another branch than its "
                    "type means",
                    state.t, pick(equations.model().joints, *joint).name));
  }
  const std::optional<TurnError> error = largest_turn_error(equations, state.q);
  if (!error || !(error->size > kHalfTurn)) return;
  throw SolverError(fmt::format(
      "cartesian: in the state at t = {:.6g} s joint '{}' stands at {:.6g} rad, but its coordinate says {:.6g} rad: "
      "another turn",
      state.t, pick(equations.model().joints, error->joint).name, error->read, error->known));
}

}  // namespace concord::cartesian
