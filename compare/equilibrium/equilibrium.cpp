#include "compare/equilibrium/equilibrium.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <optional>
#include <utility>

#include "common/decompositions.h"
#include "common/error.h"
#include "compare/equilibrium/acceleration_scale.h"
#include "compare/equilibrium/joint_changes.h"
#include "compare/equilibrium/stiffness.h"
#include "compare/verdict/chart.h"
#include "compare/verdict/motion_names.h"
#include "compare/verdict/states.h"

namespace concord::compare {

namespace {

/// How far a search goes in one step of the chart's coordinates. Where a step that is not much shorter than the limit
/// turns back, that halves; where many in a row go on the same way, as far as they may, it doubles with each.
class StepLimit {
 public:
  void shorten(const Chart& chart, VecX& step) {
    constexpr double kSameWay = 0.9;  // cosine
    constexpr double kLong = 0.2;     // of the limit
    constexpr int kManySteps = 10;
    constexpr double kMostTurn = 2.0;  // of a body, rad: what a rotation vector tells for sure
    const State moving = chart.origin_moving(step);
    double turn = 0.0;
    for (const BodyState& body : moving.bodies) turn = std::max(turn, body.omega.norm());
    const VecX way = chart.velocities(step).normalized();
    const double along = way_.size() > 0 ? way.dot(way_) : 0.0;
    if (along < 0.0 && step.norm() > kLong * limit_) limit_ *= 0.5;
    goes_on_ = was_cut_ && along > kSameWay ? goes_on_ + 1 : 0;
    if (goes_on_ > kManySteps && step.norm() / limit_ > turn / kMostTurn) limit_ *= 2.0;
    const double cut = std::max(step.norm() / limit_, turn / kMostTurn);
    was_cut_ = cut > 1.0;
    if (was_cut_) step /= cut;
    way_ = way;
    last_move_ = step.norm();
  }

  /// A step that ends in no closed state was too long.
  void halve() {
    last_move_ *= 0.5;
    limit_ = last_move_;
  }

  [[nodiscard]] double last_move() const { return last_move_; }
  [[nodiscard]] bool was_cut() const { return was_cut_; }
  /// Whether the search runs on along a motion that nothing resists, farther than any machine or in very many steps.
  [[nodiscard]] bool runs_away() const { return goes_on_ > kMostOnOneWay || (goes_on_ > 0 && last_move_ > kFar); }

 private:
  static constexpr int kMostOnOneWay = 300;  // some hundred turns
  static constexpr double kFar = 1e6;

  double limit_ = 0.3;  // of the machine's length, rad
  double last_move_ = limit_;
  bool was_cut_ = false;
  int goes_on_ = 0;  // so many steps
  VecX way_;         // of the last step, a velocity of unit norm
};

/// The search of one machine for its equilibrium.
class EquilibriumSearch {
 public:
  EquilibriumSearch(const Model& model, Solver& solver, const State& start)
      : model_(model), solver_(solver), start_(start), state_(start_), evaluation_(solver.evaluate(state_)) {}

  Equilibrium run() {
    while (found_.iterations < kMostFlowSteps && newton_steps_ < kMostNewtonSteps) {
      ++found_.iterations;
      Chart chart(model_, solver_, state_);
      if (chart.n() == 0) return conclude();
      const VecX f = chart.accelerations(state_, evaluation_);
      force_ = chart.velocities(f);
      find_scale(chart, f);
      is_near_rest_ = is_near_rest_ || f.norm() <= negligible();
      if (!is_near_rest_) {
        flow(chart, f, stiffness_on_the_way(chart, f));
        if (limit_.runs_away()) refuse_pushed(force_);
      } else if (approach(chart, f)) {
        return conclude();
      }
    }
    throw SolverError(fmt::format("{}: no equilibrium in {} steps: at the last one {} still accelerates", name(),
                                  found_.iterations, describe_sense(model_, state_, force_)));
  }

 private:
  [[nodiscard]] std::string name() const { return fmt::format("{}: statics", solver_.name()); }
  [[nodiscard]] double negligible() const { return kNegligibleForce * scale_.reference; }

  void find_scale(const Chart& chart, const VecX& f) {
    scale_ = acceleration_scale(model_, chart, state_, evaluation_);
    scale_.reference = scale_.resolved_reference();
    if (!first_reference_) first_reference_ = std::max(scale_.reference, f.norm());
    scale_.reference = std::max(scale_.reference, kOfFirstReference * *first_reference_);
  }

  /// Accelerations at rest, beside the chart's origin.
  [[nodiscard]] AccelerationsAt at_rest(const Chart& chart) const {
    return [&](const VecX& delta) -> std::optional<VecX> {
      const auto state = chart.place_at(delta);
      if (!state) return std::nullopt;
      const auto evaluation = evaluation_unless_refused(solver_, *state);
      if (!evaluation) return std::nullopt;
      return chart.accelerations(*state, *evaluation);
    };
  }

