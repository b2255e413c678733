#pragma once

#include <arkode/arkode.h>
#include <arkode/arkode_ls.h>

#include <memory>
#include <string>

#include "common/sundials.h"

/// The integrators of ARKODE that the solver offers.
namespace concord::relative {

/// What an integrator calls, all with the same user data.
struct StepperCallbacks {
  ARKRhsFn right_side;
  ARKPostProcessFn project;
  ARKEwtFn weigh;
  ARKLsJacFn jacobian;  // of the right side
  void* user_data;
};

/// One integrator, set up and ready to go from time 0. Its calls return negative codes of ARKODE where they fail.
/// ARKODE adds its steps up in one number, whose round-off is the same in many equal steps: what laws of time are asked
/// at would lag behind the sum of the steps, which is what the state has gone. So the difference is kept, and added to
/// all times.
class Stepper {
 public:
  /// "erk" or "dirk", from the state in y, which gives the size. Messages and context must outlive it. Throws
  /// SolverError if ARKODE refuses.
  Stepper(const std::string& name, N_Vector y, const StepperCallbacks& callbacks, const sundials::Context& context,
          sundials::MessageRecord& messages);
  ~Stepper();
  Stepper(const Stepper&) = delete;
  Stepper& operator=(const Stepper&) = delete;

  /// Advances y from t to t_end exactly.
  int advance(double t_end, N_Vector y, double& t);
  /// Makes one step from y and t, at most to t_end; none where t_end lies within the round-off of t. A step in which or
  /// at whose end the right side could not be evaluated is tried again, shorter: ERKStep itself gives up there.
  int step(double t_end, N_Vector y, double& t);
  /// The state at a time within the last step, by the cubic through states and rates at its ends.
  int interpolate(double t, N_Vector y) const;
  /// Begins anew at a state, where the right side may have changed; the first step is tried with h.
  int restart(double t, N_Vector y, double h);
  /// Begins anew at a state that is another name of the one reached, with the step that would have been tried next.
  int rename(double t, N_Vector y);
  /// Makes one step of h from a state, whatever its error; afterwards the integrator must be restarted.
  int step_exactly(double h, N_Vector y, double& t);

  [[nodiscard]] long steps() const;

  /// The calls that two modules of ARKODE have in common.
  struct Calls {
    int (*set_stop_time)(void*, realtype);
    int (*evolve)(void*, realtype, N_Vector, realtype*, int);
    int (*reset)(void*, realtype, N_Vector);
    int (*set_fixed_step)(void*, realtype);
    int (*set_init_step)(void*, realtype);
    int (*steps)(void*, long*);
    int (*current_step)(void*, realtype*);
    int (*last_step)(void*, realtype*);
    int (*interpolate)(void*, realtype, int, N_Vector);
    void (*free)(void**);
  };

 private:
  int try_step(double t_end, N_Vector y, double& t);
  [[nodiscard]] bool is_reached(double t_end) const;
  int reset(double t, N_Vector y);
  int evolve(double t_end, N_Vector y, double& t);

  static int right_side(realtype t, N_Vector y, N_Vector ydot, void* stepper);
  static int project(realtype t, N_Vector y, void* stepper);
  static int weigh(N_Vector y, N_Vector weights, void* stepper);
  static int jacobian(realtype t, N_Vector y, N_Vector ydot, SUNMatrix J, void* stepper, N_Vector, N_Vector, N_Vector);

  const Calls* calls_;
  StepperCallbacks callbacks_;
  double added_up_ = 0.0;    // ARKODE's time [s]
  double beyond_ = 0.0;      // the sum of the steps less that [s]
  sundials::Vector before_;  // the last step
  sundials::Matrix matrix_;
  sundials::LinearSolver linear_;
  void* memory_ = nullptr;
};

}  // namespace concord::relative
