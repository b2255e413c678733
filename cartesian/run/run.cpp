#include "cartesian/run/run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "cartesian/bodies/joint_coordinates.h"
#include "cartesian/dynamics/evaluation.h"
#include "cartesian/dynamics/state_scales.h"
#include "cartesian/rank/closing.h"
#include "cartesian/rank/state_check.h"
#include "cartesian/run/pose_watch.h"
#include "cartesian/run/stepper.h"
#include "cartesian/start/open_joint.h"
#include "common/error.h"
#include "common/evaluation_limit.h"
#include "common/growth_watch.h"
#include "common/laws/break_times.h"
#include "common/line_watch.h"

namespace concord::cartesian {

namespace {

/// Holds the regimes that tires and stops are in for the time of a run.
struct FrozenRegimes {
  AppliedForces& applied;

  explicit FrozenRegimes(AppliedForces& forces) : applied(forces) { applied.freeze_regimes(true); }
  ~FrozenRegimes() { applied.freeze_regimes(false); }
  FrozenRegimes(const FrozenRegimes&) = delete;
  FrozenRegimes& operator=(const FrozenRegimes&) = delete;
};

/// Lets a sample be evaluated in the regimes that its state is in, as every single state is; then the integrator keeps
/// its own again. They differ where an event falls on a sample.
class RegimesOfSample {
 public:
  explicit RegimesOfSample(AppliedForces& forces) : applied_(forces) {
    if (!applied_.has_regimes()) return;
    kept_ = applied_.regimes();
    applied_.freeze_regimes(false);
  }
  ~RegimesOfSample() {
    if (applied_.has_regimes()) applied_.keep_regimes(kept_);
  }
  RegimesOfSample(const RegimesOfSample&) = delete;
  RegimesOfSample& operator=(const RegimesOfSample&) = delete;

 private:
  AppliedForces& applied_;
  RegimesOfAll kept_;
};

/// How much more an evaluation costs where Newton's method takes it.
constexpr double kCostOfNewton = 3.0;

std::string integrator_of(const RunOptions& options) {
  return options.integrator.empty() ? integrator_names().front() : options.integrator;
}

std::unique_ptr<Stepper> make_stepper(Dynamics& dynamics, const RunOptions& options, const MotionState& first) {
  const std::string chosen = integrator_of(options);
  // Errors of single steps add up over a run: each step is held to a part of what is asked, more so where steps are
  // many.
  const Tolerance of_gauss{std::max(0.001 * options.rtol, 3e-15), options.until};
  if (chosen == "gauss") return make_collocation_stepper(dynamics, first, of_gauss);
  const Tolerance of_ida{std::max(0.01 * options.rtol, 1e-13), options.until};
  if (chosen == "ida") return make_ida_stepper(dynamics, first, of_ida);
  throw InputError(
      {dynamics.equations().model().file, 0, 0},
      fmt::format("cartesian: unknown integrator '{}'; it has {}", chosen, fmt::join(integrator_names(), ", ")));
}

/// The first state of a run, in which the equations are solved with independent rows.
MotionState begin_motion(Dynamics& dynamics, const MachineRank& machine, const State& start,
                         const RunOptions& options) {
  Equations& equations = dynamics.equations();
  MotionState motion{VecX::Zero(equations.layout().n_q()), VecX::Zero(equations.layout().n_Y()), 0.0};
  require_shape(equations.model(), start);
  equations.layout().unpack(start, motion.q, motion.Y);
  equations.count_turns_from(start);
  equations.update(0.0, motion.q, motion.Y);
  if (options.start) {
    refuse_open(equations, start, motion.q, motion.Y);
    refuse_other_branch(equations, start);
  }
  (void)solve_with_independent_rows(dynamics, machine);
  return motion;
}

/// From the start on, where the forces were updated last.
LineWatch watch_lines(const Equations& equations) {
  LineWatch lines("cartesian", equations.length());
  lines.pass(0.0, equations.applied().spring_lines(0.0));
  return lines;
}

class Run {
 public:
  Run(Dynamics& dynamics, const MachineRank& machine, const State& start, const RunOptions& options)
      : dynamics_(dynamics),
        equations_(dynamics.equations()),
        machine_(machine),
        options_(options),
        turns_(start.q),
        speeds_(zero_speeds(equations_.model())),
        motion_(begin_motion(dynamics, machine, start, options)),
        held_(equations_.applied()),
        stepper_(make_stepper(dynamics, options, motion_)),
        lines_(watch_lines(equations_)),
        watch_(dynamics, machine.generic, 0.0, motion_),
        evaluation_limit_({.solver = "cartesian",
                           .integrator = integrator_of(options),
                           .until = options.until,
                           .most = options.most_evaluations,
                           .foresees_end = options.foresees_end,
                           .cost = options.integrator == "ida" ? kCostOfNewton : 1.0}),
        breaks_(break_times(equations_.model(), options.until)),
        next_break_(breaks_.begin()),
        shares_(equations_.constraints()) {}

