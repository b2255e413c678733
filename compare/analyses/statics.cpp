#include "compare/analyses/statics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "common/decompositions.h"
#include "common/error.h"
#include "compare/analyses/growth.h"
#include "compare/analyses/stiffness.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/places.h"
#include "compare/verdict/chart.h"
#include "compare/verdict/motion_names.h"

namespace concord::compare::analyses {

namespace {

constexpr int kMostIterations = 300;
constexpr double kLongestStep = 0.3;       // of the machine's length, rad
constexpr double kNegligibleForce = 1e-9;  // of what forces cause
constexpr double kSmallStep = 1e-9;        // Newton's method may end
constexpr double kRoundOffStep = 1e-14;    // and does end
/// The longest pseudo time step, in units of the time in which forces move the machine by its length.
constexpr double kLongestTime = 1e4;

/// The largest change of a joint's or modal coordinate in a step [rad, of the machine's length].
double largest_joint_motion(const Model& model, const Chart& chart, const VecX& step) {
  const State moving = chart.origin_moving(step);
  double largest = 0.0;
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    const auto frame = [&](Side side) { return place(joint.on(side), moving.bodies[joint.on(side).body]); };
    const VecX u = read_motion(*joint.type, relative_motion(frame(Side::parent), frame(Side::child)), moving.q[k]).u;
    const std::vector<bool> turns = turning_speeds(*joint.type);
    for (Eigen::Index c = 0; c < u.size(); ++c) {
      largest = std::max(largest, std::abs(u(c)) / (turns[static_cast<std::size_t>(c)] ? 1.0 : model.length_scale()));
    }
  }
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    if (model.bodies[i].n_modes() == 0) continue;
    const VecX deflections = largest_deflections(model.bodies[i]) / model.length_scale();
    largest = std::max(largest, deflections.cwiseProduct(moving.bodies[i].adot).lpNorm<Eigen::Infinity>());
  }
  return largest;
}

double mass_of(const Body& body) { return body.modal ? body.modal->G(0, 0) : body.mass; }

/// Sums of forces on each body [N]; a torque counts as its force at the machine's length.
std::vector<double> forces_on_bodies(const Model& model, const Evaluation& evaluation) {
  std::vector<double> forces(model.bodies.size(), 0.0);
  const auto add = [&](int body, const Wrench& wrench) {
    forces[body] += std::max(wrench.force.norm(), wrench.torque.norm() / model.length_scale());
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
  return forces;
}

/// What forces cause if the whole machine's mass resists [1/s2]: the largest of gravity and of forces on one body, over
/// the machine's length.
double slow_acceleration(const Model& model, const Evaluation& evaluation) {
  const std::vector<double> forces = forces_on_bodies(model, evaluation);
  double mass = 0.0;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) mass += mass_of(model.bodies[i]);
  double largest = model.gravity.norm();
  if (mass > 0.0) largest = std::max(largest, *std::max_element(forces.begin() + 1, forces.end()) / mass);
  return largest / model.length_scale();
}

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
  const std::vector<double> forces = forces_on_bodies(model, evaluation);
  double largest = model.gravity.norm();
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const double mass = mass_of(model.bodies[i]);
    if (mass > 0.0) largest = std::max(largest, forces[i] / mass);
  }
  return largest / model.length_scale();
}

namespace {

/// Pseudo-transient continuation of one machine to its equilibrium.
class PseudoTransientContinuation {
 public:
  PseudoTransientContinuation(const Model& model, Solver& solver)
      : model_(model), solver_(solver), state_(solver.assemble()) {}

  Equilibrium run() {
    for (int iteration = 1; iteration <= kMostIterations; ++iteration) {
      if (advance(iteration)) return conclude(iteration);
    }
    throw SolverError(fmt::format("{}: no equilibrium in {} steps: at the last one {} still accelerates", name(),
                                  kMostIterations, describe_motion(model_, state_, last_force_)));
  }

 private:
  [[nodiscard]] std::string name() const { return fmt::format("{}: statics", solver_.name()); }

  /// One step; true if the state is at rest already.
  bool advance(int iteration) {
    evaluation_ = solver_.evaluate(state_);
    Chart chart(model_, solver_, state_);
    if (chart.n() == 0) return true;
    const VecX f = chart.accelerations(state_, evaluation_);
    last_force_ = chart.velocities(f);
    const double reference = reference_acceleration(model_, evaluation_);
    const int rigid = chart.n() - chart.n_modal();
    is_cautious_ = iteration * rigid * rigid <= kCautiousSteps;
    if (is_on_the_way() && flow_roughly(chart, f, reference)) return false;
    refuse_singular(chart);
    const AccelerationsAt accelerations = [&](const VecX& delta) { return at_rest(chart, delta); };
    const Stiffness stiffness = stiffness_matrix(chart, solver_, accelerations, reference);
    const StiffnessSplit split(chart, stiffness, reference, f);
    const VecX newton = split.newton_step(f);
    const VecX unmet = split.unmet(f);
    const Growth growth(stiffness, kNoGrowth * reference);
    unstable_directions_ = growth.count();
    name_free_directions(chart, split);
    const bool is_met = unmet.norm() <= kNegligibleForce * reference;
    if (is_met && is_done(newton.norm())) return true;
    const bool by_newton = is_met && growth.count() == 0 && time_ >= longest_time();
    if (!by_newton) lengthen(f, growth);
    refuse_if_pushed(chart, unmet, reference);
    last_step_ = newton.norm();
    move(chart, by_newton ? newton : flow_step(stiffness.J, growth, f));
    return false;
  }

