#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "closed_forms.h"
#include "common/decompositions.h"
#include "compare/audit/balance.h"
#include "compare/verdict/verify.h"
#include "relative/dynamics/equations.h"
#include "relative/start/assembly.h"

/// Three formulas of the paper as they are printed, beside what virtual work and Newton's law require: the third row of
/// (32), the right side of (22), and (20) for angular velocities. The referee is the direct sum over mass points.
namespace concord::verification {
namespace {

VecX stacked(const BodyAcceleration& acceleration) {
  VecX Ydot(6 + acceleration.addot.size());
  Ydot << acceleration.vdot, acceleration.omegadot, acceleration.addot;
  return Ydot;
}

VecX stacked(const BodyState& state) {
  VecX Y(6 + state.a.size());
  Y << state.v, state.omega, state.adot;
  return Y;
}

/// M Ydot + S + U - Q_gravity of a body, 6 + m rows about its origin, global axes: the virtual work of every mass
/// point, and Euler's law for a rigid body's spin.
VecX inertia_rows(const Body& body, const BodyState& state, const VecX& Ydot, const Vec3& gravity) {
  const Mat3 A = rotation_of(state.p);
  const Vec3& omega = state.omega;
  const Eigen::Index m = state.a.size();
  VecX rows = VecX::Zero(6 + m);
  const auto add = [&](const MassPoint& point) {
    const Vec3 s = A * (point.s0_L + point.Psi_t_L * state.a);
    const Vec3 acceleration = Ydot.head<3>() + Ydot.segment<3>(3).cross(s) + omega.cross(omega.cross(s)) +
                              2.0 * omega.cross(A * (point.Psi_t_L * state.adot)) + A * (point.Psi_t_L * Ydot.tail(m));
    const Vec3 force = point.mass * (acceleration - gravity);
    rows.head<3>() += force;
    rows.segment<3>(3) += s.cross(force);
    rows.tail(m) += point.Psi_t_L.transpose() * A.transpose() * force;
  };
  if (body.modal) {
    for (const MassPoint& point : body.modal->mass_points) add(point);
    rows.tail(m) += body.modal->stiffness * state.a + body.modal->damping * state.adot;
  } else {
    add({body.mass, body.center_of_mass_L, Mat3X(3, 0)});
    const Mat3 I = A * body.inertia_L * A.transpose();
    rows.segment<3>(3) += I * Ydot.segment<3>(3) + omega.cross(I * omega);
  }
  return rows;
}

MatX mass_matrix(const Body& body, const BodyState& state) {
  const Eigen::Index n = 6 + state.a.size();
  const VecX at_rest = inertia_rows(body, state, VecX::Zero(n), Vec3::Zero());
  MatX M(n, n);
  for (Eigen::Index c = 0; c < n; ++c) M.col(c) = inertia_rows(body, state, VecX::Unit(n, c), Vec3::Zero()) - at_rest;
  return M;
}

/// S(omega, a, adot): what is left of the rows without acceleration, gravity, stiffness and damping.
VecX velocity_terms(const Body& body, const BodyState& state) {
  VecX S = inertia_rows(body, state, VecX::Zero(6 + state.a.size()), Vec3::Zero());
  if (body.modal) {
    S.tail(state.a.size()) -= body.modal->stiffness * state.a + body.modal->damping * state.adot;
  }
  return S;
}

/// J of the exponential map as the integral of exp(x theta~) over x in (0, 1), by Simpson's rule.
Mat3 tangent(const Vec3& theta) {
  constexpr int pieces = 32;
  const double angle = theta.norm();
  if (angle == 0.0) return Mat3::Identity();
  Mat3 sum = Mat3::Zero();
  for (int k = 0; k <= pieces; ++k) {
    const double weight = k == 0 || k == pieces ? 1.0 : (k % 2 == 1 ? 4.0 : 2.0);
    sum += weight * rotation_about(Vec3(theta / angle), angle * k / pieces);
  }
  return sum / (3.0 * pieces);
}

/// Modal rows of (32) of one wrench at the joint's point on a flexible body.
VecX virtual_work_row(const Attachment& side, const BodyState& state, const Wrench& wrench) {
  const Mat3 A = rotation_of(state.p);
  return side.Psi_t_L.transpose() * A.transpose() * wrench.force +
         (tangent(side.Psi_r_L * state.a) * side.Psi_r_L).transpose() * A.transpose() * wrench.torque;
}

/// The term that is printed besides: (A Psi_r)^T (A s_P)~ F.
VecX printed_extra(const Attachment& side, const BodyState& state, const Wrench& wrench) {
  const Mat3 A = rotation_of(state.p);
  const Vec3 lever = A * (side.point_L + side.Psi_t_L * state.a);
  return (A * side.Psi_r_L).transpose() * lever.cross(wrench.force);
}

template <class RowOfWrench>
VecX sum_over_joints(const Model& model, int body, const BodyState& state, const Evaluation& evaluation,
                     const RowOfWrench& row) {
  VecX sum = VecX::Zero(state.a.size());
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    for (const Side side : kSides) {
      if (model.joints[k].on(side).body != body) continue;
      sum += row(model.joints[k].on(side), state, evaluation.joints[k].total_on(side).in_global);
    }
  }
  return sum;
}

/// The modal equations of a flexible body, side by side.
struct ModalRows {
  VecX needed;   // M Ydot + S + U - Q_gravity
  VecX by_work;  // Q of all joints by virtual work
  VecX printed;  // the same with the term that is printed besides

