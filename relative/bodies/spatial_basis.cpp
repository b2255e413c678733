#include "relative/bodies/spatial_basis.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace concord::relative {

namespace {

constexpr double kLeastPivot = 1e-9;  // of a column's length: below any pose that Mobilizer::loses_rank admits

/// A unit vector at right angles to a unit vector.
Vec3 perpendicular(const Vec3& unit) {
  int least = 0;
  unit.cwiseAbs().minCoeff(&least);
  return unit.cross(Vec3::Unit(least)).normalized();
}

}  // namespace

void SpatialBasis::decompose(const Mat3& columns, int n) {
  n_ = n;
  if (n == 0) {
    Q_.setIdentity();
    return;
  }
  const double length = columns.col(0).norm();
  const bool vanishes = !(length > 0.0);
  R_(0, 0) = length;
  one_over_pivot_(0) = vanishes ? 0.0 : 1.0 / length;
  Q_.col(0) = vanishes ? Vec3::UnitX() : Vec3(columns.col(0) * one_over_pivot_(0));
  if (n == 1) {
    Q_.col(1) = perpendicular(Q_.col(0));
  } else {
    add(columns.col(1), 1);
  }
  Q_.col(2) = Q_.col(0).cross(Q_.col(1));
  if (n == 3) add(columns.col(2), 2);
}

/// The direction that the column adds to those before it, and its entries of R.
void SpatialBasis::add(const Vec3& column, int place) {
  Vec3 rest = column;
  for (int k = 0; k < place; ++k) R_(k, place) = 0.0;
  for (int round = 0; round < 2; ++round) {
    for (int k = 0; k < place; ++k) {
      const double part = Q_.col(k).dot(rest);
      R_(k, place) += part;
      rest -= part * Q_.col(k);
    }
  }
  // Two directions leave the third no choice but its sign.
  const double pivot = place == 2 ? Q_.col(2).dot(rest) : rest.norm();
  const bool depends = !(std::abs(pivot) > kLeastPivot * column.norm());
  R_(place, place) = pivot;
  one_over_pivot_(place) = depends ? 0.0 : 1.0 / pivot;
  if (place == 1) Q_.col(1) = depends ? perpendicular(Q_.col(0)) : Vec3(rest * one_over_pivot_(1));
}

Vec3 SpatialBasis::fit(const Vec3& v) const {
  Vec3 x = Vec3::Zero();
  for (int k = n_ - 1; k >= 0; --k) {
    double rest = Q_.col(k).dot(v);
    for (int later = k + 1; later < n_; ++later) rest -= R_(k, later) * x(later);
    x(k) = rest * one_over_pivot_(k);
  }
  return x;
}

double least_independent_part(const Mat3& columns, int n) {
  if (n == 0) return std::numeric_limits<double>::infinity();
  int longest = 0;
  const double length = columns.leftCols(n).colwise().norm().maxCoeff(&longest);
  if (n == 1) return length;
  const Vec3 a = columns.col(longest);
  double area = 0.0;
  for (int c = 0; c < n; ++c) area = std::max(area, a.cross(columns.col(c)).norm());
  if (n == 2) return length > 0.0 ? area / length : 0.0;
  return area > 0.0 ? std::abs(columns.determinant()) / area : 0.0;
}

}  // namespace concord::relative
