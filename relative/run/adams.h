#pragma once

#include <array>
#include <exception>
#include <optional>

#include "relative/run/integrated_system.h"
#include "relative/run/modal_oscillators.h"
#include "relative/run/past_rates.h"
#include "relative/run/step_weights.h"
#include "relative/run/stepper.h"

namespace concord::relative {

/// The explicit integrator "adams": a multistep method of variable length and order 1 to 12 that integrates the ringing
/// of modes exactly. A step is predicted from the rates at past times, corrected with the rates there, projected, and
/// evaluated again (PECE with local extrapolation, as in Shampine and Gordon, Computer Solution of Ordinary
/// Differential Equations, 1975), by polynomials through the actual past times. After construction it allocates nothing
/// but where the oscillators are renewed.
class Adams : public Stepper {
 public:
  /// Of steps [s]: the first that is tried, and the longest that is made.
  struct Lengths {
    double first;
    double longest;
  };
  /// From y at time 0. The system must outlive this object.
  Adams(IntegratedSystem& system, ModalOscillators modes, const VecX& y, Lengths lengths);

  [[nodiscard]] double t() const override { return at_.t; }
  [[nodiscard]] const VecX& y() const override { return at_.y; }
  [[nodiscard]] long steps() const override { return steps_; }
  /// Order of the predictor of the last step.
  [[nodiscard]] int order() const { return last_order_; }

  /// What lies beyond t_end may follow other formulas: a step that ends there is the last that knows a past.
  void step(double t_end) override;
  void step_exactly(double h) override;
  void restart(double h) override;
  void rename(const VecX& y) override;
  [[nodiscard]] bool has_dense_output() const override { return true; }
  /// By the polynomials through the rates at both ends of the step and before (R89).
  void interpolate(double t, Eigen::Ref<VecX> y) override;

 private:
  /// Where a step ends. Time is kept with what the sum of steps has lost by rounding.
  struct Point {
    double t = 0.0;
    double beyond = 0.0;
    VecX y;
    PastRates past;
  };

  void begin();
  [[nodiscard]] double length_within(double rest) const;
  bool try_step(double h, std::optional<double> t_end);
  bool predict_and_correct(double h, double t);
  bool take(double h, double t);
  bool evaluate(double t, const VecX& y);
  [[noreturn]] void throw_failure() const;
  void shorten_after(double h);
  [[nodiscard]] double choose_next(double h);
  double norm_of_difference(int order);
  [[nodiscard]] double norm(const VecX& x) const;
  void renew();

  IntegratedSystem* system_;
  ModalOscillators modes_;
  StepWeights weights_, dense_;
  Point at_, before_;  // where the last step has ended, and where it began
  VecX candidate_;     // y
  VecX rates_, z_, remainder_;
  VecX change_, error_, error_weights_, no_modes_;
  MatX S_, D_;
  std::array<double, kMostTimes> error_constants_{};  // by order (R88)
  std::exception_ptr failure_;                        // of the last evaluation that failed in this step
  double error_norm_ = 0.0;
  int rejections_ = 0;  // of this step
  double h_;            // to be tried next
  double longest_;
  int order_ = 1;
  double last_h_ = 0.0;
  int last_order_ = 1;
  bool begins_ = true;   // without a past
  bool climbs_ = false;  // from order to order, as after a begin
  long steps_since_renewal_ = 0;
  long steps_ = 0;
};

}  // namespace concord::relative