  ModalRows(const Model& model, int body, const State& state, const Evaluation& evaluation) {
    const BodyState& motion = state.bodies[body];
    needed =
        inertia_rows(model.bodies[body], motion, stacked(evaluation.bodies[body]), model.gravity).tail(motion.a.size());
    by_work = sum_over_joints(model, body, motion, evaluation, virtual_work_row);
    printed = by_work + sum_over_joints(model, body, motion, evaluation, printed_extra);
  }

  [[nodiscard]] double scale() const { return std::max(needed.norm(), by_work.norm()); }
  [[nodiscard]] double miss_by_work() const { return (needed - by_work).norm() / scale(); }
  [[nodiscard]] double miss_printed() const { return (needed - printed).norm() / scale(); }
};

/// What a solver would say that puts the printed row into the equations of motion of its flexible bodies: the modal
/// loads of the reactions are wrong by the extra term, and the body accelerates accordingly.
class BelievesThePrint : public Solver {
 public:
  BelievesThePrint(const Model& model, Solver& solver) : model_(model), solver_(solver) {}

  [[nodiscard]] std::string_view name() const override { return solver_.name(); }
  [[nodiscard]] std::vector<std::string> integrators() const override { return solver_.integrators(); }
  State assemble() override { return solver_.assemble(); }
  std::optional<State> close(const State& guess) override { return solver_.close(guess); }
  RankReport rank(const State& state) override { return solver_.rank(state); }
  MatX tangent(const State& state) override { return solver_.tangent(state); }
  [[nodiscard]] std::vector<std::string> cut_joints() const override { return solver_.cut_joints(); }

  Evaluation evaluate(const State& state) override { return falsified(state, solver_.evaluate(state)); }

  Trajectory integrate(const RunOptions& options, const Progress& progress) override {
    Trajectory trajectory = solver_.integrate(options, progress);
    for (Sample& sample : trajectory.samples) sample.evaluation = falsified(sample.state, sample.evaluation);
    return trajectory;
  }

 private:
  [[nodiscard]] Evaluation falsified(const State& state, Evaluation evaluation) const {
    for (int i = 1; i < static_cast<int>(model_.bodies.size()); ++i) {
      const BodyState& motion = state.bodies[i];
      if (motion.a.size() == 0) continue;
      VecX load = VecX::Zero(6 + motion.a.size());
      load.tail(motion.a.size()) = sum_over_joints(model_, i, motion, evaluation, printed_extra);
      const VecX change = solve_square(mass_matrix(model_.bodies[i], motion), load);
      evaluation.bodies[i].vdot += change.head<3>();
      evaluation.bodies[i].omegadot += change.segment<3>(3);
      evaluation.bodies[i].addot += change.tail(motion.a.size());
    }
    return evaluation;
  }

