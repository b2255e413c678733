#pragma once

#include <memory>
#include <vector>

#include "cartesian/bodies/constraints.h"
#include "cartesian/dynamics/augmented_matrix.h"
#include "cartesian/dynamics/inertia_elimination.h"
#include "cartesian/dynamics/state_scales.h"

namespace concord::cartesian {

/// Factors of the equations of motion in a state nearby: by elimination, if it is given, else those of the matrix.
struct NearbyFactors {
  SparseLu& lu;
  InertiaElimination* elimination;

  void solve(VecX& x) const { elimination != nullptr ? elimination->solve(x) : lu.solve(x); }
};

/// Brings positions and velocities onto the constraints (C48): velocities nearest in the sense of the mass matrix,
/// positions too but for modes, which are moved as little as their stiffness asks; rows that hold for velocities alone
/// do not restrict positions. It moves constraints of its own: the equations stay as they are.
class Projection {
 public:
  explicit Projection(const Equations& equations);

  /// Which constraint rows take part, by row.
  void use_rows(const std::vector<bool>& active);

  /// Newton's method with one matrix until the residuals stop falling: that of the last update of the equations, with
  /// these factors. Throws SolverError if residuals stay above 1e-9 in the machine's units. Returns how often residuals
  /// hold their round-off there; overwritten by the next call.
  const RoundOffShares& project(const Equations& equations, const NearbyFactors& nearby, double t, Eigen::Ref<VecX> q,
                                Eigen::Ref<VecX> Y);
  /// The largest velocity residual that the last projection left, of dependent rows too, of the largest speed: grows
  /// with the condition of the rows in use.
  [[nodiscard]] double velocity_residual_left() const { return velocity_residual_left_; }

 private:
  [[nodiscard]] NearbyFactors factor_position_matrix(const Equations& equations, const NearbyFactors& nearby);
  PlacedConstraints& project_positions(const Equations& equations, const NearbyFactors& nearby, double t,
                                       Eigen::Ref<VecX> q);
  void project_velocities(PlacedConstraints& placed, const Equations& equations, const NearbyFactors& nearby, double t,
                          Eigen::Ref<VecX> Y);
  void solve_constraint_step(const NearbyFactors& factors);

  std::unique_ptr<Constraints> constraints_;
  /// The matrix that steps of positions are taken with: no rows that hold for velocities alone, and modes held by their
  /// stiffness, so that they take no round-off of the joints. nullptr: it is the matrix itself.
  std::unique_ptr<AugmentedMatrix> position_matrix_;
  std::unique_ptr<InertiaElimination> position_elimination_;
  bool has_new_rows_ = true;  // since the last factorization of the position matrix
  std::vector<bool> active_;
  RoundOffShares shares_;
  double velocity_residual_left_ = 0.0;
  VecX residual_;
  VecX unknowns_;
  VecX step_;
  ByBody<MatX> stiffening_;  // what is added to modal masses
};

}  // namespace concord::cartesian
