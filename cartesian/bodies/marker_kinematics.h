#pragma once

#include <string>
#include <string_view>

#include "common/error.h"
#include "common/model.h"
#include "common/types.h"

/// Where a joint sits on a body, and how that place moves with the body's coordinates: a point and a joint frame on a
/// flexible body, (C5) to (C12).
namespace concord::cartesian {

/// Coefficients of the tangent J(theta) = 1 + c1 theta~ + c2 theta~^2 of the exponential map and of their rates: with
/// t = |theta|, dc1/dtime = b1 (theta . thetadot), dc2/dtime = b2 (theta . thetadot) (C7).
struct TangentCoefficients {
  double c1;  // (1 - cos t) / t^2
  double c2;  // (t - sin t) / t^3
  double b1;  // (dc1/dt) / t
  double b2;  // (dc2/dt) / t
};

/// By series for t < 1, so that nothing cancels at small deformation. `t_squared` = |theta|^2 (C7).
TangentCoefficients tangent_coefficients(double t_squared);

/// R(theta) = exp(theta~), exact (C6).
Mat3 exponential_rotation(const Vec3& theta);

/// J(theta), with Rdot R^T = (J thetadot)~ (C6).
Mat3 tangent(const Vec3& theta);

/// Jdot thetadot for the motion theta, thetadot (C8).
Vec3 tangent_rate_times_thetadot(const Vec3& theta, const Vec3& thetadot);

/// Position and motion of one attachment. Global axes unless the suffix says otherwise.
struct Marker {
  // From positions.
  Vec3 lever = Vec3::Zero();        // A s_P, deformed: from the body origin to P
  Vec3 point = Vec3::Zero();        // r_P
  Mat3 A_joint = Mat3::Identity();  // A R(theta) C: joint frame to global
  Vec3 theta = Vec3::Zero();        // Psi_r a, body axes
  Mat3X A_Psi_t = Mat3X(3, 0);      // A Psi_t
  Mat3X A_J_Psi_r = Mat3X(3, 0);    // A J Psi_r
  // From velocities.
  Vec3 velocity = Vec3::Zero();               // of P
  Vec3 angular_velocity = Vec3::Zero();       // of the joint frame
  Vec3 velocity_bias = Vec3::Zero();          // acceleration of P at Ydot = 0
  Vec3 angular_velocity_bias = Vec3::Zero();  // angular acceleration of the joint frame at Ydot = 0
};

/// Deformation has turned a frame too far: whose it is and when, as far as those know who place it.
struct LargeRotation : SolverError {
  LargeRotation(std::string_view owner, double turned, const std::string& when = "");
  double angle;
  std::string of;
};

/// A Marker with room for the modes of its body.
Marker make_marker(const Attachment& attachment);

/// Positions of `marker` for a body at r with rotation A and modal coordinates a. Throws LargeRotation if |theta| >=
/// pi.
template <class Modal>
void place(const Attachment& attachment, const Vec3& r, const Mat3& A, const Modal& a, Marker& marker);  // (C5)

/// Velocities and accelerations at Ydot = 0, after place() (C9), (C10).
template <class Modal>
void move(const Attachment& attachment, const Mat3& A, const Vec3& v, const Vec3& omega, const Modal& adot,
          Marker& marker);

/// The generalized force (C12) of a force and a torque at the marker on its body, [Q_r; Q_pi; Q_a] (6 + m numbers),
/// global axes; all rows by virtual work (C11).
template <class Column>
void write_generalized_force(const Marker& marker, const Vec3& force, const Vec3& torque, Column&& column);

}  // namespace concord::cartesian

#include "cartesian/bodies/marker_kinematics_inline.h"