  /// Pseudo-transient continuation: an implicit Euler step along the accelerations f, shorter than the time in which
  /// the fastest motion grows, so that it does not jump to the other side.
  void flow(Chart& chart, const VecX& f, const MatX& J) {
    const double longest = kLongestTime / scale_.reference;
    VecX pull = f;
    const double growth = split_growth(J, kOfGrowth / longest, pull);
    time_ = std::min(time_ == 0.0 ? kFirstStep / f.norm() : kLongerTime * time_, longest);
    if (growth > 0.0) time_ = std::min(time_, kOfGrowth / growth);
    MatX system = -J;
    system.diagonal().array() += 1.0 / time_;
    move(chart, solve_square(system, pull));
    is_near_rest_ = time_ == longest && !limit_.was_cut() && limit_.last_move() <= kNearRest;
  }

  /// Derivatives that are good enough on the way.
  [[nodiscard]] MatX stiffness_on_the_way(const Chart& chart, const VecX& f) const {
    std::optional<MatX> J;
    if (!hangs_by_way_) J = rough_stiffness(chart, f, at_rest(chart), scale_.reference);
    return J ? std::move(*J) : stiffness_matrix(chart, solver_, at_rest(chart), scale_).J;
  }

  /// The largest growth beyond `least` of a motion along which something pulls [1/s2], or 0. Where the pull is
  /// round-off, as on a pole that stands upright, it is taken out: it must not decide to which side the machine falls.
  [[nodiscard]] double split_growth(const MatX& J, double least, VecX& pull) const {
    const GeneralEigenpairs pairs = eigenpairs(J);
    const Eigen::MatrixXcd left = inverse_of(pairs.vectors);  // rows
    const Eigen::VectorXcd parts = left * pull.cast<std::complex<double>>();
    double growth = 0.0;
    for (Eigen::Index k = 0; k < parts.size(); ++k) {
      const double rate = pairs.values(k).real();
      if (rate <= least) continue;
      const VecX along = (pairs.vectors.col(k) * parts(k)).real();
      if (along.norm() <= negligible()) {
        pull -= along;
      } else {
        growth = std::max(growth, rate);
      }
    }
    return growth;
  }

  /// Newton's method, then a step towards the start; true at the equilibrium that is meant.
  bool approach(Chart& chart, const VecX& f) {
    ++newton_steps_;
    refuse_singular(chart, name());
    const Stiffness stiffness = stiffness_matrix(chart, solver_, at_rest(chart), scale_);
    const StiffnessSplit split(chart, stiffness, scale_, f);
    const int growing = count_growing(stiffness, std::max(kNoGrowth * scale_.reference, split.least()));
    if (growing > 0 && f.norm() > negligible() && way_back_.cols() == 0) {  // the steps were short for another reason
      is_near_rest_ = false;
      flow(chart, f, stiffness.J);
      return false;
    }
    const VecX newton = split.newton_step(f);
    if (!is_at_rest(newton.norm(), f.norm())) {
      found_.last_step = newton.norm();
      move(chart, f.norm() > negligible() ? without_way_back(chart, newton) : newton);
      return false;
    }
    const MatX& directions = split.free_directions();
    found_.step_left = newton.norm();
    found_.free = name_free_directions(model_, chart, directions);
    found_.unstable = growing;
    refuse_if_pushed(chart, split.unmet(f));
    const VecX back = step_back(chart, directions);
    if (back.norm() <= kRoundOffStep || (back.norm() <= kSmallStep && back.norm() >= kNoShorterBack * last_back_)) {
      return true;
    }
    last_back_ = back.norm();
    way_back_ = chart.basis() * directions;
    found_.last_step = 0.0;
    move(chart, back);
    return false;
  }

  /// Newton's steps have become round-off.
  [[nodiscard]] bool is_at_rest(double step, double f) {
    if (step <= kRoundOffStep) return true;
    if (step > kSmallStep || found_.last_step <= 0.0 || step < kNoShorter * found_.last_step) return false;
    return f <= negligible() || ++short_steps_ > kMostShortSteps;
  }

  /// Of the rests that directions without stiffness lead to, towards the one that is nearest to the start.
  /// Places of rest may be curved, or end on the way: a step that led farther away was too long.
  [[nodiscard]] VecX step_back(const Chart& chart, const MatX& directions) {
    if (directions.cols() == 0) return VecX::Zero(chart.n());
    const VecX moved = joint_displacements(model_, start_, state_);
    if (last_back_ > kSeenStep && moved.norm() > last_moved_) part_of_way_back_ *= 0.5;
    last_moved_ = moved.norm();
    MatX rates(moved.size(), directions.cols());
    for (Eigen::Index k = 0; k < directions.cols(); ++k) {
      const VecX of_one = joint_speeds(model_, chart.origin_moving(directions.col(k)));
      // Round-off of the directions must not count the ways of joints that do not move along them.
      const double seen = kLeastSpeed * of_one.lpNorm<Eigen::Infinity>();
      rates.col(k) = (of_one.array().abs() < seen).select(0.0, of_one);
    }
    return -part_of_way_back_ * directions *
           smallest_least_squares(weighed_by_nearness(model_, moved, rates), moved, kRoundOffStep);
  }

