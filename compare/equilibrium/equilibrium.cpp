#include "compare/equilibrium/equilibrium.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <variant>

#include "common/decompositions.h"
#include "common/error.h"
#include "common/open_evaluation.h"
#include "compare/equilibrium/acceleration_scale.h"
#include "compare/equilibrium/floating_parts.h"
#include "compare/equilibrium/free_directions.h"
#include "compare/equilibrium/growth.h"
#include "compare/equilibrium/step_limit.h"
#include "compare/equilibrium/steps_back.h"
#include "compare/equilibrium/stiffness.h"
#include "compare/states/chart.h"
#include "compare/states/draws.h"
#include "compare/states/motion_names.h"
#include "compare/states/states.h"

namespace concord::compare {

namespace {

constexpr int kMostIterations = 1000;
constexpr double kLengthening = 10.0;      // of pseudo time steps
constexpr double kNegligibleForce = 1e-9;  // of what forces cause
/// The longest pseudo time step, in units of the time in which forces move the machine by its length.
constexpr double kLongestTime = 1e4;

/// Pseudo-transient continuation of one machine to its equilibrium.
class PseudoTransientContinuation {
 public:
  PseudoTransientContinuation(const Model& model, Solver& solver, const State& start)
      : model_(model),
        solver_(solver),
        open_(dynamic_cast<OpenEvaluation*>(&solver)),
        floating_(model),
        start_(start),
        state_(start_),
        evaluation_(solver.evaluate(state_)),
        limit_(model),
        steps_back_(model, start_) {}

  Equilibrium run() {
    int iteration = 1;
    for (; iteration <= kMostIterations; ++iteration) {
      if (advance(iteration)) return conclude(iteration);
    }
    throw SolverError(fmt::format("{}: no equilibrium in {} steps: at the last one {} still accelerates", name(),
                                  iteration - 1, describe_motion(model_, state_, last_force_)));
  }

 private:
  [[nodiscard]] std::string name() const { return fmt::format("{}: statics", solver_.name()); }

  /// One step; true if the state is at rest already.
  bool advance(int iteration) {
    Chart chart(model_, solver_, state_);
    if (chart.n() == 0) return true;
    const VecX f = chart.accelerations(state_, evaluation_);
    last_force_ = chart.velocities(f);
    scale_ = acceleration_scale(model_, chart, state_, evaluation_);
    scale_.reference = least_reference(scale_.resolved_reference());
    const double reference = scale_.reference;
    const double negligible = kNegligibleForce * reference;
    const int rigid = chart.n() - chart.n_modal();
    is_cautious_ = std::max(iteration, kFewSteps) * rigid * rigid <= kCautiousSteps;
    if (is_on_the_way() && flow_roughly(chart, f, reference)) return false;
    refuse_singular(chart, name());
    const Stiffness stiffness = stiffness_here(chart, f.norm());
    const StiffnessSplit split(chart, stiffness, scale_, f);
    const VecX newton = split.newton_step(f);
    step_left_ = newton.norm();
    const VecX unmet = split.unmet(f);
    const Growth growth(stiffness, std::max(kNoGrowth * reference, split.least()));
    unstable_directions_ = growth.count();
    has_free_directions_ = split.free_directions().cols() > 0;
    const bool is_met = unmet.norm() <= negligible || is_unresolved(unmet);
    if (is_met && is_done(newton.norm(), f.norm() <= negligible)) {
      if (put_floating_parts_back(chart, stiffness.J) || step_back(chart, split.free_directions())) return false;
      free_ = name_free_directions(model_, chart, split.free_directions());
      return true;
    }
    const VecX pull = growth.without_negligible(f, kNegligibleForce * std::max(reference, f.norm()));
    const bool falls = growth.count() > 0 && pull == f;
    const bool is_nearly_met = is_met || unmet.norm() <= kNearlyMet * f.norm();
    const bool by_newton = !falls && is_nearly_met && kLengthening * time_ >= kNearlyAll * longest_time();
    if (!by_newton) lengthen(f, growth, falls);
    refuse_if_pushed(chart, unmet, negligible);
    last_step_ = newton.norm();
    const VecX step =
        by_newton ? newton : not_free_alone(flow_step(stiffness.J, growth, pull, falls), split.free_directions());
    move(chart, step);
    return false;
  }

