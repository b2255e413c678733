#include "relative/bodies/body_inertia.h"

#include "common/rotation.h"

namespace concord::relative {

namespace {

/// sum of m x cross y for the matrix sum of m x y^T.
Vec3 cross_sum(const Eigen::Ref<const Mat3>& xy) {
  return {xy(1, 2) - xy(2, 1), xy(2, 0) - xy(0, 2), xy(0, 1) - xy(1, 0)};
}

Eigen::Map<const Mat3> block9(const VecX& stacked, Eigen::Index k) {
  return Eigen::Map<const Mat3>(stacked.data() + 9 * k);
}

}  // namespace

MassMoments rigid_moments(const Body& body, const Vec3& about_L) {
  const Vec3 c = body.center_of_mass_L - about_L;
  return {body.mass, body.mass * c,
          body.inertia_L + body.mass * (c.squaredNorm() * Mat3::Identity() - c * c.transpose())};
}

FlexibleInertia::FlexibleInertia(const ModalData& modal)
    : mass_(modal.G(0, 0)),
      h0_(modal.G.block<3, 1>(1, 0)),
      P0_(modal.G.block<3, 3>(1, 1)),
      K_(modal.stiffness),
      D_(modal.damping),
      Q_L_(Mat3::Zero()) {
  const Eigen::Index m = modal.n_modes();
  h_modes_.resize(3, m);
  B0_.resize(9, m);
  B_modes_.resize(9 * m, m);
  M_aa_.resize(m, m);
  for (Eigen::Index k = 0; k < m; ++k) {
    const Eigen::Index psi_k = 4 + 3 * k;
    h_modes_.col(k) = modal.G.block<3, 1>(psi_k, 0);
    Eigen::Map<Mat3>(B0_.col(k).data()) = modal.G.block<3, 3>(1, psi_k);
    for (Eigen::Index l = 0; l < m; ++l) {
      const Mat3 psi_l_psi_k = modal.G.block<3, 3>(4 + 3 * l, psi_k);
      Eigen::Map<Mat3>(B_modes_.col(l).data() + 9 * k) = psi_l_psi_k;
      M_aa_(k, l) = psi_l_psi_k.trace();
    }
  }
  B_.setZero(9 * m);
  Bdot_.setZero(9 * m);
  s_cross_psi_L_.setZero(3, m);
  U_.setZero(m);
  M_ra_.setZero(6, m);
  p_a_.setZero(m);
}

void FlexibleInertia::deform(const Eigen::Ref<const VecX>& a, const Eigen::Ref<const VecX>& adot) {
  const Eigen::Index m = n_modes();
  B_ = B0_.reshaped();
  B_.noalias() += B_modes_ * a;
  Bdot_.noalias() = B_modes_ * adot;
  // P = sum m s s^T with s = s0 + sum a_k psi_k: s0 s0^T + sum a_k (s psi_k^T) + (sum a_k s0 psi_k^T)^T.
  Mat3 P = P0_;
  Q_L_.setZero();
  for (Eigen::Index k = 0; k < m; ++k) {
    P += a(k) * (block9(B_, k) + Eigen::Map<const Mat3>(B0_.col(k).data()).transpose());
    Q_L_ += adot(k) * block9(B_, k);
    s_cross_psi_L_.col(k) = cross_sum(block9(B_, k));
  }
  moments_L_.mass = mass_;
  moments_L_.h = h0_;
  moments_L_.h.noalias() += h_modes_.lazyProduct(a);
  moments_L_.I = P.trace() * Mat3::Identity() - 0.5 * (P + P.transpose());
  hdot_L_ = h_modes_.lazyProduct(adot);
  U_.noalias() = D_ * adot;
  dissipation_ = adot.dot(U_);
  U_.noalias() += K_ * a;
}

void FlexibleInertia::move(const Mat3& A, const Vec3& omega, const Vec3& gravity) {
  moments_.take_rotated(moments_L_, A);
  M_ra_.topRows<3>().noalias() = A.lazyProduct(h_modes_);
  M_ra_.bottomRows<3>().noalias() = A.lazyProduct(s_cross_psi_L_);
  const Vec3 w = A.transpose() * omega;
  // Coriolis part of S: sum m 2 omega x sdot, and its moment 2 sum m s x (omega x sdot) = 2 (tr Q 1 - Q^T) omega.
  p_r_ = moments_.bias(omega, gravity);
  p_r_.head<3>() += 2.0 * omega.cross(A * hdot_L_);
  p_r_.tail<3>() += 2.0 * (A * (Q_L_.trace() * w - Q_L_.transpose() * w));
  // Modal rows: sum m psi_k . (omega x (omega x s) + 2 omega x sdot - g).
  const Vec3 g_L = A.transpose() * gravity;
  for (Eigen::Index k = 0; k < n_modes(); ++k) {
    const auto s_psi = block9(B_, k);
    p_a_(k) = U_(k) + w.dot(s_psi * w) - w.squaredNorm() * s_psi.trace() + 2.0 * w.dot(cross_sum(block9(Bdot_, k))) -
              h_modes_.col(k).dot(g_L);
  }
}

BodyInertia::BodyInertia(const Body& body, const Vec3& reference_point_L) {
  if (body.modal) {
    flexible_.emplace(*body.modal);
  } else {
    moments_L_ = rigid_moments(body, reference_point_L);
  }
}

void BodyInertia::update_flexible(const double* a, const double* adot, const Mat3& A, const Vec3& omega,
                                  const Vec3& gravity) {
  const int m = flexible_->n_modes();
  flexible_->deform(Eigen::Map<const VecX>(a, m), Eigen::Map<const VecX>(adot, m));
  flexible_->move(A, omega, gravity);
  moments_ = flexible_->moments();
  p_ = flexible_->p_r();
}

}  // namespace concord::relative
