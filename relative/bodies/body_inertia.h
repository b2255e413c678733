#pragma once

#include <optional>

#include "common/model.h"
#include "relative/bodies/small_products.h"

/// Inertia of one body: M(a) Ydot + S(omega, a, adot) + U - Q_gravity, (R24) to (R28).
namespace concord::relative {

/// Zeroth, first and second moment of a body's mass about its reference point: mass [kg], h = sum of m s [kg m],
/// I = sum of m (s.s 1 - s s^T) [kg m2]. In body axes (as a statement) or in global ones (in a pose).
struct MassMoments {
  double mass = 0.0;
  Vec3 h = Vec3::Zero();
  Mat3 I = Mat3::Zero();

  /// Takes the moments of the body before it was rotated by A.
  void take_rotated(const MassMoments& before, const Mat3& A) {
    mass = before.mass;
    multiply(A, before.h.data(), h.data());
    Mat3 AI;
    multiply(A, before.I, AI);
    multiply_transpose(AI, A, I);
  }

  /// The block [m 1, -h~; h~, I] of M that belongs to [vdot; omegadot] (R26).
  [[gnu::always_inline]] void fill(Mat6& M) const {
    const auto write = [&M](int column, const Pair& first, const Pair& second, const Pair& third) {
      double* to = M.col(column).data();
      store_pair(first, to);
      store_pair(second, to + 2);
      store_pair(third, to + 4);
    };
    write(0, Pair{mass, 0.0}, Pair{0.0, 0.0}, Pair{h.z(), -h.y()});
    write(1, Pair{0.0, mass}, Pair{0.0, -h.z()}, Pair{0.0, h.x()});
    write(2, Pair{0.0, 0.0}, Pair{mass, h.y()}, Pair{-h.x(), 0.0});
    write(3, Pair{0.0, -h.z()}, Pair{h.y(), I(0, 0)}, Pair{I(1, 0), I(2, 0)});
    write(4, Pair{h.z(), 0.0}, Pair{-h.x(), I(0, 1)}, Pair{I(1, 1), I(2, 1)});
    write(5, Pair{-h.y(), h.x()}, Pair{0.0, I(0, 2)}, Pair{I(1, 2), I(2, 2)});
  }

  /// S - Q of the six rigid rows, of Q gravity alone, without deformation rates: centrifugal, gyroscopic and gravity
  /// terms (R27).
  [[gnu::always_inline]] [[nodiscard]] Vec6 bias(const Vec3& omega, const Vec3& gravity) const {
    return stack(cross(omega, cross(omega, h)) - mass * gravity,
                 cross(omega, relative::times(I, omega)) - cross(h, gravity));
  }

  /// The six rigid rows of M [vdot; omegadot].
  [[gnu::always_inline]] [[nodiscard]] Vec6 times(const Vec6& Vdot) const {
    return stack(mass * Vdot.head<3>() - cross(h, Vdot.tail<3>()),
                 cross(h, Vdot.head<3>()) + relative::times(I, Vdot.tail<3>()));
  }
};

/// Moments of a rigid body about a point of it, body axes (R24).
MassMoments rigid_moments(const Body& body, const Vec3& about_L);

/// Inertia of a flexible body as exact functions of G = sum of m w w^T, w = [1; s_0; psi_1; ...; psi_m], and of the
/// state. The cost does not depend on the number of mass points.
class FlexibleInertia {
 public:
  explicit FlexibleInertia(const ModalData& modal);

  [[nodiscard]] int n_modes() const { return static_cast<int>(M_aa_.rows()); }

  /// Takes the deformation: all sums in body axes (R25).
  void deform(const Eigen::Ref<const VecX>& a, const Eigen::Ref<const VecX>& adot);

  /// Takes pose and angular velocity: everything below, global axes (R28).
  void move(const Mat3& A, const Vec3& omega, const Vec3& gravity);

  /// Moments of the deformed body, global axes.
  [[nodiscard]] const MassMoments& moments() const { return moments_; }
  /// Coupling of [v; omega] with the modes, 6 x m.
  [[nodiscard]] const Mat6X& M_ra() const { return M_ra_; }
  /// Modal mass matrix, m x m, constant.
  [[nodiscard]] const MatX& M_aa() const { return M_aa_; }
  /// S + U - Q_gravity: six rigid rows and m modal ones.
  [[nodiscard]] const Vec6& p_r() const { return p_r_; }
  [[nodiscard]] const VecX& p_a() const { return p_a_; }
  /// K a + D adot, m rows; part of p_a.
  [[nodiscard]] const VecX& U() const { return U_; }
  /// adot^T D adot [W], nonnegative.
  [[nodiscard]] double dissipation() const { return dissipation_; }

 private:
  // Constants: sums over the mass points, matrices of 9 numbers stored as columns (column-major 3 x 3).
  double mass_;
  Vec3 h0_;                                      // sum m s0
  Mat3 P0_;                                      // sum m s0 s0^T
  Mat3X h_modes_;                                // column k: sum m psi_k
  Eigen::Matrix<double, 9, Eigen::Dynamic> B0_;  // column k: sum m s0 psi_k^T
  MatX B_modes_;                                 // 9 m x m; rows of k, column l: sum m psi_l psi_k^T
  MatX M_aa_;
  MatX K_, D_;

  // In body axes, of the deformation.
  MassMoments moments_L_;
  Vec3 hdot_L_;
  Mat3 Q_L_;             // sum m s sdot^T
  VecX B_;               // 9 numbers per mode: sum m s psi_k^T
  VecX Bdot_;            // 9 numbers per mode: sum m sdot psi_k^T
  Mat3X s_cross_psi_L_;  // column k: sum m s x psi_k
  VecX U_;
  double dissipation_ = 0.0;

  // In global axes.
  MassMoments moments_;
  Mat6X M_ra_;
  Vec6 p_r_ = Vec6::Zero();
  VecX p_a_;
};

/// Inertia of one body, rigid or flexible, in its present pose.
class BodyInertia {
 public:
  /// About its reference point, the origin if the body is flexible.
  explicit BodyInertia(const Body& body, const Vec3& reference_point_L = Vec3::Zero());

  /// Takes the deformation (n_modes numbers each) and the motion of the body; gravity [m/s2].
  void update(const double* a, const double* adot, const Mat3& A, const Vec3& omega, const Vec3& gravity) {
    if (flexible_) {
      update_flexible(a, adot, A, omega, gravity);
    } else {
      moments_.take_rotated(moments_L_, A);
      p_ = moments_.bias(omega, gravity);
    }
  }

  [[nodiscard]] const MassMoments& moments() const { return moments_; }
  /// S - Q_gravity of the six rigid rows.
  [[nodiscard]] const Vec6& p() const { return p_; }
  /// The modal terms; nullptr if the body is rigid.
  [[nodiscard]] const FlexibleInertia* flexible() const { return flexible_ ? &*flexible_ : nullptr; }

 private:
  void update_flexible(const double* a, const double* adot, const Mat3& A, const Vec3& omega, const Vec3& gravity);

  MassMoments moments_L_;
  MassMoments moments_;
  Vec6 p_ = Vec6::Zero();
  std::optional<FlexibleInertia> flexible_;
};

}  // namespace concord::relative