  [[nodiscard]] bool is_unresolved(const VecX& f) const { return f.norm() <= scale_.unresolved_along(f.normalized()); }

  /// Without gravity forces vanish on the way to a rest: what counts then is what they were at the start.
  [[nodiscard]] double least_reference(double reference) {
    if (!first_reference_) first_reference_ = reference;
    return std::max(reference, kOfFirstReference * *first_reference_);
  }

  /// In steps so short that it hardly changes, the stiffness of a machine with many coordinates is found once; anew
  /// where accelerations f have become so much smaller that what their turning feigned counts now, or where directions
  /// without stiffness say which rest is nearest to the start.
  [[nodiscard]] Stiffness stiffness_here(const Chart& chart, double f) {
    moved_since_stiffness_ += limit_.last_move();
    const bool feigns_more = force_at_stiffness_ > std::max(10.0 * f, kRoundOffStep * scale_.reference);
    const double reach = has_free_directions_ ? kSameDirections : kNearRest;
    if (!is_cautious_ && !feigns_more && moved_since_stiffness_ < reach && last_basis_.cols() == chart.n()) {
      const MatX turn = chart.basis().transpose() * last_basis_;
      const MatX size = turn.cwiseAbs();
      last_stiffness_ = {turn * last_stiffness_.J * turn.transpose(), size * last_stiffness_.error * size.transpose()};
    } else {
      last_stiffness_ = stiffness_matrix(chart, solver_, at_rest(chart), scale_);
      force_at_stiffness_ = f;
      moved_since_stiffness_ = 0.0;
    }
    last_basis_ = chart.basis();
    return last_stiffness_;
  }

  /// What a step does along directions without stiffness grows with the time that it stands for, and must not leave
  /// nothing of it for the others when it is shortened.
  [[nodiscard]] VecX not_free_alone(VecX step, const MatX& directions) const {
    constexpr double kMost = 4.0;  // times the limit: as much as is cut and goes on
    const VecX along = directions * (directions.transpose() * step);
    const double most = std::max(kMost * limit_.limit(), (step - along).norm());
    if (along.norm() > most) step -= along * (1.0 - most / along.norm());
    return step;
  }

  /// Far from rest derivatives need not be good; for many coordinates they cost most. Directions without stiffness ask
  /// for good ones: rough ones would lead along them.
  [[nodiscard]] bool is_on_the_way() {
    if (is_cautious_ || has_free_directions_) return false;
    if (time_ < longest_time()) return true;
    return limit_.last_move() >= kNearRest && ++long_steps_ < kLongSteps;
  }

  /// A step with rough derivatives, where these can be had.
  bool flow_roughly(Chart& chart, const VecX& f, double reference) {
    const auto J = rough_stiffness(chart, f, at_rest(chart), reference);
    last_basis_.resize(0, 0);
    if (!J) return false;
    const Growth growth({*J, MatX::Zero(J->rows(), J->cols())}, kNoGrowth * reference);
    const VecX pull = growth.without_negligible(f, kNegligibleForce * std::max(reference, f.norm()));
    const bool falls = growth.count() > 0 && pull == f;
    lengthen(f, growth, falls);
    move(chart, flow_step(*J, growth, pull, falls));
    return true;
  }

