#include "relative/run/implicit_stepper.h"

#include <arkode/arkode_arkstep.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <cmath>
#include <limits>

#include "common/error.h"

namespace concord::relative {

namespace {

constexpr long kMostSteps = 50'000'000;

}  // namespace

ImplicitStepper::ImplicitStepper(IntegratedSystem& system, const VecX& y)
    : system_(&system), y_(y), y_before_(y), vector_(sundials::make_vector(y.size(), context_)) {
  sundials::view(vector_.get()) = y;
  matrix_.reset(sundials::require(SUNDenseMatrix(y.size(), y.size(), context_.get()), "SUNDenseMatrix"));
  linear_.reset(sundials::require(SUNLinSol_Dense(vector_.get(), matrix_.get(), context_.get()), "SUNLinSol_Dense"));
  set_up();
}

void ImplicitStepper::set_up() {
  memory_ = sundials::require(ARKStepCreate(nullptr, right_side, 0.0, vector_.get(), context_.get()), "ARKStepCreate");
  const auto check = [&](int code, const char* call) { sundials::check(code, call, messages_); };
  check(ARKStepSetErrHandlerFn(memory_, sundials::MessageRecord::record, &messages_), "ARKStepSetErrHandlerFn");
  check(ARKStepSetUserData(memory_, this), "ARKStepSetUserData");
  check(ARKStepWFtolerances(memory_, weigh), "ARKStepWFtolerances");
  check(ARKStepSetTableNum(memory_, ARKODE_ESDIRK547L2SA2_7_4_5, ARKODE_ERK_NONE), "ARKStepSetTableNum");
  check(ARKStepSetLinearSolver(memory_, linear_.get(), matrix_.get()), "ARKStepSetLinearSolver");
  check(ARKStepSetJacFn(memory_, jacobian), "ARKStepSetJacFn");
  check(ARKStepSetMaxNumSteps(memory_, kMostSteps), "ARKStepSetMaxNumSteps");
  check(ARKStepSetNonlinConvCoef(memory_, 1e-2), "ARKStepSetNonlinConvCoef");
  check(ARKStepSetMaxNonlinIters(memory_, 8), "ARKStepSetMaxNonlinIters");
  // The rate at which Newton's method converged in earlier steps says nothing of a step of another length that uses
  // their matrix: no iterate is accepted for it.
  check(ARKStepSetNonlinCRDown(memory_, 1.0), "ARKStepSetNonlinCRDown");
  check(ARKStepSetPostprocessStepFn(memory_, project), "ARKStepSetPostprocessStepFn");
  // Events are looked for between steps; a higher degree would evaluate there.
  check(ARKStepSetInterpolantDegree(memory_, 3), "ARKStepSetInterpolantDegree");
}

ImplicitStepper::~ImplicitStepper() {
  if (memory_ != nullptr) ARKStepFree(&memory_);
}

void ImplicitStepper::require_good(int code) const {
  if (code >= 0) return;
  if (failure_) std::rethrow_exception(failure_);
  throw SolverError(messages_.last);
}

void ImplicitStepper::step(double t_end) {
  constexpr int kMostTries = 20;
  constexpr double kShorter = 0.25;
  constexpr double kShortest = 1e-13;  // of the time: nothing moves in such steps
  failure_ = nullptr;
  t_before_ = t_;
  y_before_ = y_;
  double h = 0.0;
  require_good(ARKStepGetCurrentStep(memory_, &h));
  if (!(h > 0.0) || h > t_end - t_) h = t_end - t_;
  int code = try_step(t_end);
  const auto is_too_far = [&] { return code == ARK_UNREC_RHSFUNC_ERR || code == ARK_RHSFUNC_FAIL; };
  for (int k = 1; k < kMostTries && is_too_far() && h > kShortest * t_end; ++k) {
    h *= kShorter;
    t_ = t_before_;
    y_ = y_before_;
    restart(h);
    code = try_step(t_end);
  }
  require_good(code);
}

/// What the system throws is kept, and ARKODE told of a failure.
template <typename Call>
int ImplicitStepper::guarded(const Call& call, int failure) {
  try {
    return call() ? 0 : failure;
  } catch (const SolverError&) {
    failure_ = std::current_exception();
    return failure;
  }
}

int ImplicitStepper::right_side(realtype t, N_Vector y, N_Vector ydot, void* stepper) {
  auto& self = *static_cast<ImplicitStepper*>(stepper);
  const auto call = [&] {
    self.system_->evaluate(t + self.beyond_, sundials::view(y), sundials::view(ydot));
    return sundials::view(ydot).allFinite();
  };
  return self.guarded(call, 1);
}

int ImplicitStepper::project(realtype t, N_Vector y, void* stepper) {
  auto& self = *static_cast<ImplicitStepper*>(stepper);
  const auto call = [&] {
    self.system_->project(t + self.beyond_, sundials::view(y));
    return true;
  };
  return self.guarded(call, -1);
}

int ImplicitStepper::weigh(N_Vector y, N_Vector weights, void* stepper) {
  static_cast<ImplicitStepper*>(stepper)->system_->weigh(sundials::view(y), sundials::view(weights));
  return 0;
}

int ImplicitStepper::jacobian(realtype t, N_Vector y, N_Vector ydot, SUNMatrix matrix, void* stepper,
                              N_Vector /*unused*/, N_Vector /*unused*/, N_Vector /*unused*/) {
  auto& self = *static_cast<ImplicitStepper*>(stepper);
  Eigen::Map<MatX> J(SUNDenseMatrix_Data(matrix), SUNDenseMatrix_Rows(matrix), SUNDenseMatrix_Columns(matrix));
  const auto call = [&] {
    self.system_->differentiate(t + self.beyond_, sundials::view(y), sundials::view(ydot), J);
    return J.allFinite();
  };
  return self.guarded(call, 1);
}

int ImplicitStepper::try_step(double t_end) {
  if (is_reached(t_end)) {
    t_ = t_end;
    return ARK_TSTOP_RETURN;
  }
  const int code = ARKStepSetStopTime(memory_, t_end - beyond_);
  return code < 0 ? code : evolve(t_end);
}

/// ARKODE refuses an end within the round-off of its time, and says of one within 100 times that of time and last step
/// that it has arrived, without a step. Nothing moves on the way there.
bool ImplicitStepper::is_reached(double t_end) const {
  constexpr double kNear = 200.0 * std::numeric_limits<double>::epsilon();
  double h = 0.0;
  ARKStepGetLastStep(memory_, &h);
  return std::abs(t_end - beyond_ - added_up_) <= kNear * (std::abs(added_up_) + h);
}

/// One step, after which t is the sum of all.
int ImplicitStepper::evolve(double t_end) {
  double reached = added_up_;
  const int code = ARKStepEvolve(memory_, t_end - beyond_, vector_.get(), &reached, ARK_ONE_STEP);
  y_ = sundials::view(vector_.get());
  if (code < 0) {
    t_ = reached + beyond_;
    return code;
  }
  double h = 0.0;
  ARKStepGetLastStep(memory_, &h);
  beyond_ += h - (reached - added_up_);
  added_up_ = reached;
  t_ = code == ARK_TSTOP_RETURN ? t_end : reached + beyond_;
  return code;
}

void ImplicitStepper::interpolate(double t, Eigen::Ref<VecX> y) {
  require_good(ARKStepGetDky(memory_, t - beyond_, 0, vector_.get()));
  y = sundials::view(vector_.get());
}

void ImplicitStepper::reset() {
  added_up_ = t_;
  beyond_ = 0.0;
  sundials::view(vector_.get()) = y_;
  require_good(ARKStepReset(memory_, t_, vector_.get()));
}

void ImplicitStepper::restart(double h) {
  require_good(ARKStepSetFixedStep(memory_, 0.0));
  require_good(ARKStepSetInitStep(memory_, h));
  reset();
}

void ImplicitStepper::rename(const VecX& y) {
  double h = 0.0;
  require_good(ARKStepGetCurrentStep(memory_, &h));
  y_ = y;
  restart(h);
}

void ImplicitStepper::step_exactly(double h) {
  failure_ = nullptr;
  t_ = t_before_;
  y_ = y_before_;
  reset();
  require_good(ARKStepSetStopTime(memory_, t_ + h));
  require_good(ARKStepSetFixedStep(memory_, h));
  require_good(evolve(t_ + h));
}

long ImplicitStepper::steps() const {
  long steps = 0;
  ARKStepGetNumSteps(memory_, &steps);
  return steps;
}

}  // namespace concord::relative
