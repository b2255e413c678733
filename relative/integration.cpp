#include "relative/integration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include "common/break_times.h"
#include "common/sundials.h"
#include "relative/singularity_watch.h"
#include "relative/stepper.h"

namespace concord::relative {

namespace {

constexpr double kLargestModalResidual = 1e-8;
/// Errors of single steps add up over a run: each is held to this part of the tolerance asked of the run, but not below
/// what round-off lets the formulas see.
constexpr double kStepShare = 0.01;
constexpr double kFinestStep = 2e-15;

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
  /// the size and the value for speeds and work. None below the round-off of the number itself (R74).
  void weigh(const Eigen::Ref<const VecX>& y, Eigen::Ref<VecX> weights) const {
    constexpr double kLeastWeighed = 1e-15;
    const Eigen::Index n_rates = y.size() - variables.n_q();
    weights = sizes;
    weights.tail(n_rates) += y.tail(n_rates).cwiseAbs();
    weights = (rtol * weights).cwiseMax(kLeastWeighed * y.cwiseAbs()).cwiseInverse();
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
                    "integrator{}",
                    kMostEvaluationsWithoutAdvance, t - paced_from, place));
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
    coordinates.t = t;
    variables.unpack(y, coordinates);
    assembly.project(coordinates);
    variables.pack(coordinates.q, coordinates.u, y);
    watch.pass(coordinates);
    equations.loops().keep_rows();
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

/// Takes an integration through the events of its tires and stops: during a step their regimes are kept, and a step in
/// which one ends is made anew up to there.
class RegimeEvents {
 public:
  RegimeEvents(Run& run, Stepper& stepper, const sundials::Context& context, double until)
      : run_(&run), stepper_(&stepper), until_(until), within_(sundials::make_vector(run.variables.size(), context)) {
    look_.values = VecX::Zero(run.equations.applied_forces().n_event_functions());
    looks_.fill(look_);
  }
  ~RegimeEvents() { run_->equations.applied_forces().free_regimes(); }
  RegimeEvents(const RegimeEvents&) = delete;
  RegimeEvents& operator=(const RegimeEvents&) = delete;

  /// Takes the regimes of a state.
  void set_regimes(double t, const Eigen::Ref<const VecX>& y) {
    run_->equations.applied_forces().free_regimes();
    take_event_functions(t, y, looks_.front().values);
    run_->equations.applied_forces().freeze_regimes();
  }

  /// Advances y to t_end exactly. Throws SolverError where events follow each other without end.
  int advance(double t_end, N_Vector y, double& t) {
    while (t < t_end) {
      const double t_before = t;
      before_ = sundials::view(y);
      const int code = stepper_->step(t_end, y, t);
      if (code < 0) return code;
      take_event_functions(t, sundials::view(y), looks_.back().values);
      const double step = t - t_before;
      const std::optional<Bracket> bracket = find_bracket(t_before, step);
      if (!bracket) {
        looks_.front().values = looks_.back().values;
        continue;
      }
      t = t_before;
      const int found = approach(*bracket, y, t);
      if (found < 0) return found;
      if (least_event_function(t, sundials::view(y)) < 0.0) require_progress(t);
      set_regimes(t, sundials::view(y));
      const int restarted = stepper_->restart(t, y, std::min(step, std::max(t_end - t, round_off(t))));
      if (restarted < 0) return restarted;
      if (t_end - t <= round_off(t)) t = t_end;
    }
    return 0;
  }

 private:
  /// Lengths of two steps, and the event function where they end: inside the regimes, and outside.
  struct Bracket {
    double inside, value_inside;
    double outside, value_outside;
  };
  static constexpr int kMostTrials = 100;
  static constexpr std::size_t kMostEvents = 200;
  static constexpr double kTinyTime = 1e-4;  // of the run's

  [[nodiscard]] static double round_off(double t) { return 8.0 * std::numeric_limits<double>::epsilon() * t; }

  void take_event_functions(double t, const Eigen::Ref<const VecX>& y, VecX& values) {
    run_->variables.unpack(y, run_->coordinates);
    run_->equations.update_forces(t, run_->coordinates.q, run_->coordinates.u);
    run_->equations.applied_forces().write_event_functions(values);
  }

