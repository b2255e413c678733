#pragma once

#include "common/model.h"
#include "common/types.h"

/// Mass matrix and quadratic velocity terms of one body about its origin, from the inertia integrals G.
///
/// A mass point stands at s = s_0 + sum a_k psi_k in body axes and moves with v + omega x s + sdot. Everything follows
/// from three sums over the points: of m s, of m s s^T and of m s psi_k^T, which are linear or quadratic in a.
namespace concord::cartesian {

/// What of them is the same in every state.
class BodyInertia {
 public:
  explicit BodyInertia(const Body& body);  // (C32)

  [[nodiscard]] int n_modes() const { return n_modes_; }
  [[nodiscard]] double mass() const { return mass_; }

  /// adot^T D adot [W].
  template <class Modal>
  [[nodiscard]] double damping_power(const Modal& adot) const {
    return n_modes_ == 0 ? 0.0 : adot.dot(damping_.lazyProduct(adot));
  }

  /// Of m psi_k . psi_l.
  [[nodiscard]] const MatX& modal_mass() const { return modal_mass_; }
  [[nodiscard]] const MatX& stiffness() const { return stiffness_; }
  [[nodiscard]] const MatX& damping() const { return damping_; }

 private:
  friend class DeformedInertia;

  int n_modes_ = 0;
  double mass_ = 0.0;
  // Body axes.
  Vec3 sum_s0_ = Vec3::Zero();       // of m s_0
  Mat3 sum_s0_s0_ = Mat3::Zero();    // of m s_0 s_0^T
  Mat3X sum_psi_ = Mat3X(3, 0);      // column k: of m psi_k
  Mat3X sum_s0_psi_ = Mat3X(3, 0);   // block k: of m s_0 psi_k^T
  Mat3X sum_psi_psi_ = Mat3X(3, 0);  // block k m + l: of m psi_k psi_l^T
  MatX modal_mass_;                  // of m psi_k . psi_l
  MatX stiffness_;
  MatX damping_;
};

/// What follows from the deformation of a body. It always has one: none, and at rest, until update() gives another.
class DeformedInertia {
 public:
  /// The body must outlive this object.
  explicit DeformedInertia(const BodyInertia& body);

  /// Sums over the mass points for modal coordinates a and rates adot (C31).
  template <class Modal>
  void update(const Modal& a, const Modal& adot);

  /// M(a), (6 + m) square, for Y = [v; omega; adot] with v and omega in global axes; A: body to global (C33).
  template <class Block>
  void write_mass_matrix(const Mat3& A, Block&& M) const;
  /// Its first six rows, those of v and omega; the others are their transpose and BodyInertia::modal_mass().
  template <class Block>
  void write_rigid_rows(const Mat3& A, Block&& M) const;

  /// S, U = K a + D adot and gravity: writes Q_gravity - S - U, 6 + m rows, (C34), (C35); omega global.
  template <class Modal, class Rows>
  void write_forces(const Mat3& A, const Vec3& omega, const Vec3& gravity, const Modal& a, const Modal& adot,
                    Rows&& force) const;

 private:
  const BodyInertia& body_;
  // Body axes.
  Vec3 sum_s_;                      // of m s
  Vec3 sum_sdot_ = Vec3::Zero();    // of m sdot
  Mat3 sum_s_s_;                    // of m s s^T
  Mat3X sum_s_psi_;                 // block k: of m s psi_k^T
  Mat3X sum_sdot_psi_;              // block k: of m sdot psi_k^T
  Mat3 sum_s_sdot_ = Mat3::Zero();  // of m s sdot^T
};

}  // namespace concord::cartesian

#include "cartesian/bodies/body_inertia_inline.h"
