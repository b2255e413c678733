#include "relative/integration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include "common/laws/break_times.h"
#include "common/sundials.h"
#include "relative/line_watch.h"
#include "relative/regime_events.h"
#include "relative/singularity_watch.h"
#include "relative/stepper.h"

namespace concord::relative {

namespace {

constexpr double kLargestModalResidual = 1e-8;
/// Errors of single steps add up over a run: each is held to this part of the tolerance asked of the run, but not below
/// what round-off lets the formulas see.
constexpr double kStepShare = 0.01;
constexpr double kFinestStep = 2e-15;
/// Work is not held to less than this part of the largest that it has been: the round-off of time itself, in laws that
/// change fast, leaves more in the power of drivers than steps could remove.
constexpr double kFinestWork = 1e-12;

/// More evaluations than this within this part of a run get nowhere.
constexpr long kMostEvaluationsWithoutAdvance = 300'000;
constexpr double kLeastAdvance = 1e-3;
/// Times closer than this part of a run are one.
constexpr double kSameTime = 1e-13;

/// The integrated numbers y = [coordinates and speeds that are not driven; work]. Speeds of cut joints follow from the
/// tree and are not integrated; their coordinates are, so that turns are counted and measuring starts close by.
class Variables {
 public:
  explicit Variables(const Equations& equations) {
    const Model& model = equations.model();
    const Topology& topology = equations.topology();
    std::vector<char> q_is_driven(topology.n_q, 0);
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      for (const Driver& driver : model.joints[k].drivers) {
        q_is_driven[topology.joints[k].first_q + first_q(*model.joints[k].type, driver.word) + driver.component] = 1;
      }
    }
    for (int c = 0; c < topology.n_q; ++c) {
      if (q_is_driven[c] == 0) q_.push_back(c);
    }
    for (int c = 0; c < topology.n_tree_u; ++c) {
      if (equations.driven()[c] == 0) u_.push_back(c);
    }
  }

  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(q_.size() + u_.size()) + 1; }
  [[nodiscard]] Eigen::Index n_q() const { return static_cast<Eigen::Index>(q_.size()); }
  [[nodiscard]] Eigen::Index work() const { return size() - 1; }

  void unpack(const Eigen::Ref<const VecX>& y, Coordinates& coordinates) const {
    for (std::size_t c = 0; c < q_.size(); ++c) coordinates.q(q_[c]) = y(c);
    for (std::size_t c = 0; c < u_.size(); ++c) coordinates.u(u_[c]) = y(q_.size() + c);
  }

  /// Takes whole turns off the coordinates.
  void take_off(const VecX& turns, Eigen::Ref<VecX> y) const {
    for (std::size_t c = 0; c < q_.size(); ++c) y(c) = add_turns(y(c), -turns(q_[c]));
  }

  /// Writes all of y but the work.
  void pack(const VecX& q, const VecX& u, Eigen::Ref<VecX> y) const {
    for (std::size_t c = 0; c < q_.size(); ++c) y(c) = q(q_[c]);
    for (std::size_t c = 0; c < u_.size(); ++c) y(q_.size() + c) = u(u_[c]);
  }

 private:
  std::vector<int> q_;
  std::vector<int> u_;
};

/// Sizes that accuracy is measured by: the machine's length, its rate, its energy.
class Sizes {
 public:
  /// `until` [s] gives a rate to a machine at rest that nothing else gives one.
  Sizes(const Equations& equations, const Scales& scales, const Coordinates& start, double until) {
    const Model& model = equations.model();
    const Topology& topology = equations.topology();
    const VecX speed_units = scales.speeds();
    double rate = std::sqrt(model.gravity.norm() / scales.length());
    for (int c = 0; c < topology.n_u; ++c) rate = std::max(rate, std::abs(start.u(c)) / speed_units(c));
    if (rate == 0.0) rate = 1.0 / until;
    q_ = VecX::Ones(topology.n_q);
    u_ = rate * speed_units;
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      const Mobilizer& mobilizer = equations.kinematics().mobilizer(static_cast<int>(k));
      for (int c = 0; c < mobilizer.n_u(); ++c) {
        if (mobilizer.kind(c).is_length) q_(topology.joints[k].first_q + c) = scales.length();
      }
    }
    for (const Span& modes : topology.modes) {
      // Deformations are small parts of the length.
      q_.segment(modes.first_q, modes.n_q) = kSmallDeformation * speed_units.segment(modes.first_u, modes.n_u);
      u_.segment(modes.first_u, modes.n_u) *= kSmallDeformation;
    }
    // Work is compared with the kinetic energy that the machine's own rate stands for.
    double mass = 0.0;
    for (const Body& body : model.bodies) mass += body.modal ? body.modal->G(0, 0) : body.mass;
    work_ = mass * rate * rate * scales.length() * scales.length();
  }

  [[nodiscard]] VecX of(const Variables& variables) const {
    VecX sizes = VecX::Ones(variables.size());
    variables.pack(q_, u_, sizes);
    sizes(variables.work()) = work_ > 0.0 ? work_ : 1.0;
    return sizes;
  }

 private:
  static constexpr double kSmallDeformation = 1e-3;
  VecX q_;
  VecX u_;
  double work_ = 1.0;
};