  Trajectory integrate(const Progress& progress) {
    Trajectory trajectory;
    trajectory.samples.reserve(options_.samples + 1);
    measure_round_off(equations_, 0.0, motion_.q, shares_);
    trajectory.samples.push_back(sample(0.0, trajectory.statistics));
    GrowthWatch growth(equations_.model(), trajectory.samples.front().state);
    for (int k = 1; k <= options_.samples; ++k) {
      const double t = k == options_.samples ? options_.until : options_.until * k / options_.samples;
      while (reached_ < t) {
        step_toward(t);
        if (progress) progress(reached_);
      }
      close_at_output(t);
      trajectory.samples.push_back(sample(t, trajectory.statistics));
      growth.follow(trajectory.samples.back().state, "cartesian");
    }
    trajectory.statistics.steps = stepper_->steps();
    trajectory.statistics.evaluations = stepper_->evaluations();
    trajectory.statistics.largest_work = stepper_->largest_work();
    return trajectory;
  }

 private:
  /// One step of the integrator, not past t nor past a time at which a law changes its formula, and all that watches
  /// the motion.
  void step_toward(double t) {
    const bool breaks_first = next_break_ != breaks_.end() && *next_break_ <= t;
    reached_ = step(breaks_first ? *next_break_ : t);
    motion_ = stepper_->motion();
    count_turns();
    require_held_regimes();
    lines_.pass(reached_, equations_.applied().spring_lines(reached_));
    lines_.settle();
    const bool has_new_rows = watch_.follow(reached_, motion_, !stepper_->is_within_step());
    const bool at_break = breaks_first && reached_ >= *next_break_;
    if (at_break) ++next_break_;
    if (has_new_rows || at_break) stepper_->begin_anew();
  }

  double step(double t) {
    try {
      const double reached = stepper_->step(t, next_break_ != breaks_.end() ? *next_break_ : options_.until);
      evaluation_limit_.require(reached, stepper_->evaluations());
      return reached;
    } catch (const SingularPose&) {
      throw;
    } catch (const SolverError& error) {
      watch_.explain_stop(error.what());
      throw;
    }
  }

  /// Follows the turn angles step by step, so that none passes half a turn unseen.
  void count_turns() {
    equations_.update(reached_, motion_.q, motion_.Y);
    read_joint_coordinates(equations_.model(), equations_.moving_constraints(), turns_, speeds_);
    equations_.count_turns_from(turns_);
    equations_.applied().follow_spring_turns();
  }

  /// Forces are those of their laws: not the ones of a regime whose end was missed.
  void require_held_regimes() {
    AppliedForces& applied = equations_.applied();
    const std::optional<AppliedForceIndex> departed = applied.departed(equations_.moving_constraints(), reached_);
    if (departed && departed_) {
      throw SolverError(
          fmt::format("cartesian: at t = {:.6g} s the force of {} is not what its law says: the end of its regime was "
                      "missed, which is a fault of the program",
                      reached_, applied.name_of_regime(*departed)));
    }
    departed_ = departed.has_value();
  }

  void close_at_output(double t) {
    const Solution& solution = dynamics_.solve_at(t, motion_.q, motion_.Y, Pivots::kept);
    shares_ = dynamics_.project(solution, t, motion_.q, motion_.Y);
    if (machine_.generic < equations_.constraints().n_rows()) close_all_rows(t);
  }

  /// Rows that were left out follow from the others with their round-off magnified: closes the motion in them all.
  void close_all_rows(double t) {
    const Closing closing =
        close_machine(equations_, t, Hold::constraints, machine_.closing_modes, motion_.q, motion_.Y);
    if (!closing.closed) {
      throw SolverError(
          fmt::format("cartesian: at t = {:.6g} s {} do not close: position residual {:.2g}, velocity residual {:.2g}",
                      t, named_open(closing), closing.position_residual, closing.velocity_residual));
    }
    measure_round_off(equations_, t, motion_.q, shares_);
  }

  Sample sample(double t, SolverStatistics& statistics) {
    const RegimesOfSample own(equations_.applied());
    equations_.update(t, motion_.q, motion_.Y);
    note_residuals(statistics);
    const Solution& solution = dynamics_.solve(Pivots::fresh);
    Sample result{reported_state(equations_, motion_.q, motion_.Y, turns_), reported_evaluation(equations_, solution),
                  motion_.work};
    turns_ = result.state.q;
    return result;
  }

  /// At the last update: rows by their sizes, velocities by the largest speed.
  void note_residuals(SolverStatistics& statistics) const {
    double largest = largest_residual(equations_, equations_.residual(), &shares_.terms);
    const double rate = largest_residual(equations_, equations_.velocity_residual());
    if (rate > 0.0) largest = std::max(largest, rate / largest_rate(equations_, equations_.time(), motion_.Y));
    statistics.max_constraint = std::max(statistics.max_constraint, largest);
  }

  Dynamics& dynamics_;
  Equations& equations_;
  const MachineRank& machine_;
  const RunOptions& options_;
  std::vector<VecX> turns_;   // joint coordinates, which turns are counted from
  std::vector<VecX> speeds_;  // of joints
  MotionState motion_;
  FrozenRegimes held_;
  std::unique_ptr<Stepper> stepper_;
  LineWatch lines_;
  PoseWatch watch_;
  EvaluationLimit evaluation_limit_;
  std::vector<double> breaks_;  // times at which a law changes its formula
  std::vector<double>::const_iterator next_break_;
  RoundOffShares shares_;
  double reached_ = 0.0;
  bool departed_ = false;  // some force from its law, at the end of the last step
};

}  // namespace

std::vector<std::string> integrator_names() { return {"gauss", "ida"}; }

Trajectory run(Dynamics& dynamics, const MachineRank& machine, const State& start, const RunOptions& options,
               const Progress& progress) {
  return Run(dynamics, machine, start, options).integrate(progress);
}

}  // namespace concord::cartesian
