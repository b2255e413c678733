#include "relative/run/integration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <optional>

#include "common/growth_watch.h"
#include "common/laws/break_times.h"
#include "common/sundials.h"
#include "relative/run/integration_run.h"
#include "relative/run/regime_events.h"

namespace concord::relative {

namespace {

/// Times closer than this part of a run are one.
constexpr double kSameTime = 1e-13;

std::string chosen_integrator(const Model& model, const std::string& wanted) {
  const std::vector<std::string> known = integrator_names(model);
  if (wanted.empty()) return known.front();
  if (std::find(known.begin(), known.end(), wanted) != known.end()) return wanted;
  throw InputError({model.file, 0, 0}, fmt::format("the relative solver has no integrator '{}'; it has {}", wanted,
                                                   fmt::join(known, ", ")));
}

/// Rows stay the same within each step of a run.
struct RowsOfSteps {
  Loops& loops;

  explicit RowsOfSteps(Equations& equations) : loops(equations.loops()) { loops.keep_rows(); }
  ~RowsOfSteps() { loops.free_rows(); }
  RowsOfSteps(const RowsOfSteps&) = delete;
  RowsOfSteps& operator=(const RowsOfSteps&) = delete;
};

/// The integrator of a run on its way from one time to another. No step passes over a time at which a law goes on as
/// another formula, or at which the regime of a contact ends.
class Course {
 public:
  /// The run must outlive this object.
  Course(IntegrationRun& run, Equations& equations, const Coordinates& start, const RunOptions& options,
         const std::string& integrator)
      : run_(&run),
        y_(packed(run, start, context_)),
        stepper_(integrator, y_.get(), callbacks_of(run), context_, messages_),
        events_(
            equations.applied_forces(), [&run](double t, const Eigen::Ref<const VecX>& y) { run.apply_forces(t, y); },
            stepper_, y_.get(), run.sizes_of_coordinates(), options.until),
        has_events_(equations.applied_forces().has_regimes()),
        shortest_(kSameTime * options.until),
        breaks_(break_times(equations.model(), options.until)),
        next_break_(breaks_.begin()) {
    if (has_events_) events_.set_regimes(0.0, numbers());
  }
  Course(const Course&) = delete;
  Course& operator=(const Course&) = delete;

  /// The integrated numbers where the last advance has ended.
  [[nodiscard]] Eigen::Map<VecX> numbers() { return sundials::view(y_.get()); }
  [[nodiscard]] long steps() const { return stepper_.steps(); }

  /// Goes to t_end exactly. Throws SolverError with time and reason.
  void advance(double t_end) {
    run_->forget_failure();
    for (; next_break_ != breaks_.end() && *next_break_ < t_end; ++next_break_) advance_smoothly(*next_break_);
    advance_smoothly(t_end);
  }

  void count_turns() {
    if (run_->count_turns(numbers())) require_good(stepper_.rename(t_, y_.get()));
  }

 private:
  static sundials::Vector packed(const IntegrationRun& run, const Coordinates& start,
                                 const sundials::Context& context) {
    sundials::Vector y = sundials::make_vector(run.variables().size(), context);
    run.variables().pack(start.q, start.u, sundials::view(y.get()));
    return y;
  }

  void require_good(int code) const {
    if (code < 0) run_->throw_stopped(t_, messages_.last);
  }

  void advance_smoothly(double t_end) {
    if (t_end - t_ <= shortest_) return;
    if (!has_events_) return require_good(stepper_.advance(t_end, y_.get(), t_));
    int code = 0;
    try {
      code = events_.advance(t_end, y_.get(), t_);
    } catch (const SolverError& error) {
      run_->remember(error);
      code = -1;
    }
    require_good(code);
  }

  IntegrationRun* run_;
  sundials::Context context_;
  sundials::MessageRecord messages_;
  sundials::Vector y_;
  Stepper stepper_;
  RegimeEvents events_;
  bool has_events_;
  double shortest_;  // two times closer than this are one
  std::vector<double> breaks_;
  std::vector<double>::const_iterator next_break_;
  double t_ = 0.0;
};

}  // namespace

std::vector<std::string> integrator_names(const Model& /*model*/) { return {"erk", "dirk"}; }

Trajectory integrate(Equations& equations, Assembly& assembly, States& states, const Coordinates& start,
                     const RunOptions& options, const Progress& progress) {
  const auto began = std::chrono::steady_clock::now();
  const std::string integrator = chosen_integrator(equations.model(), options.integrator);
  IntegrationRun run(equations, assembly, start, options, integrator);
  const RowsOfSteps rows(equations);
  Course course(run, equations, start, options, integrator);
  Trajectory trajectory;
  std::optional<GrowthWatch> growth;
  for (int i = 0; i <= options.samples; ++i) {
    const double t = i == options.samples ? options.until : options.until * i / options.samples;
    if (i > 0) course.advance(t);
    const State before = i > 0 ? trajectory.samples.back().state : State();
    trajectory.samples.push_back(run.take_sample(states, t, course.numbers(), before));
    if (!growth) growth.emplace(equations.model(), trajectory.samples.front().state);
    growth->follow(trajectory.samples.back().state, "relative");
    StateMisfit misfit;
    (void)states.read(trajectory.samples.back().state, misfit);
    trajectory.statistics.max_constraint = std::max(trajectory.statistics.max_constraint, misfit.largest);
    if (progress) progress(t);
    course.count_turns();
  }
  trajectory.statistics.steps = course.steps();
  trajectory.statistics.evaluations = run.evaluations();
  trajectory.statistics.largest_work = run.largest_work();
  trajectory.statistics.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return trajectory;
}

}  // namespace concord::relative
