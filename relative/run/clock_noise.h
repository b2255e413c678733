#pragma once

#include <functional>

#include "common/model.h"
#include "common/types.h"

/// What the round-off of time leaves in rates that depend on it.
namespace concord::relative {

/// Laws of time are evaluated at rounded times, and where they change fast that shows: rates come with a noise of the
/// time's round-off times their partial derivative by time. An integrator that is asked for less shortens its steps to
/// no avail. Measured at the ends of steps, now and then.
class ClockNoise {
 public:
  /// Rates ydot(t, y); throws SolverError where they cannot be evaluated.
  using Rates = std::function<void(double t, const Eigen::Ref<const VecX>& y, const Eigen::Ref<VecX>& ydot)>;

  ClockNoise(const Model& model, Eigen::Index size);

  /// A step has ended at t in y.
  void pass(double t, const Eigen::Ref<const VecX>& y, const Rates& rates);
  /// Errors of a step that are noise, in the units of y.
  [[nodiscard]] const VecX& of_step() const { return of_step_; }

 private:
  bool is_needed_;
  long steps_ = 0;
  double before_ = 0.0;  // the end of the last step [s]
  double h_ = 0.0;       // a step of late [s]
  VecX now_, later_, change_, of_step_;
};

}  // namespace concord::relative