  double least_event_function(double t, const Eigen::Ref<const VecX>& y) {
    take_event_functions(t, y, look_.values);
    return look_.least();
  }

  /// A time of the last step, from its begin, and the event functions there.
  struct Look {
    double at;
    VecX values;

    [[nodiscard]] double least() const { return values.minCoeff(); }
  };

  void take_look(double t_before, double at, Look& look) {
    look.at = at;
    if (stepper_->interpolate(t_before + at, within_.get()) < 0) {
      look.values.setConstant(HUGE_VAL);
    } else {
      take_event_functions(t_before + at, sundials::view(within_.get()), look.values);
    }
  }

  /// Between which times of the last step, from its begin, a regime ends; nothing if none does. Within the step an
  /// event function may dip below zero and come back; where chords allow it, the step is looked into there.
  std::optional<Bracket> find_bracket(double t_before, double step) {
    constexpr double kShortest = 1e-9;  // of the run: nothing dips that moves so little
    constexpr std::array kParts{1.0 / 64.0, 0.5, 1.0 - 1.0 / 64.0};
    Look& begin = looks_.front();
    Look& end = looks_.back();
    begin.at = 0.0;
    end.at = step;
    const auto between = [](const Look& inside, const Look& outside) {
      return Bracket{inside.at, std::max(0.0, inside.least()), outside.at, outside.least()};
    };
    if (step <= kShortest * until_) return end.least() < 0.0 ? std::optional(between(begin, end)) : std::nullopt;
    for (std::size_t k = 0; k < kParts.size(); ++k) take_look(t_before, kParts[k] * step, looks_[k + 1]);
    for (std::size_t k = 1; k < looks_.size(); ++k) {
      if (looks_[k].least() < 0.0) return between(looks_[k - 1], looks_[k]);
    }
    for (Eigen::Index function = 0; function < begin.values.size(); ++function) {
      for (std::size_t k = 0; k + 3 < looks_.size(); ++k) {
        const Point inside = point(looks_[k + 1], function);
        const std::array<Point, 4> around{point(looks_[k], function), inside, point(looks_[k + 2], function),
                                          point(looks_[k + 3], function)};
        if (const auto found = follow_dip(t_before, around, function)) {
          return Bracket{found->first.at, std::max(0.0, found->first.value), found->second.at, found->second.value};
        }
      }
    }
    return std::nullopt;
  }

  struct Point {
    double at;
    double value;
  };
  static Point point(const Look& look, Eigen::Index function) { return {look.at, look.values(function)}; }

  /// Where the chords that reach in from both sides meet between the two points in the middle, if that is below zero: a
  /// convex function is nowhere lower (R76).
  static std::optional<Point> lowest_possible(const std::array<Point, 4>& around) {
    const auto& [a, b, c, d] = around;
    const double fall = (b.value - a.value) / (b.at - a.at);
    const double rise = (d.value - c.value) / (d.at - c.at);
    if (!(fall < 0.0 && rise > 0.0)) return std::nullopt;
    const double at = (b.value - c.value - fall * b.at + rise * c.at) / (rise - fall);
    const double value = b.value + fall * (at - b.at);
    if (!(at > b.at && at < c.at && value < 0.0)) return std::nullopt;
    return Point{at, value};
  }

  /// Whether one event function dips below zero between the two points in the middle: looks there as long as it may.
  /// The last point inside and the first outside.
  std::optional<std::pair<Point, Point>> follow_dip(double t_before, std::array<Point, 4> around,
                                                    Eigen::Index function) {
    constexpr int kMostLooks = 30;
    std::optional<Point> lowest = lowest_possible(around);
    for (int k = 0; k < kMostLooks && lowest; ++k) {
      take_look(t_before, lowest->at, look_);
      const Point found = point(look_, function);
      const auto [a, b, c, d] = around;
      if (found.value < 0.0) return std::pair(b, found);
      around = {a, b, found, c};
      lowest = lowest_possible(around);
      const std::array<Point, 4> right{b, found, c, d};
      const std::optional<Point> lowest_right = lowest_possible(right);
      if (!lowest_right || (lowest && lowest->value <= lowest_right->value)) continue;
      around = right;
      lowest = lowest_right;
    }
    return std::nullopt;
  }

