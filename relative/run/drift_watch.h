#pragma once

#include "common/types.h"

namespace concord::relative {

/// Looks at what the projection takes away after each step. The exact motion keeps to the constraints, so that these
/// are errors of integration: the smaller, the shorter the step is. Where accelerations contradict the constraints it
/// is a part of the way itself, however short steps are: an integrator makes them ever shorter and gets nowhere.
class DriftWatch {
 public:
  /// Of a run of so many integrated numbers.
  explicit DriftWatch(Eigen::Index size);

  /// A run begins at these numbers, or goes on at them by other names.
  void stand_at(const Eigen::Ref<const VecX>& y) { before_ = y; }

  /// A step has led to `reached`, which was projected to `projected`. `weights`: the factors of errors by which steps
  /// are accepted. False if the projection has drawn the motion aside for many steps.
  [[nodiscard]] bool pass(const VecX& reached, const Eigen::Ref<const VecX>& projected, const VecX& weights);
  /// What the projection took away in these steps as a part of their way.
  [[nodiscard]] double part() const { return taken_.norm() / way_; }

 private:
  VecX before_;
  VecX taken_;  // by the projection, in allowed errors of a step
  double way_ = 0.0;
  int steps_ = 0;
};

}  // namespace concord::relative
