#pragma once

#include <vector>

#include "compare/equilibrium/stiffness.h"

namespace concord::compare {

/// Unstable motions of a machine at rest: positive eigenvalues of J = -M^-1 K (Stiffness::J), which are squared rates.
class Growth {
 public:
  /// Counts growth that exceeds `least` [1/s2] and what differences resolve of the eigenvalue.
  Growth(const Stiffness& stiffness, double least);

  [[nodiscard]] int count() const { return static_cast<int>(growing_.size()); }
  /// The largest of them [1/s2], or zero.
  [[nodiscard]] double steepest() const { return steepest_; }

  /// What to subtract from the stiffness per inertia so that growth by more than `rate` [1/s2] becomes decay as fast:
  /// twice the real part, in the subspace of these motions.
  [[nodiscard]] MatX reversed_above(double rate) const;

  /// Accelerations f without their parts along these motions where all of them are at most `least` [1/s2]: of a machine
  /// that stands upright they are round-off, which must not decide to which side it falls.
  [[nodiscard]] VecX without_negligible(const VecX& f, double least) const;

 private:
  Eigen::VectorXcd values_;
  Eigen::MatrixXcd right_;
  Eigen::MatrixXcd left_;  // rows; right_ inverted
  std::vector<Eigen::Index> growing_;
  double steepest_ = 0.0;
};

}  // namespace concord::compare
