#pragma once

#include <exception>

#include "common/sundials.h"
#include "relative/run/stepper.h"

namespace concord::relative {

/// The implicit integrator "dirk": ARKODE's ESDIRK547L2SA2, stiffly accurate, of order 5, with dense Newton matrices.
/// ARKODE adds its steps up in one number, whose round-off is the same in many equal steps: what laws of time are asked
/// at would lag behind the sum of the steps, which is what the state has gone. So the difference is kept, and added to
/// all times.
class ImplicitStepper : public Stepper {
 public:
  /// From y at time 0. The system must outlive this object. Throws SolverError if ARKODE refuses.
  ImplicitStepper(IntegratedSystem& system, const VecX& y);
  ~ImplicitStepper() override;
  ImplicitStepper(const ImplicitStepper&) = delete;
  ImplicitStepper& operator=(const ImplicitStepper&) = delete;

  [[nodiscard]] double t() const override { return t_; }
  [[nodiscard]] const VecX& y() const override { return y_; }
  [[nodiscard]] long steps() const override;
  void step(double t_end) override;
  void step_exactly(double h) override;
  void restart(double h) override;
  void rename(const VecX& y) override;
  [[nodiscard]] bool has_dense_output() const override { return false; }
  /// By the cubic through states and rates at both ends.
  void interpolate(double t, Eigen::Ref<VecX> y) override;

 private:
  void set_up();
  int try_step(double t_end);
  [[nodiscard]] bool is_reached(double t_end) const;
  void reset();
  int evolve(double t_end);
  void require_good(int code) const;
  template <typename Call>
  int guarded(const Call& call, int failure);

  static int right_side(realtype t, N_Vector y, N_Vector ydot, void* stepper);
  static int project(realtype t, N_Vector y, void* stepper);
  static int weigh(N_Vector y, N_Vector weights, void* stepper);
  static int jacobian(realtype t, N_Vector y, N_Vector ydot, SUNMatrix J, void* stepper, N_Vector, N_Vector, N_Vector);

  IntegratedSystem* system_;
  sundials::Context context_;
  sundials::MessageRecord messages_;
  std::exception_ptr failure_;  // of the system in this step, which may be why ARKODE fails
  double t_ = 0.0;
  double t_before_ = 0.0;  // of the last step
  VecX y_, y_before_;
  double added_up_ = 0.0;  // ARKODE's time [s]
  double beyond_ = 0.0;    // the sum of the steps less that [s]
  sundials::Vector vector_;
  sundials::Matrix matrix_;
  sundials::LinearSolver linear_;
  void* memory_ = nullptr;
};

}  // namespace concord::relative
