#pragma once

#include "common/types.h"

namespace concord {

/// v~, with v~ w = v x w.
Mat3 skew(const Vec3& v);

/// Rotation by `angle` [rad] about the unit vector `axis`, right-handed.
Mat3 rotation_about(const Vec3& axis, double angle);

/// Rotation by `angle` [rad] about one of the coordinate axes, right-handed.
Mat3 rotation_about(Axis axis, double angle);

/// Rotation whose columns are x, z x x, z for perpendicular unit vectors x and z.
Mat3 rotation_from_x_and_z(const Vec3& x, const Vec3& z);

}  // namespace concord
