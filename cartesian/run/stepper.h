#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "cartesian/dynamics/dynamics.h"

namespace concord::cartesian {

/// The state of a motion between steps: what a Stepper integrates.
struct MotionState {
  VecX q;
  VecX Y;
  double work = 0.0;  // of drivers, springs, force elements and modal damping since the start, J
};

/// Carries the motion from t = 0 one internal step at a time. The regimes of tires and stops, which the caller holds,
/// stay during a step; where one ends inside a step, the step is cut there, the regimes are set anew, and the
/// integration starts again.
class Stepper {
 public:
  virtual ~Stepper() = default;
  Stepper(const Stepper&) = delete;
  Stepper& operator=(const Stepper&) = delete;

  /// One internal step, or a part of it that is short enough to see what happens meanwhile, or as far as `stop`, which
  /// does not fall from call to call; returns the time reached [s]. The equations are smooth as far as `limit`, which
  /// is not less. Throws SolverError where no step succeeds, or where regimes change without end.
  double step(double stop, double limit);
  /// The motion at the time reached; to be projected by whoever needs it closed to round-off. Within a step it is good
  /// enough to look at, but at `stop` as exact as at its end.
  [[nodiscard]] const MotionState& motion() const { return motion_; }
  /// Whether that is not the end of an internal step.
  [[nodiscard]] bool is_within_step() const { return time_ < reached_; }
  [[nodiscard]] long steps() const { return steps_; }
  /// The equations change here, and the motion goes on as it was reached: other rows are in use from now on, or a law
  /// of time goes on as another formula.
  void begin_anew();
  /// Evaluations of the equations of motion so far.
  [[nodiscard]] long evaluations() const { return evaluations_; }
  /// The largest |work| after any step so far [J].
  [[nodiscard]] double largest_work() const { return largest_work_; }

 protected:
  Stepper(Dynamics& dynamics, const MotionState& start);

  /// One step of the method from reached_ on, which it moves; motion_ is then that at reached_.
  virtual void advance(double limit) = 0;
  /// The motion at a time within the last step, good enough to see what happens there.
  virtual const MotionState& interpolate(double t) = 0;
  /// Sets motion_ to that at a time within the last step, as exact as the step.
  virtual void set_motion_at(double t) = 0;
  /// Starts the method again at time t from motion_.
  virtual void restart(double t) = 0;
  /// Equal parts of a step that who follows the motion should look at one by one.
  [[nodiscard]] virtual int parts_of_step() const = 0;
  /// Whether the method remembers multipliers, which belong to the rows in use.
  [[nodiscard]] virtual bool remembers_multipliers() const = 0;

  Dynamics& dynamics_;
  Equations& equations_;
  MotionState motion_;
  double reached_ = 0.0;  // by the method; time_ may lag behind
  long steps_ = 0;
  long evaluations_ = 0;
  double largest_work_ = 0.0;

 private:
  const VecX& event_functions(double t, const MotionState& motion);
  double event_function(double t, const MotionState& motion);
  double event_function_at(double t);
  double next_look();
  double find_outside();
  double find_minimum(Eigen::Index function, double low, double high);
  double locate_event();
  void pass_event();
  void close_motion(double t);
  void note_rate(double t);
  void refuse_chatter();

  bool has_regimes_;
  double time_ = 0.0;
  double began_ = 0.0;               // the last step, at
  int looks_ = 0;                    // parts of it that are done
  double fastest_ = 0.0;             // rate of the machine so far [1/s]
  double event_;                     // in the last step, not yet passed; HUGE_VAL: none
  AppliedForceIndex nearest_event_;  // the applied force whose event function was the smallest
  MatX event_samples_;               // event functions at equal times of the last step, by column
  double events_since_ = 0.0;
  int events_ = 0;
};

/// Relative tolerance of each step, and the time of the run [s].
struct Tolerance {
  double rtol;
  double until;
};

/// Collocation at Gauss's eight points, order 16, with the vibrations of modes integrated exactly; every step is
/// projected onto the constraints. For machines that are not stiff. Each step holds `tolerance`.
std::unique_ptr<Stepper> make_collocation_stepper(Dynamics& dynamics, const MotionState& start, Tolerance tolerance);

/// IDA (BDF, orders 1 to 5) on the stabilized index-2 equations with KLU: positions and velocities are both
/// constrained, the position rows' extra multipliers mu stay at round-off. For stiff machines. Each step holds
/// `tolerance`.
std::unique_ptr<Stepper> make_ida_stepper(Dynamics& dynamics, const MotionState& start, Tolerance tolerance);

}  // namespace concord::cartesian
