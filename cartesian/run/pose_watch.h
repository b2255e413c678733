#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "cartesian/dynamics/dynamics.h"
#include "cartesian/run/stepper.h"

namespace concord::cartesian {

/// Follows a motion from step to step: takes other independent rows where those in use become dependent, and sees
/// singular poses on and between steps.
///
/// The pivots of J M^-1 J^T, J the rows in use, eliminated in a fixed order, are positive as long as the rows are
/// independent. Where a motion passes a singular pose, on its branch or into another one, a root of them falls to zero
/// and rises again as steeply, and in the middle of a step it is not the mean of the ends, however near both are. It is
/// everywhere else, where the step is short enough.
class PoseWatch {
 public:
  /// At the motion's start, with the rows in use there; `generic_rank`: that of the machine where it is
  /// not singular.
  PoseWatch(Dynamics& dynamics, int generic_rank, double t, const MotionState& start);
  ~PoseWatch();
  PoseWatch(const PoseWatch&) = delete;
  PoseWatch& operator=(const PoseWatch&) = delete;

  /// The motion has come to t, at the end of a step or within it. True if other rows are in use from now on. Throws
  /// SingularPose where the motion has passed or reached a singular pose.
  bool follow(double t, const MotionState& motion, bool ends_step);

  /// An integrator has stopped for this reason. Throws SingularPose if the constraints were about to lose rank.
  void explain_stop(const std::string& reason) const;

 private:
  /// A pose of the motion and the pivots of J M^-1 J^T over the rows chosen there.
  struct PoseSample {
    double t = 0.0;
    VecX q;
    VecX Y;
    std::vector<double> values;  // of the matrix
    std::vector<bool> rows;
    VecX pivots;
  };
  class RowPivots;

  PoseSample sample_pose(double t, const MotionState& motion);
  PoseSample sample_between(const PoseSample& before, const PoseSample& after);
  void choose(PoseSample& at);
  bool has_weakened(const PoseSample& now);
  void refuse_vanished(const PoseSample& now);
  VecX own_pivots(const PoseSample& at, const std::vector<bool>& rows);
  static double rate_of_change(const PoseSample& before, const PoseSample& after);
  bool stays_independent(const PoseSample& before, const PoseSample& middle, const PoseSample& after,
                         const std::vector<bool>& rows);
  bool is_straight_so_far(const PoseSample& now);
  void bisect(const PoseSample& before, const PoseSample& after, int depth);
  [[noreturn]] void refuse(double t, RowIndex row) const;

  Dynamics& dynamics_;
  Equations& equations_;
  int generic_rank_;
  bool may_lose_rank_;
  std::unique_ptr<RowPivots> pivots_;
  PoseSample before_last_;
  PoseSample last_;
  VecX chosen_pivots_;       // where the rows in use were chosen
  VecX largest_pivots_;      // so far
  double least_left_ = 0.0;  // velocity residual at the last choice of rows on its account, of the largest speed
  double rate_ = HUGE_VAL;   // of the change of pivots over the last step, relative [1/s]
  RowIndex weakest_row_;
};

}  // namespace concord::cartesian