/// What the callbacks of one integration share.
struct Run {
  Equations& equations;
  Assembly& assembly;
  Variables variables;
  Coordinates coordinates;
  VecX qdot;
  bool has_work = false;
  long evaluations = 0;
  SingularityWatch watch;
  LineWatch lines{};
  std::string advice_if_stiff{};  // ends a message
  double largest_work = 0.0;
  std::string last_reason{};  // of the last evaluation or projection that failed
  bool is_singular = false;   // whether that was a singular pose
  double rtol = 0.0;
  VecX sizes{};
  double until = 0.0;
  double paced_from = 0.0;
  long evaluations_before = 0;

  void remember(const SolverError& error) {
    last_reason = error.what();
    is_singular = dynamic_cast<const SingularPose*>(&error) != nullptr;
  }

  /// ydot(t, y) (R73).
  void evaluate(double t, const Eigen::Ref<const VecX>& y, Eigen::Ref<VecX> ydot) {
    ++evaluations;
    variables.unpack(y, coordinates);
    equations.compute_accelerations(t, coordinates.q, coordinates.u);
    equations.compute_qdot(qdot);
    variables.pack(qdot, equations.udot(), ydot);
    ydot(variables.work()) = 0.0;
    if (!has_work) return;
    if (equations.has_drivers()) equations.compute_reactions();
    ydot(variables.work()) = equations.power();
  }

  /// Error weights: rtol of the size for coordinates, so that a tolerance does not grow with the number of turns; of
  /// the size and the value for speeds, of the size and the largest value so far for work, which drivers may take back
  /// to nothing. None below the round-off of the number itself (R74).
  void weigh(const Eigen::Ref<const VecX>& y, Eigen::Ref<VecX> weights) const {
    constexpr double kLeastWeighed = 1e-15;
    const Eigen::Index n_rates = y.size() - variables.n_q();
    weights = sizes;
    weights.tail(n_rates) += y.tail(n_rates).cwiseAbs();
    weights(variables.work()) = 0.0;
    weights = (rtol * weights).cwiseMax(kLeastWeighed * y.cwiseAbs());
    weights(variables.work()) = std::max(rtol, kFinestWork) * (sizes(variables.work()) + largest_work);
    weights = weights.cwiseInverse();
  }

  /// Refuses steps that get nowhere, as where a loop is driven into a pose that locks it.
  void require_advance(double t) {
    if (t - paced_from > kLeastAdvance * until) {
      paced_from = t;
      evaluations_before = evaluations;
    }
    if (evaluations - evaluations_before <= kMostEvaluationsWithoutAdvance) return;
    const std::string place = equations.closure().n_rows() > 0
                                  ? fmt::format("; {} has the largest multiplier there",
                                                equations.closure().worst_place(equations.loops().lambda()))
                                  : "";
    throw SolverError(
        fmt::format("{} evaluations were needed for {:.1e} s: something there locks, or is too stiff for this "
                    "integrator{}{}",
                    kMostEvaluationsWithoutAdvance, t - paced_from, advice_if_stiff, place));
  }

  /// Counts apart the turns of coordinates that have made many, so that they keep their digits; true if there are any.
  bool count_turns(Eigen::Ref<VecX> y) {
    constexpr double kMany = 10.0;
    const VecX more = equations.kinematics().whole_turns(coordinates.q, kMany);
    if (more.isZero(0.0)) return false;
    variables.take_off(more, y);
    watch.count_turns(more);
    equations.count_turns(equations.kinematics().turns() + more);
    return true;
  }