  /// Where to look next: where the secant vanishes, but not closer to an end than the tolerance (R75).
  [[nodiscard]] static double guess(const Bracket& b, double tolerance) {
    const double part = b.value_inside / (b.value_inside - b.value_outside);
    return std::clamp(b.inside + part * (b.outside - b.inside), b.inside + tolerance, b.outside - tolerance);
  }

  /// Finds the step that ends just outside and leaves its state in y and t: by secants, the value at an end that stays
  /// halved (the Illinois method), and in the middle after a secant that did not halve the bracket. The event function
  /// is the smallest of several: where another one rests on its border, secants alone would not get to the end.
  int approach(Bracket b, N_Vector y, double& t) {
    const double t_before = t;
    const double tolerance = std::max(1e-13 * until_, round_off(t_before));
    const auto make = [&](double step) {
      t = t_before;
      sundials::view(y) = before_;
      return stepper_->step_exactly(step, y, t);
    };
    int last_side = 0;
    bool bisects = false;
    for (int trial = 0; trial < kMostTrials && b.outside - b.inside > 2.0 * tolerance; ++trial) {
      const double length = b.outside - b.inside;
      const double step = bisects ? b.inside + 0.5 * length : guess(b, tolerance);
      const int code = make(step);
      if (code < 0) return code;
      const double found = least_event_function(t, sundials::view(y));
      const int side = found < 0.0 ? 1 : -1;
      if (side > 0) {
        b.outside = step;
        b.value_outside = found;
        if (last_side == side) b.value_inside *= 0.5;
      } else {
        b.inside = step;
        b.value_inside = found;
        if (last_side == side) b.value_outside *= 0.5;
      }
      last_side = side;
      bisects = !bisects && b.outside - b.inside > 0.5 * length;
    }
    return make(b.outside);
  }

  /// Refuses regimes that take turns in no time.
  void require_progress(double t) {
    times_.push_back(t);
    if (times_.size() <= kMostEvents) return;
    const double first = times_[times_.size() - 1 - kMostEvents];
    if (t - first > kTinyTime * until_) return;
    throw SolverError(
        fmt::format("the contact of {} changes its regime {} times within {:.1e} s: it chatters; give it damping, "
                    "or the road no step there",
                    run_->equations.applied_forces().least_contact(), kMostEvents, t - first));
  }

  Run* run_;
  Stepper* stepper_;
  double until_;
  VecX before_;
  sundials::Vector within_;
  std::array<Look, 5> looks_;  // into the last step, from its begin to its end
  Look look_;
  std::vector<double> times_;
};

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

/// The state at an output time, projected, with accelerations and wrenches computed anew from it.
Sample take_sample(Run& run, const States& states, double t, const Eigen::Ref<const VecX>& y, const State& before) {
  run.coordinates.t = t;
  run.variables.unpack(y, run.coordinates);
  try {
    run.assembly.project(run.coordinates);
    run.equations.compute_accelerations(t, run.coordinates.q, run.coordinates.u);
    run.assembly.require_general_rank(run.coordinates);
  } catch (const SolverError& error) {
    run.remember(error);
    throw_stopped(t, run, run.last_reason);
  }
  run.equations.compute_reactions();
  require_modal_balance(run.equations, t);
  return {states.write(t, before), states.write_evaluation(), y(run.variables.work())};
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
  const RowsOfSteps rows(equations);

  const sundials::Context context;
  sundials::MessageRecord messages;
  const sundials::Vector y = sundials::make_vector(run.variables.size(), context);
  run.variables.pack(start.q, start.u, sundials::view(y.get()));
  run.rtol = integrator == "erk" ? std::max(kStepShare * options.rtol, kFinestStep) : options.rtol;
  run.until = options.until;
  run.sizes = Sizes(equations, assembly.scales(), start, options.until).of(run.variables);
  Stepper stepper(integrator, y.get(), {right_side, project_step, error_weights, &run}, context, messages);
  RegimeEvents events(run, stepper, context, options.until);
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
    if (i == 0) assembly.require_agreeing_rows(start);
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
  trajectory.statistics.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return trajectory;
}

}  // namespace concord::relative
