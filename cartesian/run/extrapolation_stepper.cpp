#include <arkode/arkode_erkstep.h>

#include <array>
#include <cmath>
#include <exception>
#include <vector>

#include "cartesian/run/step_tolerances.h"
#include "cartesian/run/stepper.h"
#include "common/error.h"
#include "common/sundials.h"

namespace concord::cartesian {

namespace {

using sundials::check;
using sundials::require;
using sundials::view;

struct FreeTable {
  void operator()(ARKodeButcherTable table) const { ARKodeButcherTable_Free(table); }
};
using Table = std::unique_ptr<std::remove_pointer_t<ARKodeButcherTable>, FreeTable>;

/// Weight of the result with n_j substeps in the extrapolation of the first `used` results to n = infinity in (1/n)^2.
double extrapolation_weight(const std::vector<int>& substeps, std::size_t j, std::size_t used) {  // (C55)
  double weight = 1.0;
  const double own = substeps[j] * substeps[j];
  for (std::size_t i = 0; i < used; ++i) {
    if (i != j) weight *= own / (own - substeps[i] * substeps[i]);
  }
  return weight;
}

/// Gragg's modified midpoint rule, z_1 = y + h/n f(y), z_{k+1} = z_{k-1} + 2h/n f(z_k), with each even n of `substeps`,
/// extrapolated in (1/n)^2 and written as one explicit Runge-Kutta table: order 2 m for m sequences, embedded 2 m - 2.
/// f(y) is shared, so there are 1 + sum of (n - 1) stages. (Hairer, Norsett, Wanner I, section II.9.) (C55)
Table make_table(const std::vector<int>& substeps) {
  int stages = 1;
  for (const int n : substeps) stages += n - 1;
  MatX A = MatX::Zero(stages, stages);
  VecX b = VecX::Zero(stages);
  VecX embedded = VecX::Zero(stages);
  int next = 1;
  const std::size_t m = substeps.size();
  for (std::size_t j = 0; j < m; ++j) {
    const int n = substeps[j];
    VecX before = VecX::Zero(stages);                  // z_{k-1}
    VecX reached = VecX::Unit(stages, 0) / double(n);  // z_k
    for (int k = 1; k < n; ++k) {
      A.row(next) = reached;
      const VecX after = before + 2.0 / n * VecX::Unit(stages, next);
      before = reached;
      reached = after;
      ++next;
    }
    b += extrapolation_weight(substeps, j, m) * reached;
    if (j + 1 < m) embedded += extrapolation_weight(substeps, j, m - 1) * reached;
  }
  VecX c = A.rowwise().sum();
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  RowMajor A_rows = A;
  return Table(require(ARKodeButcherTable_Create(stages, 2 * static_cast<int>(m), 2 * static_cast<int>(m) - 2, c.data(),
                                                 A_rows.data(), b.data(), embedded.data()),
                       "ARKodeButcherTable_Create"));
}

class ExtrapolationStepper : public Stepper {
 public:
  ExtrapolationStepper(Dynamics& dynamics, const MotionState& start, Tolerance tolerance)
      : Stepper(dynamics, start),
        n_q_(equations_.layout().n_q()),
        n_Y_(equations_.layout().n_Y()),
        before_(start),
        interpolated_(start),
        y_(sundials::make_vector(n_q_ + n_Y_ + 1, context_)),
        dense_(sundials::make_vector(n_q_ + n_Y_ + 1, context_)),
        tolerances_(dynamics, start, tolerance),
        absolute_(sundials::make_vector(n_q_ + n_Y_ + 1, context_)) {
    write(start, view(y_.get()));
    memory_.reset(require(ERKStepCreate(&right_side, 0.0, y_.get(), context_.get()), "ERKStepCreate"));
    void* erk = memory_.get();
    check(ERKStepSetErrHandlerFn(erk, sundials::MessageRecord::record, &messages_), "ERKStepSetErrHandlerFn",
          messages_);
    check(ERKStepSetTable(erk, make_table({2, 4, 6, 8, 10}).get()), "ERKStepSetTable", messages_);
    tell_tolerances();
    check(ERKStepSetUserData(erk, this), "ERKStepSetUserData", messages_);
    check(ERKStepSetPostprocessStepFn(erk, &project), "ERKStepSetPostprocessStepFn", messages_);
    check(ERKStepSetMaxHnilWarns(erk, -1), "ERKStepSetMaxHnilWarns", messages_);
    // For interpolation within a step: of degree 3, which needs no evaluation inside it.
    check(ERKStepSetInterpolantDegree(erk, 3), "ERKStepSetInterpolantDegree", messages_);
  }

