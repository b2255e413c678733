#include "compare/audit/places.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "common/rotation.h"

namespace concord::compare {

namespace {

double sinc(double x) { return std::abs(x) < 1e-4 ? 1.0 - x * x / 6.0 : std::sin(x) / x; }

/// (t - sin t) / t^3; below 1 by its series, where the closed form cancels.
double third_coefficient(double t) {
  if (t > 1.0) return (t - std::sin(t)) / (t * t * t);
  double term = 1.0 / 6.0;
  double sum = term;
  for (int k = 1; k < 10; ++k) {
    term *= -t * t / ((2.0 * k + 2.0) * (2.0 * k + 3.0));
    sum += term;
  }
  return sum;
}

/// (1 - cos t) / t^2.
double second_coefficient(double t) { return 0.5 * sinc(0.5 * t) * sinc(0.5 * t); }

}  // namespace

// A = (e0^2 - e.e) 1 + 2 e e^T + 2 e0 e~.
Mat3 rotation_of(const Vec4& p) {
  const Vec3 e = p.tail<3>();
  return (p(0) * p(0) - e.squaredNorm()) * Mat3::Identity() + 2.0 * e * e.transpose() + 2.0 * p(0) * skew(e);
}

Mat3 exponential_of(const Vec3& theta) {
  const double t = theta.norm();
  const Mat3 theta_tilde = skew(theta);
  return Mat3::Identity() + sinc(t) * theta_tilde + second_coefficient(t) * theta_tilde * theta_tilde;
}

Vec4 turned(const Vec4& p, const Vec3& by) {
  const Eigen::Quaterniond turn(exponential_of(by));
  const Eigen::Quaterniond after = (turn * Eigen::Quaterniond(p(0), p(1), p(2), p(3))).normalized();
  return {after.w(), after.x(), after.y(), after.z()};
}

Mat3 exponential_rate(const Vec3& theta) {
  const double t = theta.norm();
  const Mat3 theta_tilde = skew(theta);
  return Mat3::Identity() + second_coefficient(t) * theta_tilde + third_coefficient(t) * theta_tilde * theta_tilde;
}

Vec3 rotation_vector_of(const Mat3& R) {
  const Eigen::Quaterniond turned(R);
  const Vec3 e = turned.w() < 0.0 ? Vec3(-turned.vec()) : Vec3(turned.vec());
  const double sine = e.norm();  // of half the angle
  if (sine < 1e-9) return 2.0 * e;
  return 2.0 * std::atan2(sine, std::abs(turned.w())) / sine * e;
}

PlacedFrame place(const Attachment& side, const BodyState& body) {
  const Mat3 A = rotation_of(body.p);
  PlacedFrame frame;
  if (body.a.size() == 0) {
    frame.lever = A * side.point_L;
    frame.r_P = body.r + frame.lever;
    frame.A_joint = A * side.C;
    frame.v_P = body.v + body.omega.cross(frame.lever);
    frame.omega_joint = body.omega;
    return frame;
  }
  const Vec3 theta = side.Psi_r_L * body.a;
  frame.lever = A * (side.point_L + side.Psi_t_L * body.a);
  frame.r_P = body.r + frame.lever;
  frame.A_joint = A * exponential_of(theta) * side.C;
  frame.v_P = body.v + body.omega.cross(frame.lever) + A * (side.Psi_t_L * body.adot);
  frame.omega_joint = body.omega + A * (exponential_rate(theta) * (side.Psi_r_L * body.adot));
  return frame;
}

RelativeMotion relative_motion(const PlacedFrame& parent, const PlacedFrame& child) {
  const Mat3 to_parent = parent.A_joint.transpose();
  const Vec3 gap = child.r_P - parent.r_P;
  RelativeMotion motion;
  motion.d = to_parent * gap;
  motion.R = to_parent * child.A_joint;
  motion.v_rel << to_parent * (child.v_P - parent.v_P - parent.omega_joint.cross(gap)),
      to_parent * (child.omega_joint - parent.omega_joint);
  return motion;
}

}  // namespace concord::compare
