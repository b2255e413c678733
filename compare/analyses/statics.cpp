#include "compare/analyses/statics.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>

#include "common/decompositions.h"
#include "common/error.h"
#include "compare/audit/joint_motion.h"
#include "compare/verdict/motion_names.h"

namespace concord::compare::analyses {

namespace {

constexpr int kMostIterations = 300;
constexpr double kLongestStep = 0.3;      // of the machine's length, rad
constexpr double kDifferenceStep = 0.02;  // the same, for derivatives
constexpr double kLeastDifferenceStep = 1e-6;
constexpr double kNoStiffness = 1e-9;      // of the largest
constexpr double kRoundOff = 1e-14;        // differences resolve no stiffness below this part of all of it
constexpr double kNegligibleForce = 1e-9;  // of what forces cause
constexpr double kSmallStep = 1e-9;        // Newton's method may end
constexpr double kRoundOffStep = 1e-14;    // and does end
/// The longest pseudo time step, in units of the time in which forces move the machine by its length.
constexpr double kLongestTime = 1e4;

/// So far that stiff directions change the accelerations by ten times `reference`, soft ones as far as is good.
double difference_step(const std::function<std::optional<VecX>(double)>& function, double reference) {
  constexpr double kTimesReference = 10.0;
  const auto plus = function(kLeastDifferenceStep);
  const auto minus = function(-kLeastDifferenceStep);
  if (!plus || !minus || reference == 0.0) return kDifferenceStep;
  const double slope = (*plus - *minus).norm() / (2.0 * kLeastDifferenceStep);
  if (slope * kDifferenceStep <= kTimesReference * reference) return kDifferenceStep;
  return std::max(4.0 * kLeastDifferenceStep, kTimesReference * reference / slope);
}

double mass_of(const Body& body) { return body.modal ? body.modal->G(0, 0) : body.mass; }

}  // namespace

Model held_at_start(const Model& model) {
  Model held = model;
  for (Joint& joint : held.joints) {
    for (Driver& driver : joint.drivers) driver.law = ConstantSpeed{evaluate(driver.law, 0.0).f, 0.0};
    for (WordStart& word : joint.start) word.u.setZero();
  }
  for (Body& body : held.bodies) body.adot_start.setZero();
  return held;
}

double reference_acceleration(const Model& model, const Evaluation& evaluation) {
  const double length = model.length_scale();
  std::vector<double> forces(model.bodies.size(), 0.0);
  const auto add = [&](int body, const Wrench& wrench) {
    forces[body] += std::max(wrench.force.norm(), wrench.torque.norm() / length);
  };
  for (const Side side : {Side::parent, Side::child}) {
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      add(model.joints[k].on(side).body, evaluation.joints[k].total_on(side).in_C);
    }
    for (std::size_t k = 0; k < model.elements.size(); ++k) {
      const Attachment* end = end_of(model.elements[k], side);
      if (end != nullptr) add(end->body, evaluation.elements[k].on_side(side).in_C);
    }
  }
  double largest = model.gravity.norm();
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const double mass = mass_of(model.bodies[i]);
    if (mass > 0.0) largest = std::max(largest, forces[i] / mass);
  }
  return largest / length;
}

StiffnessSplit::StiffnessSplit(const Chart& chart, const MatX& J, double reference) {
  const Eigen::Index n = J.cols();
  const Eigen::Index m = chart.n_modal();
  MatX range = MatX::Identity(n, n);
  if (m > 0) range = orthogonal_completion(J.leftCols(m));
  onto_modes_ = range.leftCols(m);
  beyond_ = range.rightCols(n - m);
  R11_ = onto_modes_.transpose() * J.leftCols(m);
  R12_ = onto_modes_.transpose() * J.rightCols(n - m);
  free_ = MatX(n, 0);
  least_ = std::max(kNoStiffness * reference, kRoundOff * J.norm());
  if (n == m) return;
  const Eigen::JacobiSVD<MatX> svd(MatX(beyond_.transpose() * J.rightCols(n - m)),
                                   Eigen::ComputeFullU | Eigen::ComputeFullV);
  const VecX& sigma = svd.singularValues();
  largest_ = sigma(0);
  least_ = std::max(least_, kNoStiffness * largest_);
  const Eigen::Index rank = (sigma.array() > least_).count();
  const Eigen::Index missing = n - m - rank;
  pseudo_inverse_ = svd.matrixV().leftCols(rank) * sigma.head(rank).cwiseInverse().asDiagonal() *
                    svd.matrixU().leftCols(rank).transpose();
  unmet_projector_ = svd.matrixU().rightCols(missing) * svd.matrixU().rightCols(missing).transpose();
  free_ = MatX::Zero(n, missing);
  free_.bottomRows(n - m) = svd.matrixV().rightCols(missing);
  if (m > 0 && missing > 0) free_.topRows(m) = -least_squares(R11_, R12_ * free_.bottomRows(n - m));
}

