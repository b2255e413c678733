#pragma once

#include <numbers>

#include "common/joints/by_function.h"
#include "common/joints/joint_type.h"

namespace concord::joints {

namespace screw_thread {

/// The child's axis is the parent's, and the child stands on the thread: the angle between its orientation and the one
/// that its height asks for, in (-pi, pi], vanishes.
struct Misfit {
  double lead;

  template <class T>
  VectorOf<T, 5> operator()(const Vec3Of<T>& d, const Mat3Of<T>& R) const {
    const T s = sin(d.z() / lead);
    const T c = cos(d.z() / lead);
    return {d.x(), d.y(), R(0, 2), R(1, 2), atan2(R(1, 0) * c - R(0, 0) * s, R(0, 0) * c + R(1, 0) * s)};
  }
};

struct Motion {
  double lead;

  template <class T>
  PlacementOf<T> operator()(const VectorOf<T, 1>& q) const {
    return {Vec3Of<T>(T(0.0), T(0.0), lead * q(0)), rotation_by(Axis::z, q(0))};
  }
};

/// The turn, from the orientation; the height counts its whole turns. On a fine thread far from the origin round-off of
/// the height would be a large angle.
struct Reading {
  double lead;

  template <class T>
  VectorOf<T, 1> operator()(const Vec3Of<T>& d, const Mat3Of<T>& R) const {
    constexpr double kWholeTurn = 2.0 * std::numbers::pi;
    const T angle = atan2(R(1, 0), R(0, 0));
    return VectorOf<T, 1>(angle + kWholeTurn * nearest_whole((d.z() / lead - angle) / kWholeTurn));
  }
};

/// A motor turns the nut.
inline Wrenches torque(const Placement&) {
  Wrenches wrench = Wrenches::Zero(6, 1);
  wrench(5, 0) = 1.0;
  return wrench;
}

}  // namespace screw_thread

/// A nut on a right-handed thread along the parent's z: turning by q [rad] moves the child by lead q. q = the angle
/// about z from the parent's x to the child's; q = 0: the frames coincide. `lead` is in m for each radian. Never
/// singular. The reaction keeps T_z = -lead F_z.
inline JointType screw_of(const std::vector<double>& values) {
  const double lead = values.front();
  return {
      .name = "screw",
      .forbids = {ByResidual{function_of_placement(screw_thread::Misfit{lead}),
                             [](const Placement& at) { return at.R(2, 2) > 0.0; }}},
      .permits = {ByMotion{function_of_coordinates<1>(screw_thread::Motion{lead}), {true}, {"turn"}}},
      .reads = {ByReading{function_of_placement(screw_thread::Reading{lead}), {true}, screw_thread::torque}},
      .parameters = {{"lead", "m", 0.05}},
      .with_parameters = screw_of,
  };
}
inline const JointType screw = screw_of({0.05});

}  // namespace concord::joints