  const Model& model_;
  Solver& solver_;
};

/// A state at `by` (small) along its own velocities.
BodyState moved(const BodyState& state, double by) {
  BodyState result = state;
  const Vec3 turn = by * state.omega;
  const Eigen::Quaterniond p(state.p(0), state.p(1), state.p(2), state.p(3));
  const Eigen::Quaterniond turned = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * p;
  result.p << turned.w(), turned.vec();
  result.a += by * state.adot;
  return result;
}

double kinetic_energy(const Body& body, const BodyState& state, const VecX& Y) {
  return 0.5 * Y.dot(mass_matrix(body, state) * Y);
}

/// Mdot Y - (dT/dy)^T as (20) has it, by differences: y stands for place, turning about the global axes, and a.
VecX printed_velocity_terms(const Body& body, const BodyState& state) {
  const double h = 1e-4;
  const VecX Y = stacked(state);
  const double rate = 1.0 / (1.0 + state.omega.norm());
  VecX terms = (mass_matrix(body, moved(state, h * rate)) - mass_matrix(body, moved(state, -h * rate))) * Y;
  terms /= 2.0 * h * rate;
  for (Eigen::Index c = 3; c < Y.size(); ++c) {
    // Moved along one direction alone, the velocities in T kept.
    BodyState direction = state;
    direction.omega = c < 6 ? Vec3(Vec3::Unit(c - 3)) : Vec3::Zero();
    direction.adot = c < 6 ? VecX(VecX::Zero(state.a.size())) : VecX(VecX::Unit(state.a.size(), c - 6));
    terms(c) -=
        (kinetic_energy(body, moved(direction, h), Y) - kinetic_energy(body, moved(direction, -h), Y)) / (2 * h);
  }
  return terms;
}

}  // namespace

TEST_CASE(
    "The modal row of (32) balances the flagship's coupler by virtual work, and not with the lever that is "
    "printed besides",
    "[doubtful print][quick]") {
  const Model model = read("slider_crank_spatial_flexible");
  for (const auto& solver : both_solvers(model)) {
    const Trajectory trajectory = run(*solver, 0.01, 1e-8, 2);
    for (const Sample& sample : trajectory.samples) {
      INFO(solver->name() << ", t = " << sample.state.t);
      const ModalRows rows(model, 2, sample.state, solver->evaluate(sample.state));
      fmt::print("{}, coupler, t = {:g} s\n", solver->name(), sample.state.t);
      fmt::print("| mode | M Ydot + S + U - Q | virtual work | as printed   |\n");
      for (Eigen::Index n = 0; n < rows.needed.size(); ++n) {
        fmt::print("| {:>4} | {:>18.6f} | {:>12.6f} | {:>12.6f} |\n", n + 1, rows.needed(n), rows.by_work(n),
                   rows.printed(n));
      }
      fmt::print("| miss |                    | {:>12.1e} | {:>12.3f} |  of the largest\n", rows.miss_by_work(),
                 rows.miss_printed());
      CHECK(rows.miss_by_work() < 1e-11);
      CHECK(rows.miss_printed() > 0.05);
    }
  }
}

TEST_CASE("The comparator catches a solver that believes the printed row of (32)", "[doubtful print][quick]") {
  const Model model = read("slider_crank_spatial_flexible");
  const auto solvers = both_solvers(model);
  const State start = solvers[1]->assemble();
  BelievesThePrint believer(model, *solvers[1]);
  compare::Auditor honest(model);
  honest.add(start, solvers[1]->evaluate(start));
  compare::Auditor deceived(model);
  deceived.add(start, believer.evaluate(start));
  fmt::print("audit by virtual work: {}\naudit as printed:      {}\n", honest.report().worst.text(),
             deceived.report().worst.text());
  CHECK(honest.report().digits() >= 9.0);
  CHECK(deceived.report().digits() < 2.0);
  CHECK(deceived.report().worst.where == "coupler");
  CHECK(deceived.report().worst.row.substr(0, 4) == "mode");

  compare::VerifyOptions options;
  options.until = 0.002;
  options.rtol = 1e-8;
  const compare::Verdict right = compare::verify(model, *solvers[0], *solvers[1], options);
  for (const compare::Finding& finding : right.findings) UNSCOPED_INFO(finding.what << ": " << finding.symptom);
  CHECK(right.outcome == compare::Outcome::agree);
  const compare::Verdict caught = compare::verify(model, *solvers[0], believer, options);
  CHECK(caught.outcome == compare::Outcome::differ);
  bool named = false;
  for (const compare::Finding& finding : caught.findings) {
    fmt::print("comparator: {}; {}\n", finding.what, finding.symptom);
    named = named || finding.what.find("relative is not in balance: free body: coupler, mode") == 0;
  }
  CHECK(named);
}

