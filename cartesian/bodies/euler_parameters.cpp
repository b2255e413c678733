#include "cartesian/bodies/euler_parameters.h"

#include <cmath>

#include "cartesian/bodies/small_products.h"
#include "common/rotation.h"

namespace concord::cartesian {

Mat3 rotation_of(const Vec4& p) {
  const Vec3 e = p.tail<3>();
  const double along = p(0) * p(0) - e.squaredNorm();
  const Vec3 twice = 2.0 * e;
  const Vec3 across = (2.0 * p(0)) * e;
  Mat3 A;
  A.col(0) = vector_of(Pair{along + twice.x() * e.x(), twice.x() * e.y() + across.z()}, twice.x() * e.z() - across.y());
  A.col(1) = vector_of(Pair{twice.y() * e.x() - across.z(), along + twice.y() * e.y()}, twice.y() * e.z() + across.x());
  A.col(2) = vector_of(Pair{twice.z() * e.x() + across.y(), twice.z() * e.y() - across.x()}, along + twice.z() * e.z());
  return A;
}

Mat34 compute_E(const Vec4& p) {
  Mat34 E;
  E.col(0) = -p.tail<3>();
  E.rightCols<3>() = p(0) * Mat3::Identity() + skew(p.tail<3>());
  return E;
}

Vec4 compute_pdot(const Vec4& p, const Vec3& omega) { return 0.5 * compute_E(p).transpose() * omega; }

Vec4 euler_parameters_of(const Mat3& A) {
  // 4 p p^T has entries that are linear in A; its largest diagonal entry gives the well-conditioned column.
  Eigen::Matrix4d square;
  const double trace = A.trace();
  square(0, 0) = 1.0 + trace;
  const Vec3 axial(A(2, 1) - A(1, 2), A(0, 2) - A(2, 0), A(1, 0) - A(0, 1));
  square.block<3, 1>(1, 0) = axial;
  square.block<1, 3>(0, 1) = axial.transpose();
  square.bottomRightCorner<3, 3>() = A + A.transpose() + (1.0 - trace) * Mat3::Identity();
  Eigen::Index best = 0;
  square.diagonal().maxCoeff(&best);
  const Vec4 p = square.col(best).normalized();
  return p(0) < 0.0 ? Vec4(-p) : p;
}

}  // namespace concord::cartesian
