#include "relative/run/integration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>

#include "common/growth_watch.h"
#include "common/laws/break_times.h"
#include "relative/run/adams.h"
#include "relative/run/implicit_stepper.h"
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

/// Rows stay the same within each step of a run, and no pose is taken twice in a row.
struct KeptInSteps {
  Equations& equations;

  explicit KeptInSteps(Equations& of_run) : equations(of_run) {
    equations.loops().keep_rows();
    equations.keep_pose(true);
  }
  ~KeptInSteps() {
    equations.loops().free_rows();
    equations.keep_pose(false);
  }
  KeptInSteps(const KeptInSteps&) = delete;
  KeptInSteps& operator=(const KeptInSteps&) = delete;
};

std::unique_ptr<Stepper> make_stepper(const std::string& integrator, IntegrationRun& run, const VecX& y, double until) {
  constexpr double kFirst = 1e-3;    // of the run: where that is too long, the first error tells by how much
  constexpr double kLongest = 2e-2;  // of the run: what comes and goes within it would be stepped over
  if (integrator == "dirk") return std::make_unique<ImplicitStepper>(run, y);
  return std::make_unique<Adams>(run, run.modes(), y, Adams::Lengths{kFirst * until, kLongest * until});
}

/// The integrator of a run on its way from one time to another. No step passes over a time at which a law goes on as
/// another formula, or at which the regime of a contact ends; over a sample only where the integrator is as accurate
/// within its steps.
class Course {
 public:
  /// The run and whom progress is told to must outlive this object.
  Course(IntegrationRun& run, Equations& equations, const Coordinates& start, const RunOptions& options,
         const std::string& integrator, const Progress& progress)
      : run_(&run),
        progress_(progress),
        numbers_(packed(run, start)),
        stepper_(make_stepper(integrator, run, numbers_, options.until)),
        events_(
            equations.applied_forces(), [&run](double t, const Eigen::Ref<const VecX>& y) { run.apply_forces(t, y); },
            *stepper_, run.sizes_of_coordinates(), options.until),
        has_events_(equations.applied_forces().has_regimes()),
        until_(options.until),
        shortest_(kSameTime * options.until),
        breaks_(break_times(equations.model(), options.until)),
        next_break_(breaks_.begin()) {
    if (has_events_) events_.set_regimes();
  }
  Course(const Course&) = delete;
  Course& operator=(const Course&) = delete;

  [[nodiscard]] long steps() const { return stepper_->steps(); }

  /// The integrated numbers at t, which may not be before those of the last call. Throws SolverError with time and
  /// reason.
  const VecX& numbers_at(double t) {
    try {
      while (t - stepper_->t() > shortest_) {
        step(t);
        if (progress_) progress_(stepper_->t());
      }
      if (stepper_->t() - t > shortest_) {
        stepper_->interpolate(t, numbers_);
      } else {
        numbers_ = stepper_->y();
      }
    } catch (const SolverError& error) {
      IntegrationRun::throw_stopped(stepper_->t(), error);
    }
    return numbers_;
  }

  void count_turns() {
    numbers_ = stepper_->y();
    if (run_->count_turns(numbers_)) stepper_->rename(numbers_);
  }

 private:
  static VecX packed(const IntegrationRun& run, const Coordinates& start) {
    VecX y = VecX::Zero(run.variables().size());
    run.variables().pack(start.q, start.u, y);
    return y;
  }

  void step(double sample) {
    double end = stepper_->has_dense_output() ? until_ : sample;
    while (next_break_ != breaks_.end() && *next_break_ <= stepper_->t()) ++next_break_;
    if (next_break_ != breaks_.end()) end = std::min(end, *next_break_);
    if (has_events_) {
      events_.step(end);
    } else {
      stepper_->step(end);
    }
  }

  IntegrationRun* run_;
  const Progress& progress_;
  VecX numbers_;
  std::unique_ptr<Stepper> stepper_;
  RegimeEvents events_;
  bool has_events_;
  double until_;
  double shortest_;  // two times closer than this are one
  std::vector<double> breaks_;
  std::vector<double>::const_iterator next_break_;
};

}  // namespace

std::vector<std::string> integrator_names(const Model& /*model*/) { return {"adams", "dirk"}; }

Trajectory integrate(Equations& equations, Assembly& assembly, States& states, const Coordinates& start,
                     const RunOptions& options, const Progress& progress) {
  const auto began = std::chrono::steady_clock::now();
  const std::string integrator = chosen_integrator(equations.model(), options.integrator);
  IntegrationRun run(equations, assembly, start, options, integrator);
  const KeptInSteps kept(equations);
  Course course(run, equations, start, options, integrator, progress);
  Trajectory trajectory;
  std::optional<GrowthWatch> growth;
  for (int i = 0; i <= options.samples; ++i) {
    const double t = i == options.samples ? options.until : options.until * i / options.samples;
    const State before = i > 0 ? trajectory.samples.back().state : State();
    trajectory.samples.push_back(run.take_sample(states, t, course.numbers_at(t), before));
    if (!growth) growth.emplace(equations.model(), trajectory.samples.front().state);
    growth->follow(trajectory.samples.back().state, "relative");
    StateMisfit misfit;
    (void)states.read(trajectory.samples.back().state, misfit);
    trajectory.statistics.max_constraint = std::max(trajectory.statistics.max_constraint, misfit.largest);
    course.count_turns();
  }
  trajectory.statistics.steps = course.steps();
  trajectory.statistics.evaluations = run.evaluations();
  trajectory.statistics.largest_work = run.largest_work();
  trajectory.statistics.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return trajectory;
}

}  // namespace concord::relative