  /// Accelerations at rest, beside the chart's origin: to first order, if the solver evaluates what is open.
  [[nodiscard]] AccelerationsAt at_rest(const Chart& chart) const {
    return [&](const VecX& delta) -> std::optional<VecX> {
      auto state = open_ != nullptr ? std::optional(chart.moved_by(delta)) : chart.place_at(delta);
      if (!state) return std::nullopt;
      auto evaluation = open_ != nullptr ? open_evaluation(*state) : evaluation_unless_refused(solver_, *state);
      if (!evaluation) return std::nullopt;
      floating_.turn_back(chart.origin(), *state, *evaluation);
      return chart.accelerations(*state, *evaluation);
    };
  }

  [[nodiscard]] std::optional<Evaluation> open_evaluation(const State& state) const {
    try {
      return open_->evaluate_open(state);
    } catch (const SolverError&) {  // a deformation out of range, or ends of a spring that meet
      return std::nullopt;
    }
  }

  /// False where there is no step back to make.
  bool step_back(Chart& chart, const MatX& directions) {
    limit_.begin_anew();
    StepsBack::Next next = steps_back_.next(chart, directions, {state_, evaluation_}, limit_.limit());
    if (const auto* step = std::get_if<VecX>(&next)) {
      last_step_ = 0.0;
      move(chart, *step);
    } else if (auto* nearest = std::get_if<Rest>(&next)) {
      last_step_ = 0.0;
      state_ = std::move(nearest->state);
      evaluation_ = std::move(nearest->evaluation);
    }
    return !std::holds_alternative<std::monostate>(next);
  }

  /// Of the rests of a floating part that no force from elsewhere tells apart, the one where it starts is meant; false
  /// where there is none, where stiffness foretells the force that is met there, or where the machine has come there.
  bool put_floating_parts_back(const Chart& here, const MatX& J) {
    constexpr double kNearlyAtRest = 1e-3;  // of what forces cause: what round-off of stiff modes is relaxes
    constexpr double kUnexpected = 0.5;     // of the force there
    if (std::exchange(is_put_back_, true)) return false;
    auto state = floating_.put_back(start_, state_);
    if (!state) return false;
    auto evaluation = evaluation_unless_refused(solver_, *state);
    if (!evaluation) return false;
    const VecX force = here.accelerations(*state, *evaluation);
    const VecX expected = J * here.coordinates_of(displacement(state_, *state));
    const bool is_felt = force.norm() > kNegligibleForce * scale_.reference;
    if (is_felt && (force - expected).norm() <= kUnexpected * force.norm()) return false;
    const Chart chart(model_, solver_, *state);
    if (chart.accelerations(*state, *evaluation).norm() > kNearlyAtRest * scale_.reference) return false;
    state_ = std::move(*state);
    evaluation_ = std::move(*evaluation);
    last_step_ = 0.0;
    last_basis_.resize(0, 0);
    return true;
  }

  /// Newton's steps have become round-off; short ones that do not shrink may also lead along a force that bends within
  /// them, as that of a stop on the first part of its way.
  [[nodiscard]] bool is_done(double step, bool is_at_rest) {
    if (step <= kRoundOffStep) return true;
    if (step > kSmallStep || last_step_ <= 0.0 || step < 0.3 * last_step_) return false;
    return is_at_rest || ++short_steps_ > kMostShortSteps;
  }

  [[nodiscard]] double longest_time() const { return kLongestTime / scale_.reference; }

  /// Pseudo time steps grow, tenfold as a rule. Cautious ones stay short enough not to jump to a place from which the
  /// machine falls.
  void lengthen(const VecX& f, const Growth& growth, bool falls) {
    time_ = time_ == 0.0 ? limit_.limit() / (3.0 * f.norm()) : kLengthening * time_;
    time_ = std::min(time_, longest_time());
    if (is_cautious_ && falls) time_ = std::min(time_, 0.5 / growth.steepest());
  }

  /// Implicit Euler; along motions that grow faster than the step can follow, against their growth reversed.
  [[nodiscard]] VecX flow_step(const MatX& J, const Growth& growth, const VecX& f, bool falls) {
    MatX system = -J;
    if (!is_cautious_ || !falls) system += growth.reversed_above(0.5 / time_);
    system.diagonal().array() += 1.0 / time_;
    return solve_square(system, f);
  }