VecX StiffnessSplit::newton_step(const VecX& f) const {
  const Eigen::Index m = onto_modes_.cols();
  const Eigen::Index rigid = beyond_.cols();
  VecX step = VecX::Zero(f.size());
  if (rigid > 0) step.tail(rigid) = -(pseudo_inverse_ * (beyond_.transpose() * f));
  if (m > 0) {
    step.head(m) = least_squares(R11_, -(onto_modes_.transpose() * f) - R12_ * step.tail(rigid));
  }
  return step;
}

VecX StiffnessSplit::unmet(const VecX& f) const {
  if (beyond_.cols() == 0) return VecX::Zero(f.size());
  return beyond_ * (unmet_projector_ * (beyond_.transpose() * f));
}

MatX stiffness_matrix(const Chart& chart, const Solver& solver, const AccelerationsAt& accelerations,
                      double reference) {
  MatX J(chart.n(), chart.n());
  for (int k = 0; k < chart.n(); ++k) {
    const auto along = [&](double step) { return accelerations(step * VecX::Unit(chart.n(), k)); };
    const auto column = derivative_at_zero(along, difference_step(along, reference), kLeastDifferenceStep, reference);
    if (!column) {
      throw SingularPose(fmt::format(
          "{}: at t = {:.6g} s the constraints permit {}, but no closed states are found along it: the pose "
          "is singular, or the machine cannot move so far there",
          solver.name(), chart.origin().t, chart.describe(VecX::Unit(chart.n(), k))));
    }
    J.col(k) = *column;
  }
  return J;
}

namespace {

/// Pseudo-transient continuation of one machine to its equilibrium.
class PseudoTransientContinuation {
 public:
  PseudoTransientContinuation(const Model& model, Solver& solver)
      : model_(model), solver_(solver), state_(solver.assemble()) {}

  Equilibrium run() {
    for (int iteration = 1; iteration <= kMostIterations; ++iteration) {
      if (advance()) return conclude(iteration);
    }
    throw SolverError(fmt::format("{}: no equilibrium in {} steps: at the last one {} still accelerates", name(),
                                  kMostIterations, describe_motion(model_, state_, last_force_)));
  }

 private:
  [[nodiscard]] std::string name() const { return fmt::format("{}: statics", solver_.name()); }

  /// One step; true if the state is at rest already.
  bool advance() {
    evaluation_ = solver_.evaluate(state_);
    Chart chart(model_, solver_, state_);
    if (chart.n() == 0) return true;
    const VecX f = chart.accelerations(state_, evaluation_);
    last_force_ = chart.velocities(f);
    const double reference = reference_acceleration(model_, evaluation_);
    const MatX J = stiffness_matrix(
        chart, solver_, [&](const VecX& delta) { return at_rest(chart, delta); }, reference);
    const StiffnessSplit split(chart, J, reference);
    const VecX newton = split.newton_step(f);
    const VecX unmet = split.unmet(f);
    const double slope = steepest_way_down(J, std::max(reference, split.largest()));
    name_free_directions(chart, split);
    const bool is_met = unmet.norm() <= kNegligibleForce * reference;
    if (is_met && is_done(newton.norm())) return true;
    const bool by_newton = is_met && slope <= 0.0 && time_ * reference >= kLongestTime;
    if (!by_newton) lengthen(f, slope, reference);
    if (by_newton || !is_met) refuse_if_pushed(chart, unmet, reference);
    last_step_ = newton.norm();
    move(chart, by_newton ? newton : flow_step(J, f));
    return false;
  }

