#include "relative/run/stepper.h"

#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_erkstep.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <cmath>
#include <limits>

#include "relative/run/prince_dormand.h"

namespace concord::relative {

namespace {

constexpr long kMostSteps = 50'000'000;

constexpr Stepper::Calls kErk{ERKStepSetStopTime, ERKStepEvolve,      ERKStepReset,          ERKStepSetFixedStep,
                              ERKStepSetInitStep, ERKStepGetNumSteps, ERKStepGetCurrentStep, ERKStepGetLastStep,
                              ERKStepGetDky,      ERKStepFree};
constexpr Stepper::Calls kArk{ARKStepSetStopTime, ARKStepEvolve,      ARKStepReset,          ARKStepSetFixedStep,
                              ARKStepSetInitStep, ARKStepGetNumSteps, ARKStepGetCurrentStep, ARKStepGetLastStep,
                              ARKStepGetDky,      ARKStepFree};

void* make_erk(N_Vector y, const StepperCallbacks& calls, const sundials::Context& context,
               sundials::MessageRecord& messages) {
  void* memory = sundials::require(ERKStepCreate(calls.right_side, 0.0, y, context.get()), "ERKStepCreate");
  const auto check = [&](int code, const char* call) { sundials::check(code, call, messages); };
  check(ERKStepSetErrHandlerFn(memory, sundials::MessageRecord::record, &messages), "ERKStepSetErrHandlerFn");
  check(ERKStepSetUserData(memory, calls.user_data), "ERKStepSetUserData");
  check(ERKStepWFtolerances(memory, calls.weigh), "ERKStepWFtolerances");
  check(ERKStepSetTable(memory, prince_dormand().get()), "ERKStepSetTable");
  check(ERKStepSetMaxNumSteps(memory, kMostSteps), "ERKStepSetMaxNumSteps");
  check(ERKStepSetPostprocessStepFn(memory, calls.project), "ERKStepSetPostprocessStepFn");
  // Events are looked for between steps; a higher degree would evaluate there.
  check(ERKStepSetInterpolantDegree(memory, 3), "ERKStepSetInterpolantDegree");
  return memory;
}

void* make_dirk(N_Vector y, const StepperCallbacks& calls, const sundials::Context& context, SUNMatrix matrix,
                SUNLinearSolver linear, sundials::MessageRecord& messages) {
  void* memory = sundials::require(ARKStepCreate(nullptr, calls.right_side, 0.0, y, context.get()), "ARKStepCreate");
  const auto check = [&](int code, const char* call) { sundials::check(code, call, messages); };
  check(ARKStepSetErrHandlerFn(memory, sundials::MessageRecord::record, &messages), "ARKStepSetErrHandlerFn");
  check(ARKStepSetUserData(memory, calls.user_data), "ARKStepSetUserData");
  check(ARKStepWFtolerances(memory, calls.weigh), "ARKStepWFtolerances");
  check(ARKStepSetTableNum(memory, ARKODE_ESDIRK547L2SA2_7_4_5, ARKODE_ERK_NONE), "ARKStepSetTableNum");
  check(ARKStepSetLinearSolver(memory, linear, matrix), "ARKStepSetLinearSolver");
  check(ARKStepSetJacFn(memory, calls.jacobian), "ARKStepSetJacFn");
  check(ARKStepSetMaxNumSteps(memory, kMostSteps), "ARKStepSetMaxNumSteps");
  check(ARKStepSetNonlinConvCoef(memory, 1e-2), "ARKStepSetNonlinConvCoef");
  check(ARKStepSetMaxNonlinIters(memory, 8), "ARKStepSetMaxNonlinIters");
  // The rate at which Newton's method converged in earlier steps says nothing of a step of another length that uses
  // their matrix: no iterate is accepted for it.
  check(ARKStepSetNonlinCRDown(memory, 1.0), "ARKStepSetNonlinCRDown");
  check(ARKStepSetPostprocessStepFn(memory, calls.project), "ARKStepSetPostprocessStepFn");
  check(ARKStepSetInterpolantDegree(memory, 3), "ARKStepSetInterpolantDegree");
  return memory;
}

}  // namespace

Stepper::Stepper(const std::string& name, N_Vector y, const StepperCallbacks& callbacks,
                 const sundials::Context& context, sundials::MessageRecord& messages)
    : calls_(name == "dirk" ? &kArk : &kErk), callbacks_(callbacks), before_(N_VClone(y)) {
  const StepperCallbacks own{right_side, project, weigh, jacobian, this};
  if (name != "dirk") {
    memory_ = make_erk(y, own, context, messages);
    return;
  }
  matrix_.reset(sundials::require(SUNDenseMatrix(NV_LENGTH_S(y), NV_LENGTH_S(y), context.get()), "SUNDenseMatrix"));
  linear_.reset(sundials::require(SUNLinSol_Dense(y, matrix_.get(), context.get()), "SUNLinSol_Dense"));
  memory_ = make_dirk(y, own, context, matrix_.get(), linear_.get(), messages);
}

Stepper::~Stepper() {
  if (memory_ != nullptr) calls_->free(&memory_);
}

int Stepper::advance(double t_end, N_Vector y, double& t) {
  int code = 0;
  while (t < t_end && code >= 0) code = step(t_end, y, t);
  return code;
}

int Stepper::step(double t_end, N_Vector y, double& t) {
  constexpr int kMostTries = 20;
  constexpr double kShorter = 0.25;
  constexpr double kShortest = 1e-13;  // of the time: nothing moves in such steps
  const double t_before = t;
  N_VScale(1.0, y, before_.get());
  double h = 0.0;
  int code = calls_->current_step(memory_, &h);
  if (code < 0) return code;
  if (!(h > 0.0) || h > t_end - t) h = t_end - t;
  code = try_step(t_end, y, t);
  const auto is_too_far = [&] { return code == ARK_UNREC_RHSFUNC_ERR || code == ARK_RHSFUNC_FAIL; };
  for (int k = 1; k < kMostTries && is_too_far() && h > kShortest * t_end; ++k) {
    h *= kShorter;
    t = t_before;
    N_VScale(1.0, before_.get(), y);
    const int restarted = restart(t, y, h);
    if (restarted < 0) return restarted;
    code = try_step(t_end, y, t);
  }
  return code;
}

int Stepper::right_side(realtype t, N_Vector y, N_Vector ydot, void* stepper) {
  const auto& self = *static_cast<const Stepper*>(stepper);
  return self.callbacks_.right_side(t + self.beyond_, y, ydot, self.callbacks_.user_data);
}

int Stepper::project(realtype t, N_Vector y, void* stepper) {
  const auto& self = *static_cast<const Stepper*>(stepper);
  return self.callbacks_.project(t + self.beyond_, y, self.callbacks_.user_data);
}

int Stepper::weigh(N_Vector y, N_Vector weights, void* stepper) {
  const auto& self = *static_cast<const Stepper*>(stepper);
  return self.callbacks_.weigh(y, weights, self.callbacks_.user_data);
}

int Stepper::jacobian(realtype t, N_Vector y, N_Vector ydot, SUNMatrix J, void* stepper, N_Vector a, N_Vector b,
                      N_Vector c) {
  const auto& self = *static_cast<const Stepper*>(stepper);
  return self.callbacks_.jacobian(t + self.beyond_, y, ydot, J, self.callbacks_.user_data, a, b, c);
}

int Stepper::try_step(double t_end, N_Vector y, double& t) {
  if (is_reached(t_end)) {
    t = t_end;
    return ARK_TSTOP_RETURN;
  }
  const int code = calls_->set_stop_time(memory_, t_end - beyond_);
  return code < 0 ? code : evolve(t_end, y, t);
}

/// ARKODE refuses an end within the round-off of its time, and says of one within 100 times that of time and last step
/// that it has arrived, without a step. Nothing moves on the way there.
bool Stepper::is_reached(double t_end) const {
  constexpr double kNear = 200.0 * std::numeric_limits<double>::epsilon();
  double h = 0.0;
  calls_->last_step(memory_, &h);
  return std::abs(t_end - beyond_ - added_up_) <= kNear * (std::abs(added_up_) + h);
}

/// One step, after which t is the sum of all.
int Stepper::evolve(double t_end, N_Vector y, double& t) {
  double reached = added_up_;
  const int code = calls_->evolve(memory_, t_end - beyond_, y, &reached, ARK_ONE_STEP);
  if (code < 0) {
    t = reached + beyond_;
    return code;
  }
  double h = 0.0;
  calls_->last_step(memory_, &h);
  beyond_ += h - (reached - added_up_);
  added_up_ = reached;
  t = code == ARK_TSTOP_RETURN ? t_end : reached + beyond_;
  return code;
}

int Stepper::interpolate(double t, N_Vector y) const { return calls_->interpolate(memory_, t - beyond_, 0, y); }

int Stepper::reset(double t, N_Vector y) {
  added_up_ = t;
  beyond_ = 0.0;
  return calls_->reset(memory_, t, y);
}

int Stepper::restart(double t, N_Vector y, double h) {
  int code = calls_->set_fixed_step(memory_, 0.0);
  if (code >= 0) code = calls_->set_init_step(memory_, h);
  return code < 0 ? code : reset(t, y);
}

int Stepper::rename(double t, N_Vector y) {
  realtype h = 0.0;
  const int code = calls_->current_step(memory_, &h);
  return code < 0 ? code : restart(t, y, h);
}

int Stepper::step_exactly(double h, N_Vector y, double& t) {
  int code = reset(t, y);
  if (code >= 0) code = calls_->set_stop_time(memory_, t + h);
  if (code >= 0) code = calls_->set_fixed_step(memory_, h);
  return code < 0 ? code : evolve(t + h, y, t);
}

long Stepper::steps() const {
  long steps = 0;
  calls_->steps(memory_, &steps);
  return steps;
}

}  // namespace concord::relative
