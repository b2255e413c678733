#pragma once

#include <memory>
#include <string>

#include "common/types.h"
#include "relative/run/integrated_system.h"

/// The integrators that the solver offers, step by step.
namespace concord::relative {

/// One integrator, ready to go from time 0. Calls throw SolverError where they fail.
class Stepper {
 public:
  virtual ~Stepper() = default;

  [[nodiscard]] virtual double t() const = 0;
  [[nodiscard]] virtual const VecX& y() const = 0;
  [[nodiscard]] virtual long steps() const = 0;

  /// Makes one step, to t_end at most; none where t_end lies within the round-off of time. Beyond t_end rates may go on
  /// by other formulas, without a jump. A step in which or at whose end the system is not defined is tried again,
  /// shorter.
  virtual void step(double t_end) = 0;
  /// Makes the last step anew with another length, whatever its error; restart() must follow.
  virtual void step_exactly(double h) = 0;
  /// Begins anew at this state, where rates may have changed with a jump; the first step is tried with h.
  virtual void restart(double h) = 0;
  /// The state has got another name, y, at which rates are the same.
  virtual void rename(const VecX& y) = 0;
  /// Whether states within a step are as accurate as its end; else samples must end steps.
  [[nodiscard]] virtual bool has_dense_output() const = 0;
  /// The state at a time within the last step, not projected.
  virtual void interpolate(double t, Eigen::Ref<VecX> y) = 0;
};

}  // namespace concord::relative