TEST_CASE("The right side of (22) needs M Bdot u; with M B udot, as printed, the equations give other accelerations",
          "[doubtful print][quick]") {
  const Model model = read("double_pendulum_3d");
  relative::Equations equations(model);
  const relative::Coordinates start = relative::Assembly(equations).start();
  const relative::Evaluated& evaluated = equations.compute_accelerations(0.0, start.q, start.u);
  const State state = relative::make_solver(model)->assemble();
  const relative::Kinematics& kinematics = equations.kinematics();
  const MatX B = kinematics.explicit_B_of_origins();
  VecX Bdot_u = kinematics.Bdot_u();
  for (relative::BodyIndex i(1); i < 3; ++i) {
    const int row = kinematics.first_row(i);
    Bdot_u.segment<6>(row) = kinematics.acceleration_of_origin(i, Bdot_u.segment<6>(row));
  }
  MatX M = MatX::Zero(B.rows(), B.rows());
  VecX load(B.rows());  // Q - S - U
  for (int i = 1; i <= 2; ++i) {
    const int row = equations.kinematics().first_row(relative::BodyIndex(i));
    M.block<6, 6>(row, row) = mass_matrix(model.bodies[i], state.bodies[i]);
    load.segment<6>(row) = -inertia_rows(model.bodies[i], state.bodies[i], VecX::Zero(6), model.gravity);
  }
  const MatX Mbar = B.transpose() * M * B;
  const VecX as_derived = solve_square(Mbar, B.transpose() * (load - M * Bdot_u));
  // Mbar udot = B^T (Q - S - U - M B udot): udot stands on both sides.
  const VecX as_printed = solve_square(2.0 * Mbar, B.transpose() * load);
  const VecX& udot = evaluated.udot();
  fmt::print("(22) on double_pendulum_3d: udot with M Bdot u {:.1e} off, with M B udot {:.2f} off, of its size\n",
             (as_derived - udot).norm() / udot.norm(), (as_printed - udot).norm() / udot.norm());
  CHECK((as_derived - udot).norm() < 1e-12 * udot.norm());
  CHECK((as_printed - udot).norm() > 0.1 * udot.norm());
  // The other solver knows neither B nor Bdot.
  const Evaluation witness = cartesian::make_solver(model)->evaluate(state);
  const VecX Ydot = B * as_derived + Bdot_u;
  for (int i = 1; i <= 2; ++i) {
    const VecX expected = stacked(witness.bodies[i]);
    CHECK((Ydot.segment<6>(6 * (i - 1)) - expected).norm() < 1e-11 * expected.norm());
  }
}

TEST_CASE("For angular velocities (20) counts omega x (angular momentum) twice", "[doubtful print][quick]") {
  const Model model = read("slider_crank_spatial_flexible");
  for (const auto& solver : both_solvers(model)) {
    const Trajectory trajectory = run(*solver, 0.01, 1e-8, 1);
    const State& state = trajectory.samples.back().state;
    const Evaluation evaluation = solver->evaluate(state);
    for (int i = 1; i <= 2; ++i) {
      const Body& body = model.bodies[i];
      const BodyState& motion = state.bodies[i];
      INFO(solver->name() << ", " << body.name);
      const VecX S = velocity_terms(body, motion);
      const VecX printed = printed_velocity_terms(body, motion);
      const Vec3 momentum = (mass_matrix(body, motion) * stacked(motion)).segment<3>(3);
      VecX twice = VecX::Zero(S.size());
      twice.segment<3>(3) = motion.omega.cross(momentum);
      fmt::print("(20), {}: S about the axes ({:.5f}), printed ({:.5f}), omega x L ({:.5f}) N m\n", body.name,
                 fmt::join(S.segment<3>(3), ", "), fmt::join(printed.segment<3>(3), ", "),
                 fmt::join(twice.segment<3>(3), ", "));
      CHECK((printed - S - twice).norm() < 1e-7 * S.norm());
      CHECK(twice.norm() > 0.01 * S.segment<3>(3).norm());
    }
  }
}

}  // namespace concord::verification