  /// A force along a direction without stiffness, which long steps have not carried to where it vanishes.
  void refuse_if_pushed(const Chart& chart, const VecX& unmet, double negligible) {
    if (time_ < longest_time() || unmet.norm() <= negligible || is_unresolved(unmet)) {
      pushed_ = 0;
      return;
    }
    if (limit_.goes_on() || ++pushed_ < kPushes) return;
    const VecX pushed = chart.velocities(unmet);
    throw SolverError(fmt::format(
        "{}: nothing resists {}: it is pushed and meets no stiffness, or too soft a one to rest near, or one "
        "that vanishes with the push, as where a stop begins to press; hold it, or give it a spring",
        name(), describe_motion(model_, state_, pushed)));
  }

  void move(Chart& chart, VecX step) {
    limit_.shorten(chart, step);
    constexpr int kTries = 20;
    std::string refusal_there;
    for (int attempt = 0; attempt < kTries; ++attempt, step *= 0.5) {
      if (!arrive(chart.with_modes_at(step), refusal_there)) {
        limit_.halve();
        continue;
      }
      return;
    }
    if (!refusal_there.empty()) {
      throw SolverError(refusal_there + ", on the way to the equilibrium");
    }
    for (int attempt = 0; attempt <= kTries; ++attempt, step *= 2.0) {
      if (const std::string refusal = chart.refusal_at(step); !refusal.empty()) throw SolverError(refusal);
    }
    throw SolverError(fmt::format("{}: the machine cannot be closed any more on its way along {}", name(),
                                  describe_motion(model_, state_, chart.velocities(step / step.norm()))));
  }

  /// Goes there, unless the machine cannot be closed or evaluated there: a shorter step may do.
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

  Equilibrium conclude(int iterations) {
    return {std::move(state_), std::move(evaluation_), iterations, last_step_,
            std::move(free_),  unstable_directions_,   step_left_};
  }

  static constexpr int kPushes = 25;
  static constexpr double kNearlyMet = 1e-3;   // what forces that are of second order feign along free directions
  static constexpr double kNearlyAll = 0.9;    // the longest time grows a little while forces fall
  static constexpr int kCautiousSteps = 6000;  // times the square of rigid coordinates
  static constexpr int kFewSteps = 4;          // for which caution is not worth its derivatives
  static constexpr int kLongSteps = 30;
  static constexpr int kMostShortSteps = 20;
  static constexpr double kNearRest = 1e-6;  // of the length, rad
  static constexpr double kSameDirections = 1e-12;
  static constexpr double kOfFirstReference = 1e-3;
  static constexpr double kNoGrowth = 1e-8;  // of what forces cause

  const Model& model_;
  Solver& solver_;
  OpenEvaluation* open_;  // of the same solver; null where it offers none
  FloatingParts floating_;
  State start_;
  State state_;
  Evaluation evaluation_;
  VecX last_force_;
  bool has_free_directions_ = false;
  std::vector<FreeDirection> free_;
  Stiffness last_stiffness_;
  double moved_since_stiffness_ = 0.0;
  double force_at_stiffness_ = 0.0;  // size of the accelerations where it was found [1/s2]
  MatX last_basis_;                  // of the chart in which it is, or none
  std::optional<double> first_reference_;
  AccelerationScale scale_;  // at the state
  double time_ = 0.0;
  double last_step_ = 0.0;
  double step_left_ = 0.0;
  StepLimit limit_;
  bool is_cautious_ = true;
  int long_steps_ = 0;
  int pushed_ = 0;
  int short_steps_ = 0;
  StepsBack steps_back_;
  bool is_put_back_ = false;
  int unstable_directions_ = 0;
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
  return PseudoTransientContinuation(model, solver, start).run();
}

}  // namespace concord::compare
