#include "common/joints/by_function.h"

namespace concord::joints {

namespace {

/// The vector w with column_k' = w x column_k for the columns of a rotation: half the sum of column_k x column_k'.
Vec3 axis_of(const Mat3& R, const Mat3& change) {  // (S19)
  Vec3 twice = Vec3::Zero();
  for (int k = 0; k < 3; ++k) twice += R.col(k).cross(change.col(k));
  return 0.5 * twice;
}

}  // namespace

PlacementOf<Jet> moving(const Placement& at, const Vec6& v_rel) {
  const Vec3 omega = v_rel.tail<3>();
  PlacementOf<Jet> placement;
  for (int row = 0; row < 3; ++row) placement.d(row) = Jet(at.d(row), Vec6::Unit(row), v_rel(row), 0.0);
  for (int column = 0; column < 3; ++column) {
    const Vec3 axis = at.R.col(column);
    const Vec3 swing = omega.cross(axis);
    const Vec3 swing_of_swing = omega.cross(swing);
    for (int row = 0; row < 3; ++row) {
      Vec6 gradient = Vec6::Zero();
      gradient.tail<3>() = axis.cross(Vec3::Unit(row));  // row of rho x axis
      placement.R(row, column) = Jet(axis(row), gradient, swing(row), swing_of_swing(row));
    }
  }
  return placement;
}

void write_motion(const PlacementOf<Jet>& reached, int n, FunctionOfCoordinates::Motion& motion) {
  Mat3 R_over;
  for (int row = 0; row < 3; ++row) {
    motion.placement.d(row) = reached.d(row).value;
    motion.Sdot_u(row) = reached.d(row).rate_of_rate;
    for (int column = 0; column < 3; ++column) {
      motion.placement.R(row, column) = reached.R(row, column).value;
      R_over(row, column) = reached.R(row, column).rate_of_rate;
    }
  }
  motion.Sdot_u.tail<3>() = axis_of(motion.placement.R, R_over);
  motion.S.setZero();
  for (int k = 0; k < n; ++k) {
    for (int row = 0; row < 3; ++row) {
      motion.S(row, k) = reached.d(row).gradient(k);
      for (int column = 0; column < 3; ++column) R_over(row, column) = reached.R(row, column).gradient(k);
    }
    motion.S.col(k).tail<3>() = axis_of(motion.placement.R, R_over);
  }
}

}  // namespace concord::joints