  void project(double t, Eigen::Ref<VecX> y) {
    require_advance(t);
    largest_work = std::max(largest_work, std::abs(y(variables.work())));
    coordinates.t = t;
    variables.unpack(y, coordinates);
    assembly.project(coordinates);
    variables.pack(coordinates.q, coordinates.u, y);
    watch.pass(coordinates);
    equations.loops().keep_rows();
    follow_lines();
  }

  void follow_lines() {
    if (!equations.applied_forces().has_line_springs()) return;
    equations.update_forces(coordinates.t, coordinates.q, coordinates.u);
    lines.pass(coordinates.t, equations.applied_forces());
  }
};

/// A pose that cannot be evaluated asks the integrator for a smaller step.
int right_side(realtype t, N_Vector y, N_Vector ydot, void* user_data) {
  auto& run = *static_cast<Run*>(user_data);
  try {
    run.evaluate(t, sundials::view(y), sundials::view(ydot));
    return sundials::view(ydot).allFinite() ? 0 : 1;
  } catch (const SolverError& error) {
    run.remember(error);
    return 1;
  }
}

int project_step(realtype t, N_Vector y, void* user_data) {
  auto& run = *static_cast<Run*>(user_data);
  try {
    run.project(t, sundials::view(y));
    return 0;
  } catch (const SolverError& error) {
    run.remember(error);
    return -1;
  }
}

int error_weights(N_Vector y, N_Vector weights, void* user_data) {
  static_cast<const Run*>(user_data)->weigh(sundials::view(y), sundials::view(weights));
  return 0;
}

std::string chosen_integrator(const Model& model, const std::string& wanted) {
  const std::vector<std::string> known = integrator_names(model);
  if (wanted.empty()) return known.front();
  if (std::find(known.begin(), known.end(), wanted) != known.end()) return wanted;
  throw InputError({model.file, 0, 0}, fmt::format("the relative solver has no integrator '{}'; it has {}", wanted,
                                                   fmt::join(known, ", ")));
}

[[noreturn]] void throw_stopped(double t, const Run& run, const std::string& message) {
  const std::string& reason = run.last_reason.empty() ? message : run.last_reason;
  const std::string plain = reason.starts_with("relative: ") ? reason.substr(10) : reason;
  const std::string text = fmt::format("relative: at t = {:.6g} s {}", t, plain);
  const std::string what = plain.starts_with("at t = ") ? "relative: " + plain : text;
  if (run.is_singular && !run.last_reason.empty()) throw SingularPose(what);
  throw SolverError(what);
}

/// The state at an output time, projected, with accelerations and wrenches computed anew from it. A state that this
/// solver would not take from anyone else is not written: what follows it would be no motion of the machine.
Sample take_sample(Run& run, States& states, double t, const Eigen::Ref<const VecX>& y, const State& before) {
  run.coordinates.t = t;
  run.variables.unpack(y, run.coordinates);
  Sample sample;
  sample.work = y(run.variables.work());
  try {
    run.lines.settle();
    run.assembly.project(run.coordinates);
    run.equations.compute_accelerations(t, run.coordinates.q, run.coordinates.u);
    run.assembly.closure_rank().require_general(run.coordinates);
    run.assembly.closure_rank().require_agreeing_rows(run.coordinates);
    sample.state = states.write(t, before);
    (void)states.read_closed(sample.state);
  } catch (const SolverError& error) {
    run.remember(error);
    throw_stopped(t, run, run.last_reason);
  }
  run.equations.compute_reactions();
  require_modal_balance(run.equations, t);
  sample.evaluation = states.write_evaluation();
  return sample;
}

}  // namespace

std::vector<std::string> integrator_names(const Model& /*model*/) { return {"erk", "dirk"}; }

void require_modal_balance(const Equations& equations, double t) {
  const Reactions& reactions = equations.reactions();
  if (reactions.modal_residual() <= kLargestModalResidual) return;
  throw SolverError(
      fmt::format("relative: at t = {:.6g} s the modal equations of body '{}' are out of balance by {:.1e} "
                  "of their largest term, allowed {:.0e}",
                  t, equations.model().bodies[reactions.worst_modal_body()].name, reactions.modal_residual(),
                  kLargestModalResidual));
}

