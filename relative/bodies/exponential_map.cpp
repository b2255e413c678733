#include "relative/bodies/exponential_map.h"

#include <Eigen/Geometry>
#include <cmath>

#include "common/rotation.h"

namespace concord::relative {

namespace {

/// With t = |theta|: c1 = sin t / t, c2 = (1 - cos t) / t^2, c3 = (t - sin t) / t^3, and the rates of the last two
/// divided by (theta . thetadot): k2 = c2' / t, k3 = c3' / t.
struct Coefficients {
  double c1, c2, c3, k2, k3;
};

/// Power series in x = t^2: c1, c2, c3 have the terms (-x)^n / (2n + 1)!, (2n + 2)!, (2n + 3)!; k = 2 dc/dx. Ten terms
/// are exact to round-off for x <= 1.
Coefficients series(double x) {
  Coefficients sum{0.0, 0.0, 0.0, 0.0, 0.0};
  double term = 1.0;   // (-x)^n / (2n + 1)!
  double slope = 0.0;  // (-1)^n x^(n - 1) / (2n + 1)!: d(term)/dx is n times it
  for (int n = 0; n < 10; ++n) {
    const double to_c2 = 1.0 / (2 * n + 2);
    const double to_c3 = to_c2 / (2 * n + 3);
    sum.c1 += term;
    sum.c2 += term * to_c2;
    sum.c3 += term * to_c3;
    sum.k2 += 2.0 * n * slope * to_c2;
    sum.k3 += 2.0 * n * slope * to_c3;
    slope = -term * to_c3;
    term *= -x * to_c3;
  }
  return sum;
}

Coefficients closed_forms(double t) {  // (R2)
  const double t2 = t * t;
  Coefficients c{};
  c.c1 = std::sin(t) / t;
  c.c2 = (1.0 - std::cos(t)) / t2;
  c.c3 = (t - std::sin(t)) / (t2 * t);
  c.k2 = (c.c1 - 2.0 * c.c2) / t2;
  c.k3 = (c.c2 - 3.0 * c.c3) / t2;
  return c;
}

Coefficients coefficients(const Vec3& theta) {
  const double x = theta.squaredNorm();
  return x <= 1.0 ? series(x) : closed_forms(std::sqrt(x));
}

}  // namespace

ExponentialMap exponential_map(const Vec3& theta) {
  const Coefficients c = coefficients(theta);
  const Mat3 w = skew(theta);
  const Mat3 w2 = w * w;
  return {Mat3::Identity() + c.c1 * w + c.c2 * w2, Mat3::Identity() + c.c2 * w + c.c3 * w2};
}

Mat3 tangent_rate(const Vec3& theta, const Vec3& thetadot) {
  const Coefficients c = coefficients(theta);
  const double stretch = theta.dot(thetadot);
  const Mat3 w = skew(theta);
  const Mat3 wdot = skew(thetadot);
  return c.k2 * stretch * w + c.c2 * wdot + c.k3 * stretch * w * w + c.c3 * (wdot * w + w * wdot);
}

Vec3 rotation_vector(const Mat3& R) {
  const Eigen::Quaterniond p(R);
  const double s = p.vec().norm();
  if (s == 0.0) return Vec3::Zero();
  const double angle = 2.0 * std::atan2(s, std::abs(p.w()));
  return p.vec() * std::copysign(angle / s, p.w());
}

Mat3 rotation_from_euler_parameters(const Vec4& p) {
  return Eigen::Quaterniond(p(0), p(1), p(2), p(3)).normalized().toRotationMatrix();
}

Vec4 euler_parameters(const Mat3& R, const Vec4& near) {
  const Eigen::Quaterniond p = Eigen::Quaterniond(R).normalized();
  const Vec4 found(p.w(), p.x(), p.y(), p.z());
  return found.dot(near) < 0.0 ? Vec4(-found) : found;
}

}  // namespace concord::relative
