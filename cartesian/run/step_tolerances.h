#pragma once

#include "cartesian/run/stepper.h"

namespace concord::cartesian {

/// Absolute tolerances over [q; Y; work] of an explicit method, which does not ask for less than round-off leaves, and
/// for modes by what vibrates: they follow from rtol and motion_sizes(), and change with the motion (C63).
class StepTolerances {
 public:
  /// `dynamics` must outlive this object.
  StepTolerances(Dynamics& dynamics, const MotionState& start, Tolerance tolerance);

  [[nodiscard]] double rtol() const { return tolerance_.rtol; }
  [[nodiscard]] const VecX& absolute() const { return absolute_; }

  /// A step of this length [s] has brought the motion to t; `largest_work` [J]: the largest |work| so far. True if
  /// tolerances have changed.
  bool follow(double t, double step, const MotionState& motion, double largest_work);

 private:
  [[nodiscard]] VecX sizes_of_places(const VecX& q) const;
  [[nodiscard]] VecX measure_round_off(double t, const MotionState& motion);
  [[nodiscard]] double share_for(const MotionState& motion) const;
  bool follow_work(double largest_work);
  bool follow_modes(double t, const MotionState& motion);
  bool follow_time(double t, double step, const MotionState& motion);
  [[nodiscard]] VecX wanted_of_motion() const;

  Dynamics& dynamics_;
  const Layout& layout_;
  Tolerance tolerance_;
  VecX asked_;      // by rtol and the sizes of the machine
  VecX round_off_;  // of places and speeds
  VecX absolute_;
  double share_of_modes_ = 0.0;  // of what is asked
  bool has_laws_of_time_;
  int unseen_ = 0;        // steps since the noise of time was looked at
  double longest_ = 0.0;  // of them [s]
  VecX change_;           // of accelerations with time
  VecX noise_;            // of time, in the speeds
};

}  // namespace concord::cartesian
