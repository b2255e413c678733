#pragma once

#include "cartesian/bodies/marker_kinematics.h"
#include "cartesian/bodies/small_products.h"

namespace concord::cartesian {

[[noreturn]] void refuse_large_rotation(double angle);

template <class Modal>
void place(const Attachment& attachment, const Vec3& r, const Mat3& A, const Modal& a, Marker& marker) {
  if (a.size() == 0) {
    marker.lever = times(A, attachment.point_L);
    multiply(A, attachment.C, marker.A_joint);
  } else {
    const Vec3 s_P_L = attachment.point_L + attachment.Psi_t_L * a;
    marker.lever.noalias() = A * s_P_L;
    marker.theta.noalias() = attachment.Psi_r_L * a;
    const double t_squared = marker.theta.squaredNorm();
    if (!(t_squared < EIGEN_PI * EIGEN_PI)) refuse_large_rotation(marker.theta.norm());
    const Mat3 A_R = A * exponential_rotation(marker.theta);
    marker.A_joint.noalias() = A_R * attachment.C;
    const Mat3 A_J = A * tangent(marker.theta);
    marker.A_Psi_t = A.lazyProduct(attachment.Psi_t_L);
    marker.A_J_Psi_r = A_J.lazyProduct(attachment.Psi_r_L);
  }
  marker.point = r + marker.lever;
}

template <class Modal>
void move(const Attachment& attachment, const Mat3& A, const Vec3& v, const Vec3& omega, const Modal& adot,
          Marker& marker) {
  const Vec3 swing = cross(omega, marker.lever);
  marker.velocity = v + swing;
  marker.angular_velocity = omega;
  marker.velocity_bias = cross(omega, swing);
  marker.angular_velocity_bias.setZero();
  if (adot.size() == 0) return;
  const Vec3 deforming = marker.A_Psi_t * adot;
  const Vec3 bending = marker.A_J_Psi_r * adot;
  marker.velocity += deforming;
  marker.angular_velocity += bending;
  marker.velocity_bias += 2.0 * omega.cross(deforming);
  const Vec3 thetadot = attachment.Psi_r_L * adot;
  marker.angular_velocity_bias = omega.cross(bending) + A * tangent_rate_times_thetadot(marker.theta, thetadot);
}

template <class Column>
void write_generalized_force(const Marker& marker, const Vec3& force, const Vec3& torque, Column&& column) {
  column.template segment<3>(0) = force;
  column.template segment<3>(3) = cross(marker.lever, force) + torque;
  const Eigen::Index m = marker.A_Psi_t.cols();
  if (m > 0) {
    column.segment(6, m) =
        marker.A_Psi_t.transpose().lazyProduct(force) + marker.A_J_Psi_r.transpose().lazyProduct(torque);
  }
}

}  // namespace concord::cartesian
