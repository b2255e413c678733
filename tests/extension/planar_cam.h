#pragma once

#include "common/joints/by_function.h"
#include "common/joints/joint_type.h"

/// A joint page outside the catalogue: nothing of the project knows it but the CMake option that names it.
namespace concord::joints {

namespace planar_cam_shape {

/// Radius of the cam over the angle about the parent's z [m]: neither round nor symmetric, and nowhere hollow enough to
/// be touched twice.
template <class T>
T radius(const T& angle) {
  return 0.21 + 0.05 * cos(angle) + 0.02 * sin(2.0 * angle);
}

/// Point of the cam's curve at an angle, in the parent's joint frame.
template <class T>
Vec3Of<T> point(const T& angle) {
  return {radius(angle) * cos(angle), radius(angle) * sin(angle), T(0.0)};
}

/// The follower is on the curve, in its plane, and upright.
struct Gap {
  template <class T>
  VectorOf<T, 4> operator()(const Vec3Of<T>& d, const Mat3Of<T>& R) const {
    const T off_the_curve = hypot(d.x(), d.y()) - radius(atan2(d.y(), d.x()));
    return {off_the_curve, d.z(), R(0, 2), R(1, 2)};
  }
};

struct Motion {
  template <class T>
  PlacementOf<T> operator()(const VectorOf<T, 2>& q) const {
    return {point(q(0)), rotation_by(Axis::z, q(1))};
  }
};

struct Reading {
  template <class T>
  VectorOf<T, 2> operator()(const Vec3Of<T>& d, const Mat3Of<T>& R) const {
    return {atan2(d.y(), d.x()), atan2(R(1, 0), R(0, 0))};
  }
};

/// Of the two branches R e_z = +-e_z the upright one; the follower does not sit in the cam's centre.
inline bool upright(const Placement& at) { return at.R(2, 2) > 0.0 && at.d.head<2>().norm() > 0.05; }

/// A motor on the first coordinate pushes the follower along the curve, one on the second twists it.
inline Wrenches push_and_twist(const Placement& at) {
  const double angle = std::atan2(at.d.y(), at.d.x());
  const Jet turning(angle, Vec6::Zero(), 1.0, 0.0);
  const Vec3Of<Jet> moving = point(turning);
  Wrenches wrenches = Wrenches::Zero(6, 2);
  wrenches.col(0).head<3>() << moving(0).rate, moving(1).rate, moving(2).rate;
  wrenches(5, 1) = 1.0;
  return wrenches;
}

}  // namespace planar_cam_shape

/// A pin in the curved slot of a cam: the child's point stays on the curve, its z axis parallel to the parent's, and it
/// turns about the pin as it likes. q = (angle about the parent's z from x to the pin, angle about z from the parent's
/// x to the child's x) [rad]. Never singular. The slot holds the pin on both sides, so the reaction has either sign.
inline const JointType planar_cam{
    .name = "planar_cam",
    .forbids = {ByResidual{function_of_placement(planar_cam_shape::Gap{}), planar_cam_shape::upright}},
    .permits = {ByMotion{function_of_coordinates<2>(planar_cam_shape::Motion{}), {true, true}, {"cam", "pin"}}},
    .reads = {ByReading{
        function_of_placement(planar_cam_shape::Reading{}), {true, true}, planar_cam_shape::push_and_twist}},
};

}  // namespace concord::joints
