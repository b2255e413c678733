#pragma once

#include "common/types.h"

/// Orientation of a body by Euler parameters p = [e0; e], scalar first, unit.
namespace concord::cartesian {

using Mat34 = Eigen::Matrix<double, 3, 4>;

/// A = (e0^2 - e.e) 1 + 2 e e^T + 2 e0 e~: body axes to global axes (C1).
Mat3 rotation_of(const Vec4& p);

/// E = [-e, e0 1 + e~], with omega = 2 E pdot in global axes (C2).
Mat34 compute_E(const Vec4& p);

/// pdot = E^T omega / 2 for an angular velocity in global axes (C2).
Vec4 compute_pdot(const Vec4& p, const Vec3& omega);

/// Unit p of a rotation matrix, of the sign that has e0 >= 0 (C3).
Vec4 euler_parameters_of(const Mat3& A);

}  // namespace concord::cartesian
