#include "cartesian/forces/element_forces.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "cartesian/forces/spring_forces.h"
#include "cartesian/forces/tire_forces.h"
#include "common/error.h"
#include "common/rotation.h"

namespace concord::cartesian {

namespace {

/// theta = log(R). Throws SolverError beyond 175 deg.
Vec3 rotation_vector(const Mat3& R, const std::string& name, double t) {
  const Eigen::AngleAxisd turn(R);
  if (!(turn.angle() <= kLargestAngle)) {
    throw SolverError(fmt::format(
        "cartesian: at t = {:.6g} s bushing '{}' is turned by {:.1f} deg, allowed are 175 deg where it resists turning",
        t, name, turn.angle() * 180.0 / EIGEN_PI));
  }
  return turn.angle() * turn.axis();
}

/// J^-T of the rotation vector: 1 + theta~ / 2 + c theta~^2, c = (1 - (t/2) cot(t/2)) / t^2 (C36).
Mat3 inverse_transposed_tangent(const Vec3& theta) {
  const double t_squared = theta.squaredNorm();
  const double half = 0.5 * std::sqrt(t_squared);
  const double c = t_squared < 1e-2 ? 1.0 / 12.0 + t_squared / 720.0 + t_squared * t_squared / 30240.0 +
                                          t_squared * t_squared * t_squared / 1209600.0
                                    : (1.0 - half / std::tan(half)) / t_squared;
  const Mat3 theta_skew = skew(theta);
  return Mat3::Identity() + 0.5 * theta_skew + c * theta_skew * theta_skew;
}

void exert(const Load& load, const ForceInstant& at, AppliedForce& applied) {  // (S32)
  const Mat3 axes = load.axes == LoadAxes::global ? Mat3(Mat3::Identity())
                    : load.axes == LoadAxes::body ? at.A_child
                                                  : applied.child().A_joint;
  const double size = evaluate(load.law, at.t).f;
  applied.on_child() = {size * (axes * load.force), size * (axes * load.torque)};
}

void exert(const Bushing& bushing, const ForceInstant& at, AppliedForce& applied) {  // (S35)
  // A bearing that turns freely has no angle to be limited.
  const bool turns_freely = bushing.stiffness.bottomRows<3>().isZero(0.0) && bushing.preload.tail<3>().isZero(0.0);
  const Vec3 theta = turns_freely ? Vec3(Vec3::Zero()) : rotation_vector(applied.motion.R, at.name, at.t);
  Vec6 displacement;
  displacement << applied.motion.d, theta;
  Vec6 speed;
  speed << applied.motion.ddot, applied.motion.omega;
  Vec6 elastic = bushing.stiffness * displacement - bushing.preload;
  elastic.tail<3>() = inverse_transposed_tangent(theta) * elastic.tail<3>();
  const Vec6 in_C = -elastic - bushing.damping * speed;
  const Mat3& axes = applied.parent().A_joint;
  applied.on_child() = {axes * in_C.head<3>(), axes * in_C.tail<3>()};
  applied.on_parent() = opposite(applied.on_child(), applied.child().point - applied.parent().point);
}

int n_event_functions(const Load& /*load*/) { return 0; }
int n_event_functions(const Bushing& /*bushing*/) { return 0; }

double* write_event_functions(const Load& /*load*/, const ForceInstant& /*at*/, const AppliedForce& /*applied*/,
                              double* next) {
  return next;
}
double* write_event_functions(const Bushing& /*bushing*/, const ForceInstant& /*at*/, const AppliedForce& /*applied*/,
                              double* next) {
  return next;
}

double departure_of(const Load& /*load*/, const ForceInstant& /*at*/, const AppliedForce& /*applied*/) { return 0.0; }
double departure_of(const Bushing& /*bushing*/, const ForceInstant& /*at*/, const AppliedForce& /*applied*/) {
  return 0.0;
}

}  // namespace

void exert(const ForceElement& element, const ForceInstant& at, AppliedForce& applied) {
  std::visit([&](const auto& what) { exert(what, at, applied); }, element.what);
}

int n_event_functions(const ForceElement& element) {
  return std::visit([](const auto& what) { return n_event_functions(what); }, element.what);
}

double* write_event_functions(const ForceElement& element, const ForceInstant& at, const AppliedForce& applied,
                              double* next) {
  return std::visit([&](const auto& what) { return write_event_functions(what, at, applied, next); }, element.what);
}

double departure_of(const ForceElement& element, const ForceInstant& at, const AppliedForce& applied) {
  return std::visit([&](const auto& what) { return departure_of(what, at, applied); }, element.what);
}

}  // namespace concord::cartesian