  /// While what a step back has strained relaxes, its directions look as if they met stiffness: forces turn with them.
  [[nodiscard]] VecX without_way_back(const Chart& chart, const VecX& step) const {
    if (way_back_.cols() == 0) return step;
    const MatX directions = orthonormal_columns(chart.basis().transpose() * way_back_);
    return step - directions * (directions.transpose() * step);
  }

  void refuse_if_pushed(const Chart& chart, const VecX& unmet) const {
    if (unmet.norm() > std::max(negligible(), scale_.unresolved_along(unmet.normalized()))) {
      refuse_pushed(chart.velocities(unmet));
    }
  }

  [[noreturn]] void refuse_pushed(const VecX& velocities) const {
    throw SolverError(fmt::format(
        "{}: nothing resists {}: it is pushed and meets no stiffness, or too soft a one to rest near, or one "
        "that vanishes with the push, as where a stop begins to press; hold it, or give it a spring",
        name(), describe_sense(model_, state_, velocities)));
  }

  /// Goes as far as the limit and the constraints permit.
  void move(Chart& chart, VecX step) {
    constexpr int kTries = 20;
    limit_.shorten(chart, step);
    std::string refusal;
    for (int attempt = 0; attempt < kTries; ++attempt, step *= 0.5) {
      if (arrive(chart.with_modes_at(step), refusal)) return;
      limit_.halve();
    }
    for (int attempt = 0; refusal.empty() && attempt <= kTries; ++attempt, step *= 2.0)
      refusal = chart.refusal_at(step);
    if (!refusal.empty()) throw SolverError(refusal + ", on the way to the equilibrium");
    throw SolverError(fmt::format("{}: the machine cannot be closed any more on its way along {}", name(),
                                  describe_sense(model_, state_, chart.velocities(step))));
  }

  bool arrive(std::optional<State> moved, std::string& refusal) {
    if (!moved) return false;
    try {
      evaluation_ = solver_.evaluate(*moved);
    } catch (const SolverError& error) {
      refusal = error.what();
      return false;
    }
    state_ = std::move(*moved);
    return true;
  }

  Equilibrium conclude() {
    found_.state = std::move(state_);
    found_.evaluation = std::move(evaluation_);
    return std::move(found_);
  }

  static constexpr int kMostFlowSteps = 1000;
  static constexpr int kMostNewtonSteps = 400;
  static constexpr int kMostShortSteps = 20;         // along a force that bends within them, as that of a stop
  static constexpr double kNegligibleForce = 1e-9;   // of what forces cause
  static constexpr double kOfFirstReference = 1e-3;  // without gravity forces vanish on the way to a rest
  static constexpr double kNoGrowth = 1e-8;          // of what forces cause
  static constexpr double kFirstStep = 0.1;          // of the machine's length, rad
  static constexpr double kLongerTime = 10.0;        // a pseudo time step than the one before
  static constexpr double kLongestTime = 1e2;        // of the time in which forces move the machine by its length
  static constexpr double kOfGrowth = 0.5;           // of the time in which a motion grows
  static constexpr double kNearRest = 1e-2;          // of the machine's length, rad: Newton's method begins
  static constexpr double kSmallStep = 1e-9;         // and may end
  static constexpr double kRoundOffStep = 1e-14;     // and does end
  static constexpr double kNoShorter = 0.3;          // than the step before: what is left is round-off
  static constexpr double kNoShorterBack = 0.9;
  static constexpr double kSeenStep = 1e-6;    // its half square is no round-off of the distance
  static constexpr double kLeastSpeed = 1e-7;  // of the fastest joint's

  const Model& model_;
  Solver& solver_;
  State start_;
  State state_;
  Evaluation evaluation_;
  Equilibrium found_;
  AccelerationScale scale_;  // at the state
  std::optional<double> first_reference_;
  VecX force_;  // accelerations at the state, as velocities of bodies
  StepLimit limit_;
  double time_ = 0.0;
  /// Constraints of velocities alone let the way decide where it ends: both solvers must go the same one.
  bool hangs_by_way_ = std::any_of(model_.joints.begin(), model_.joints.end(),
                                   [](const Joint& joint) { return joint.type->nonholonomic_rows() > 0; });
  bool is_near_rest_ = false;
  int newton_steps_ = 0;
  int short_steps_ = 0;
  MatX way_back_;  // velocities along the directions of the last step back
  double part_of_way_back_ = 1.0;
  double last_back_ = std::numeric_limits<double>::infinity();
  double last_moved_ = std::numeric_limits<double>::infinity();
};

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

Equilibrium find_equilibrium(const Model& model, Solver& solver) {
  return find_equilibrium(model, solver, solver.assemble());
}

Equilibrium find_equilibrium(const Model& model, Solver& solver, const State& start) {
  return EquilibriumSearch(model, solver, start).run();
}

}  // namespace concord::compare