 protected:
  void advance(double stop) override {
    if (tolerances_.follow(reached_, reached_ - started_, motion_, largest_work_)) tell_tolerances();
    started_ = reached_;
    before_ = motion_;
    evolve(stop);
  }

  const MotionState& interpolate(double t) override {
    if (t == reached_) return motion_;
    check(ERKStepGetDky(memory_.get(), t - late_, 0, dense_.get()), "ERKStepGetDky", messages_);
    read(view(dense_.get()), interpolated_);
    return interpolated_;
  }

  /// Repeats the step, shortened: what lies inside a step is known to a lower order only.
  void set_motion_at(double t) override {
    if (t == reached_) return;
    motion_ = before_;
    restart(started_);
    reached_ = started_;
    if (t <= started_) return;
    check(ERKStepSetInitStep(memory_.get(), t - started_), "ERKStepSetInitStep", messages_);
    while (reached_ < t) evolve(t);
    check(ERKStepSetInitStep(memory_.get(), 0.0), "ERKStepSetInitStep", messages_);
  }

  [[nodiscard]] bool remembers_multipliers() const override { return false; }

  void restart(double t) override {
    write(motion_, view(y_.get()));
    clock_ = t;
    late_ = 0.0;
    check(ERKStepReInit(memory_.get(), &right_side, t, y_.get()), "ERKStepReInit", messages_);
  }

 private:
  void tell_tolerances() {
    view(absolute_.get()) = tolerances_.absolute();
    check(ERKStepSVtolerances(memory_.get(), tolerances_.rtol(), absolute_.get()), "ERKStepSVtolerances", messages_);
  }

  void evolve(double stop) {
    if (is_too_close(stop)) {
      reached_ = stop;
      return;
    }
    const double begin = reached_;
    failure_ = nullptr;
    int code = try_step(stop);
    if (is_too_far(code)) code = try_shorter_steps(begin, stop);
    if (code < 0 && failure_) std::rethrow_exception(failure_);
    if (code < 0) throw SolverError("cartesian (gbs): " + messages_.last);
    ++steps_;
    read(view(y_.get()), motion_);
  }

  /// ARKODE makes no step shorter than 2.2e-14 of its time and its last step together: it refuses, or says that the
  /// stop is reached, and the last step would be added to the time again. Nothing moves in so little.
  [[nodiscard]] bool is_too_close(double stop) {
    constexpr double kShortest = 5e-14;
    double last = 0.0;
    check(ERKStepGetLastStep(memory_.get(), &last), "ERKStepGetLastStep", messages_);
    return stop - (clock_ + late_) <= kShortest * (stop + last);
  }

  int try_step(double stop) {
    check(ERKStepSetStopTime(memory_.get(), stop - late_), "ERKStepSetStopTime", messages_);
    double clock = clock_;
    const int code = ERKStepEvolve(memory_.get(), stop - late_, y_.get(), &clock, ARK_ONE_STEP);
    if (code < 0) return code;
    double h = 0.0;
    check(ERKStepGetLastStep(memory_.get(), &h), "ERKStepGetLastStep", messages_);
    late_ += h - (clock - clock_);
    clock_ = clock;
    reached_ = code == ARK_TSTOP_RETURN ? stop : clock + late_;
    return code;
  }

  /// A stage of a step, or its end, could not be evaluated.
  static bool is_too_far(int code) { return code == ARK_UNREC_RHSFUNC_ERR || code == ARK_RHSFUNC_FAIL; }