namespace {

/// Rows stay the same within each step of a run.
struct RowsOfSteps {
  Loops& loops;

  explicit RowsOfSteps(Equations& equations) : loops(equations.loops()) { loops.keep_rows(); }
  ~RowsOfSteps() { loops.free_rows(); }
  RowsOfSteps(const RowsOfSteps&) = delete;
  RowsOfSteps& operator=(const RowsOfSteps&) = delete;
};

}  // namespace

Trajectory integrate(Equations& equations, Assembly& assembly, States& states, const Coordinates& start,
                     const RunOptions& options, const Progress& progress) {
  const auto began = std::chrono::steady_clock::now();
  const std::string integrator = chosen_integrator(equations.model(), options.integrator);
  Run run{equations,
          assembly,
          Variables(equations),
          start,
          VecX::Zero(equations.topology().n_q),
          false,
          0,
          SingularityWatch(equations, assembly)};
  run.has_work = equations.has_drivers() || equations.has_applied_forces() || equations.model().is_flexible();
  run.watch.pass(start);
  run.lines = LineWatch(assembly.scales().length());
  run.follow_lines();
  const RowsOfSteps rows(equations);

  const sundials::Context context;
  sundials::MessageRecord messages;
  const sundials::Vector y = sundials::make_vector(run.variables.size(), context);
  run.variables.pack(start.q, start.u, sundials::view(y.get()));
  run.rtol = integrator == "erk" ? std::max(kStepShare * options.rtol, kFinestStep) : options.rtol;
  run.until = options.until;
  if (integrator != "dirk") run.advice_if_stiff = ": try --relative-integrator dirk";
  run.sizes = Sizes(equations, assembly.scales(), start, options.until).of(run.variables);
  Stepper stepper(integrator, y.get(), {right_side, project_step, error_weights, &run}, context, messages);
  const auto apply_forces = [&run](double at, const Eigen::Ref<const VecX>& numbers) {
    run.variables.unpack(numbers, run.coordinates);
    run.equations.update_forces(at, run.coordinates.q, run.coordinates.u);
  };
  RegimeEvents events(equations.applied_forces(), apply_forces, stepper, y.get(), options.until);
  const bool has_events = equations.applied_forces().has_regimes();
  if (has_events) events.set_regimes(0.0, sundials::view(y.get()));

  double t = 0.0;
  const auto advance = [&](double t_end) {
    if (!has_events) return stepper.advance(t_end, y.get(), t);
    try {
      return events.advance(t_end, y.get(), t);
    } catch (const SolverError& error) {
      run.remember(error);
      throw_stopped(t, run, run.last_reason);
    }
  };
  // No step passes over a time at which a law goes on as another formula.
  const std::vector<double> breaks = break_times(equations.model(), options.until);
  auto next_break = breaks.begin();
  const auto advance_over_breaks = [&](double t_end) {
    for (; next_break != breaks.end() && *next_break < t_end; ++next_break) {
      if (*next_break - t > kSameTime * options.until && advance(*next_break) < 0) return -1;
    }
    return t_end - t > kSameTime * options.until ? advance(t_end) : 0;
  };
  Trajectory trajectory;
  State before;
  for (int i = 0; i <= options.samples; ++i) {
    const double t_end = options.until * i / options.samples;
    run.last_reason.clear();
    if (i > 0 && advance_over_breaks(t_end) < 0) throw_stopped(t, run, messages.last);
    Sample sample = take_sample(run, states, t_end, sundials::view(y.get()), before);
    before = sample.state;
    StateMisfit misfit;
    (void)states.read(sample.state, misfit);
    trajectory.statistics.max_constraint = std::max(trajectory.statistics.max_constraint, misfit.largest);
    trajectory.samples.push_back(std::move(sample));
    if (progress) progress(t_end);
    if (run.count_turns(sundials::view(y.get())) && stepper.rename(t, y.get()) < 0)
      throw_stopped(t, run, messages.last);
  }
  trajectory.statistics.steps = stepper.steps();
  trajectory.statistics.evaluations = run.evaluations;
  trajectory.statistics.largest_work = run.largest_work;
  trajectory.statistics.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return trajectory;
}

}  // namespace concord::relative