  [[nodiscard]] std::optional<VecX> at_rest(Chart& chart, const VecX& delta) const {
    const auto state = chart.at(delta, VecX::Zero(chart.n()));
    if (!state) return std::nullopt;
    return chart.accelerations(*state, solver_.evaluate(*state));
  }

  /// Newton's steps have become round-off.
  [[nodiscard]] bool is_done(double step) const {
    return step <= kRoundOffStep || (step <= kSmallStep && last_step_ > 0.0 && step >= 0.3 * last_step_);
  }

  /// The largest growth rate squared of a motion away from rest, or zero; counts such motions.
  double steepest_way_down(const MatX& J, double largest) {
    const Eigen::VectorXcd eigenvalues = J.eigenvalues();
    const double least = 1e-8 * largest + 1e-13 * J.norm();
    unstable_directions_ = 0;
    double steepest = 0.0;
    for (const auto& one : eigenvalues) {
      if (one.real() <= least) continue;
      ++unstable_directions_;
      steepest = std::max(steepest, one.real());
    }
    return steepest;
  }

  /// Pseudo time steps grow tenfold, but stay short enough not to jump to a place from which the machine falls.
  void lengthen(const VecX& f, double slope, double reference) {
    time_ = time_ == 0.0 ? kLongestStep / (3.0 * f.norm()) : 10.0 * time_;
    time_ = std::min(time_, kLongestTime / reference);
    if (slope > 0.0) time_ = std::min(time_, 0.5 / slope);
  }

  [[nodiscard]] VecX flow_step(const MatX& J, const VecX& f) const {
    MatX system = -J;
    system.diagonal().array() += 1.0 / time_;
    return solve_square(system, f);
  }

  /// A force along a direction without stiffness, which long steps have not carried to where it vanishes.
  void refuse_if_pushed(const Chart& chart, const VecX& unmet, double reference) {
    if (time_ * reference < kLongestTime || unmet.norm() <= kNegligibleForce * reference) {
      pushed_ = 0;
      return;
    }
    if (++pushed_ < kPushes) return;
    const VecX pushed = chart.velocities(unmet);
    throw SolverError(
        fmt::format("{}: nothing resists {}: it is pushed and meets no stiffness; hold it, or give it a "
                    "spring",
                    name(), describe_motion(model_, state_, pushed)));
  }

  void move(Chart& chart, VecX step) {
    if (step.norm() > kLongestStep) step *= kLongestStep / step.norm();
    constexpr int kTries = 20;
    for (int attempt = 0; attempt < kTries; ++attempt, step *= 0.5) {
      if (auto moved = chart.exactly_at(step)) {
        state_ = std::move(*moved);
        return;
      }
    }
    throw SolverError(fmt::format("{}: the machine cannot be closed any more on its way along {}", name(),
                                  describe_motion(model_, state_, chart.velocities(step / step.norm()))));
  }

  void name_free_directions(const Chart& chart, const StiffnessSplit& split) {
    free_.clear();
    const MatX& directions = split.free_directions();
    if (directions.cols() == 0) return;
    MatX motions(chart.basis().rows(), directions.cols());
    for (Eigen::Index k = 0; k < directions.cols(); ++k) motions.col(k) = chart.velocities(directions.col(k));
    motions = separate_motions(model_, state_, std::move(motions));
    for (const auto& motion : motions.colwise()) free_.push_back({describe_motion(model_, state_, motion)});
  }

  Equilibrium conclude(int iterations) {
    return {std::move(state_), std::move(evaluation_), iterations, last_step_, std::move(free_), unstable_directions_};
  }

  static constexpr int kPushes = 25;

  const Model& model_;
  Solver& solver_;
  State state_;
  Evaluation evaluation_;
  VecX last_force_;
  std::vector<FreeDirection> free_;
  double time_ = 0.0;
  double last_step_ = 0.0;
  int pushed_ = 0;
  int unstable_directions_ = 0;
};

}  // namespace

Equilibrium find_equilibrium(const Model& model, Solver& solver) {
  return PseudoTransientContinuation(model, solver).run();
}

}  // namespace concord::compare::analyses
