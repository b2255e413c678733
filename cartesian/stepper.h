#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "cartesian/equations.h"

namespace concord::cartesian {

/// A motion between steps: what a Stepper integrates.
struct Motion {
  VecX q;
  VecX Y;
  double work = 0.0;  // of drivers and modal damping since the start, J
};

/// Carries the motion from t = 0 one internal step at a time, through SUNDIALS.
class Stepper {
 public:
  virtual ~Stepper() = default;

  /// One internal step, not past `stop`, which does not fall from call to call; returns the time reached [s].
  virtual double step(double stop) = 0;
  /// The motion at the time reached; to be projected by whoever needs it closed to round-off.
  [[nodiscard]] virtual const Motion& motion() = 0;
  [[nodiscard]] virtual long steps() const = 0;
  /// Evaluations of the equations of motion so far.
  [[nodiscard]] virtual long evaluations() const = 0;
};

/// Absolute tolerances over [q; Y; work] that follow from rtol and the sizes of the machine: its length, the speed and
/// angular speed that it starts with or would fall with, for modal coordinates the vibration at that speed.
VecX absolute_tolerances(const Equations& equations, const Motion& start, double rtol);

/// Gragg's extrapolation of the midpoint rule, order 10 with an embedded order 8, as an explicit Runge-Kutta method of
/// ARKODE; every step is projected onto the constraints. For machines that are not stiff. `rtol` is held by each step.
std::unique_ptr<Stepper> make_extrapolation_stepper(Equations& equations, const Motion& start, double rtol);

/// IDA (BDF, orders 1 to 5) on the stabilized index-2 equations with KLU: positions and velocities are both
/// constrained, the position rows' extra multipliers mu stay at round-off. For stiff machines. `rtol` is held by each
/// step.
std::unique_ptr<Stepper> make_ida_stepper(Equations& equations, const Motion& start, double rtol);

}  // namespace concord::cartesian