  /// Where a stage of a step cannot be evaluated, ERKStep gives up: it lies too far ahead. The step is made anew from
  /// its begin, in `motion_`, with less and less of its length.
  int try_shorter_steps(double begin, double stop) {
    constexpr double kLeast = 1e-13;
    double h = std::min(last_try(), stop - begin);
    int code = ARK_UNREC_RHSFUNC_ERR;
    while (is_too_far(code) && h > kLeast * stop) {
      h *= 0.1;
      restart(begin);
      reached_ = begin;
      check(ERKStepSetInitStep(memory_.get(), h), "ERKStepSetInitStep", messages_);
      code = try_step(stop);
    }
    check(ERKStepSetInitStep(memory_.get(), 0.0), "ERKStepSetInitStep", messages_);
    return code;
  }

  [[nodiscard]] double last_try() {
    double h = 0.0;
    check(ERKStepGetCurrentStep(memory_.get(), &h), "ERKStepGetCurrentStep", messages_);
    return h > 0.0 ? h : HUGE_VAL;
  }

  template <class Numbers>
  void read(const Numbers& y, MotionState& motion) const {
    motion.q = y.head(n_q_);
    motion.Y = y.segment(n_q_, n_Y_);
    motion.work = y(n_q_ + n_Y_);
  }
  template <class Numbers>
  void write(const MotionState& motion, Numbers&& y) const {
    y.head(n_q_) = motion.q;
    y.segment(n_q_, n_Y_) = motion.Y;
    y(n_q_ + n_Y_) = motion.work;
  }

  /// Runs what may throw inside SUNDIALS. A failure is recoverable: a shorter step may do.
  template <class Action>
  int guarded(const Action& action) {
    try {
      action();
      return 0;
    } catch (const SolverError&) {
      failure_ = std::current_exception();
      return 1;
    }
  }

  static int right_side(sunrealtype t, N_Vector y_vector, N_Vector ydot_vector, void* pointer) {
    auto& self = *static_cast<ExtrapolationStepper*>(pointer);
    const auto y = view(y_vector);
    auto ydot = view(ydot_vector);
    if (!y.allFinite()) return 1;
    return self.guarded([&] {
      ++self.evaluations_;
      const auto q = y.head(self.n_q_);
      const auto Y = y.segment(self.n_q_, self.n_Y_);
      const Solution& solution = self.dynamics_.solve_at(t + self.late_, q, Y, Pivots::kept);
      self.nearby_ = &solution;
      self.equations_.layout().write_qdot(q, Y, ydot.head(self.n_q_));
      ydot.segment(self.n_q_, self.n_Y_) = solution.Ydot();
      ydot(self.n_q_ + self.n_Y_) = self.equations_.power_of(solution.lambda());
    });
  }

  static int project(sunrealtype t, N_Vector y_vector, void* pointer) {
    auto& self = *static_cast<ExtrapolationStepper*>(pointer);
    auto y = view(y_vector);
    return self.guarded([&] {
      self.dynamics_.project(*self.nearby_, t + self.late_, y.head(self.n_q_), y.segment(self.n_q_, self.n_Y_));
    });
  }

  struct FreeMemory {
    void operator()(void* memory) const { ERKStepFree(&memory); }
  };

  Eigen::Index n_q_;
  Eigen::Index n_Y_;
  double started_ = 0.0;              // the last step, at
  const Solution* nearby_ = nullptr;  // of the last stage of a step
  MotionState before_;
  MotionState interpolated_;
  std::exception_ptr failure_;  // the last within a step
  sundials::MessageRecord messages_;
  sundials::Context context_;
  sundials::Vector y_;
  sundials::Vector dense_;
  StepTolerances tolerances_;
  sundials::Vector absolute_;
  // ARKODE's clock is a sum of rounded times, which falls behind the sum of the steps where many of them are equal:
  // drivers and laws of time are asked at the latter.
  double clock_ = 0.0;
  double late_ = 0.0;
  std::unique_ptr<void, FreeMemory> memory_;
};

}  // namespace

std::unique_ptr<Stepper> make_extrapolation_stepper(Dynamics& dynamics, const MotionState& start, Tolerance tolerance) {
  return std::make_unique<ExtrapolationStepper>(dynamics, start, tolerance);
}

}  // namespace concord::cartesian
