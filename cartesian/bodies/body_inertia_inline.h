#pragma once

#include "cartesian/bodies/body_inertia.h"
#include "cartesian/bodies/small_products.h"

namespace concord::cartesian {

/// Sum of s x psi from the sum of s psi^T.
template <class Dyad>
Vec3 cross_sum(const Dyad& dyad) {
  return {dyad(1, 2) - dyad(2, 1), dyad(2, 0) - dyad(0, 2), dyad(0, 1) - dyad(1, 0)};
}

template <class Modal>
void DeformedInertia::update(const Modal& a, const Modal& adot) {
  if (body_.n_modes_ == 0) return;
  const int m = body_.n_modes_;
  sum_s_ = body_.sum_s0_;
  sum_sdot_.setZero();
  sum_s_psi_ = body_.sum_s0_psi_;
  sum_sdot_psi_.setZero();
  for (int l = 0; l < m; ++l) {
    sum_s_ += a(l) * body_.sum_psi_.col(l);
    sum_sdot_ += adot(l) * body_.sum_psi_.col(l);
    const auto psi_l_psi = body_.sum_psi_psi_.middleCols(3 * l * m, 3 * m);
    sum_s_psi_ += a(l) * psi_l_psi;
    sum_sdot_psi_ += adot(l) * psi_l_psi;
  }
  // s s^T = s_0 s_0^T + (sum a_k s_0 psi_k^T)^T + sum a_k s psi_k^T
  sum_s_s_ = body_.sum_s0_s0_;
  sum_s_sdot_.setZero();
  for (int k = 0; k < m; ++k) {
    sum_s_s_ += a(k) * (body_.sum_s0_psi_.middleCols<3>(3 * k).transpose() + sum_s_psi_.middleCols<3>(3 * k));
    sum_s_sdot_ += adot(k) * sum_s_psi_.middleCols<3>(3 * k);
  }
}

template <class Block>
void DeformedInertia::write_rigid_rows(const Mat3& A, Block&& M) const {
  const Vec3 lever = times(A, sum_s_);
  M.template block<3, 3>(0, 0) = body_.mass_ * Mat3::Identity();
  for (int c = 0; c < 3; ++c) {
    const Vec3 moment = cross(lever, Vec3::Unit(c));
    M.template block<3, 1>(0, 3 + c) = -moment;
    M.template block<3, 1>(3, c) = moment;
  }
  Mat3 A_inertia_L;
  multiply(A, sum_s_s_.trace() * Mat3::Identity() - sum_s_s_, A_inertia_L);
  for (int c = 0; c < 3; ++c) M.template block<3, 1>(3, 3 + c) = times(A_inertia_L, A.row(c));
  for (int k = 0; k < body_.n_modes_; ++k) {
    M.template block<3, 1>(0, 6 + k) = A * body_.sum_psi_.col(k);
    M.template block<3, 1>(3, 6 + k) = A * cross_sum(sum_s_psi_.middleCols<3>(3 * k));
  }
}

template <class Block>
void DeformedInertia::write_mass_matrix(const Mat3& A, Block&& M) const {
  write_rigid_rows(A, M);
  const int m = body_.n_modes_;
  for (int k = 0; k < m; ++k) {
    for (int row = 0; row < 6; ++row) M(6 + k, row) = M(row, 6 + k);
    for (int l = 0; l < m; ++l) M(6 + k, 6 + l) = body_.modal_mass_(k, l);
  }
}

template <class Modal, class Rows>
void DeformedInertia::write_forces(const Mat3& A, const Vec3& omega, const Vec3& gravity, const Modal& a,
                                   const Modal& adot, Rows&& force) const {
  const Vec3 omega_L = transpose_times(A, omega);
  const Vec3 gravity_L = transpose_times(A, gravity);
  // Of m (omega x (omega x s) + 2 omega x sdot), and its moment about the origin:
  // s x (omega x (omega x s)) = omega x (tr(s s^T) 1 - s s^T) omega;  s x (omega x sdot) = omega (s . sdot) - sdot (s .
  // omega)
  const Vec3 S_v_L = cross(omega_L, Vec3(cross(omega_L, sum_s_) + 2.0 * sum_sdot_));
  // and tr(s s^T) omega is parallel to omega.
  const Vec3 S_omega_L = 2.0 * (sum_s_sdot_.trace() * omega_L - transpose_times(sum_s_sdot_, omega_L)) -
                         cross(omega_L, times(sum_s_s_, omega_L));
  force.template segment<3>(0) = times(A, Vec3(body_.mass_ * gravity_L - S_v_L));
  force.template segment<3>(3) = times(A, Vec3(cross(sum_s_, gravity_L) - S_omega_L));
  const double omega_squared = omega_L.squaredNorm();
  for (int k = 0; k < body_.n_modes_; ++k) {
    const auto s_psi = sum_s_psi_.middleCols<3>(3 * k);
    const double centrifugal = omega_L.dot(s_psi * omega_L) - omega_squared * s_psi.trace();
    const double coriolis = 2.0 * omega_L.dot(cross_sum(sum_sdot_psi_.middleCols<3>(3 * k)));
    force(6 + k) = body_.sum_psi_.col(k).dot(gravity_L) - centrifugal - coriolis - body_.stiffness_.row(k).dot(a) -
                   body_.damping_.row(k).dot(adot);
  }
}

}  // namespace concord::cartesian