  /// Far from rest derivatives need not be good; for many coordinates they cost most.
  [[nodiscard]] bool is_on_the_way() {
    if (is_cautious_) return false;
    if (time_ < longest_time()) return true;
    return last_move_ >= kNearRest && ++long_steps_ < kLongSteps;
  }

  /// A step with rough derivatives, where these can be had.
  bool flow_roughly(Chart& chart, const VecX& f, double reference) {
    const auto J = rough_stiffness(
        chart, [&](const VecX& delta) { return at_rest(chart, delta); }, reference);
    if (!J) return false;
    const Growth growth({*J, MatX::Zero(J->rows(), J->cols())}, kNoGrowth * reference);
    lengthen(f, growth);
    move(chart, flow_step(*J, growth, f));
    return true;
  }

  /// Neighbours have as many directions of motion as the pose itself, or it is singular: looked at in one of them.
  void refuse_singular(Chart& chart) const {
    VecX direction(chart.n());
    for (Eigen::Index k = 0; k < direction.size(); ++k) direction(k) = std::cos(2.0 * static_cast<double>(k));
    direction.normalize();
    for (const double step : {1e-3, 1e-4, 1e-5, 1e-6}) {
      if (chart.at(step * direction, VecX::Zero(chart.n()))) return;
    }
    throw SingularPose(
        fmt::format("{}: the constraints permit {}, but no closed states with as many directions of motion are found "
                    "along it: the pose is singular",
                    name(), chart.describe(direction)));
  }

  [[nodiscard]] std::optional<VecX> at_rest(const Chart& chart, const VecX& delta) const {
    const auto state = chart.place_at(delta);
    if (!state) return std::nullopt;
    return chart.accelerations(*state, solver_.evaluate(*state));
  }

  /// Newton's steps have become round-off.
  [[nodiscard]] bool is_done(double step) const {
    return step <= kRoundOffStep || (step <= kSmallStep && last_step_ > 0.0 && step >= 0.3 * last_step_);
  }

  /// In the long run a light part, which its mount pulls about, must not shorten the time in which heavy ones settle.
  [[nodiscard]] double longest_time() const {
    return kLongestTime / (is_cautious_ ? reference_acceleration : slow_acceleration)(model_, evaluation_);
  }

  /// Pseudo time steps grow tenfold. Cautious ones stay short enough not to jump to a place from which the machine
  /// falls.
  void lengthen(const VecX& f, const Growth& growth) {
    time_ = time_ == 0.0 ? kLongestStep / (3.0 * f.norm()) : 10.0 * time_;
    time_ = std::min(time_, longest_time());
    if (is_cautious_ && growth.count() > 0) time_ = std::min(time_, 0.5 / growth.steepest());
  }

  /// Implicit Euler; along motions that grow faster than the step can follow, against their growth reversed.
  [[nodiscard]] VecX flow_step(const MatX& J, const Growth& growth, const VecX& f) {
    MatX system = -J;
    if (!is_cautious_) system += growth.reversed_above(0.5 / time_);
    system.diagonal().array() += 1.0 / time_;
    return solve_square(system, f);
  }

  /// A force along a direction without stiffness, which long steps have not carried to where it vanishes.
  void refuse_if_pushed(const Chart& chart, const VecX& unmet, double reference) {
    if (time_ < longest_time() || unmet.norm() <= kNegligibleForce * reference) {
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
    const double longest = is_cautious_ ? step.norm() : largest_joint_motion(model_, chart, step);
    if (longest > kLongestStep) step *= kLongestStep / longest;
    if (!is_cautious_ && step.norm() > reach_) step *= reach_ / step.norm();
    last_move_ = std::min(longest, kLongestStep);
    constexpr int kTries = 20;
    for (int attempt = 0; attempt < kTries; ++attempt, step *= 0.5) {
      if (auto moved = chart.exactly_at(step)) {
        state_ = std::move(*moved);
        reach_ = attempt == 0 ? kMoreReach * reach_ : kMoreReach * step.norm();
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
  static constexpr int kCautiousSteps = 6000;  // times the square of rigid coordinates
  static constexpr int kLongSteps = 30;
  static constexpr double kMoreReach = 1.3;
  static constexpr double kNearRest = 0.1;
  static constexpr double kNoGrowth = 1e-8;  // of what forces cause

  const Model& model_;
  Solver& solver_;
  State state_;
  Evaluation evaluation_;
  VecX last_force_;
  std::vector<FreeDirection> free_;
  double time_ = 0.0;
  double last_step_ = 0.0;
  double last_move_ = kLongestStep;
  /// Longer steps would hardly end in a closed state.
  double reach_ = std::numeric_limits<double>::infinity();
  bool is_cautious_ = true;
  int long_steps_ = 0;
  int pushed_ = 0;
  int unstable_directions_ = 0;
};

}  // namespace

Equilibrium find_equilibrium(const Model& model, Solver& solver) {
  return PseudoTransientContinuation(model, solver).run();
}

}  // namespace concord::compare::analyses
