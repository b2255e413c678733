#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "cartesian/dynamics.h"
#include "cartesian/stepper.h"

namespace concord::cartesian {

/// Follows a motion from step to step: takes other independent rows where those in use become dependent, and sees
/// singular poses on and between steps.
///
/// For two poses a and b of a motion take the matrix J_b M^-1 J_a^T, J the rows in use. It is positive definite for
/// b = a. While the null space of the rows hardly rotates from a to b, its pivots, eliminated in a fixed order, stay
/// near the geometric means of the pivots at a and at b. A null space that rotates is followed by looking at poses
/// between a and b. Two things remain however near a and b are: the change of sign where the rows lose rank, and the
/// sudden rotation where a motion changes to another branch.
///
/// Neither happens where a motion goes over into a neighbouring branch, or where drivers leave the machine no motion.
/// There the square roots of the pivots of J M^-1 J^T fall to zero and rise again as steeply: extrapolation from either
/// end and the middle to the other end fails, however near both are. It fails nowhere else.
class PoseWatch {
 public:
  /// At the motion's start, with the rows in use there; `generic_rank`: that of the machine where it is
  /// not singular.
  PoseWatch(Dynamics& dynamics, int generic_rank, double t, const MotionState& start);
  ~PoseWatch();
  PoseWatch(const PoseWatch&) = delete;
  PoseWatch& operator=(const PoseWatch&) = delete;

  /// The motion has come to t. True if other rows are in use from now on. Throws SingularPose where the motion
  /// has passed or reached a singular pose.
  bool follow(double t, const MotionState& motion);

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
  class Overlap;

  PoseSample sample_pose(double t, const MotionState& motion);
  PoseSample sample_between(const PoseSample& before, const PoseSample& after);
  void choose(PoseSample& at);
  bool has_weakened(const PoseSample& now);
  void refuse_vanished(const PoseSample& now);
  VecX own_pivots(const PoseSample& at, const std::vector<bool>& rows);
  bool is_continuous(const PoseSample& before, const PoseSample& after, const std::vector<bool>& rows);
  static double rate_of_change(const PoseSample& before, const PoseSample& after);
  bool stays_independent(const PoseSample& before, const PoseSample& middle, const PoseSample& after,
                         const std::vector<bool>& rows);
  void bisect(const PoseSample& before, const PoseSample& after, bool changes_little, int depth);
  [[noreturn]] void refuse(double t, RowIndex row) const;

  Dynamics& dynamics_;
  Equations& equations_;
  int generic_rank_;
  bool may_lose_rank_;
  std::unique_ptr<Overlap> overlap_;
  PoseSample last_;
  VecX chosen_pivots_;       // where the rows in use were chosen
  VecX largest_pivots_;      // so far
  double least_left_ = 0.0;  // velocity residual at the last choice of rows on its account, of the largest speed
  double rate_ = HUGE_VAL;   // of the change of pivots over the last step, relative [1/s]
  RowIndex weakest_row_;
};

/// Whether the constraints of a model can depend on each other at all: it has couplings, or joints that close a loop.
bool may_lose_rank(const Model& model);

}  // namespace concord::cartesian
