#pragma once

#include "common/types.h"

/// Finite rotations from rotation vectors and back, (R1) to (R4).
namespace concord::relative {

/// R(theta), the exact exponential map, and its left tangent J(theta), for which Rdot R^T = (J thetadot)~.
struct ExponentialMap {
  Mat3 R;
  Mat3 J;
};

/// Rotation and tangent for the rotation vector theta [rad]. Accurate at any length, zero included (R1).
ExponentialMap exponential_map(const Vec3& theta);

/// Jdot(theta, thetadot), the rate of the left tangent [1/s] (R3).
Mat3 tangent_rate(const Vec3& theta, const Vec3& thetadot);

/// The rotation vector of R, of length at most pi [rad] (R4).
Vec3 rotation_vector(const Mat3& R);

/// Rotation matrix of Euler parameters (scalar first) of any length but zero; they are normalized first.
Mat3 rotation_from_euler_parameters(const Vec4& p);

/// Euler parameters of R, scalar first, unit length, of the sign nearest to `near`.
Vec4 euler_parameters(const Mat3& R, const Vec4& near);

}  // namespace concord::relative
