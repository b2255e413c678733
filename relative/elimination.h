#pragma once

#include <array>
#include <optional>
#include <vector>

#include "relative/applied_forces.h"
#include "relative/body_inertia.h"
#include "relative/closure.h"
#include "relative/velocity_transformation.h"

/// Mbar udot = gbar (R32) of the opened tree, solved link by link without forming B or Mbar.
namespace concord::relative {

/// Factors of one link. With H = [H_free, -Ha] (6 rows, n columns) and I, p the inertia and bias force of the body and
/// of all that it carries, udot_free = L^-T (uhat - K^T A0), where A0 is what the reference body alone would give.
struct LinkFactors {
  int n_free = 0;             // free joint speeds
  std::array<int, 6> free{};  // their places in u
  int n_driven = 0;
  std::array<int, 6> driven{};  // places of the driven ones in u
  std::array<int, 6> free_column{};
  std::array<int, 6> driven_column{};
  Mat6 H_free = Mat6::Zero();  // used only where some speeds are driven
  Mat6 I = Mat6::Zero();
  Vec6 p = Vec6::Zero();
  Vec6 c = Vec6::Zero();    // D and what the driven speeds add
  Vec6 tau = Vec6::Zero();  // of joint springs on the free speeds
  Mat6 K = Mat6::Zero();    // 6 x n_free, contiguous
  Mat6 L = Mat6::Zero();    // n_free x n_free, contiguous
  Vec6 uhat = Vec6::Zero();
  Vec6 Vdot = Vec6::Zero();  // [vdot; omegadot] of the body
};

/// The same with the modal speeds among the unknowns: n = n_free + m of them.
struct FlexibleFactors {
  Mat6X I_ra;
  MatX I_aa;
  VecX p_a;
  Mat6X H;               // [H_free, -Ha]
  Mat6X U;               // top rows of I [H; 0 1]
  MatX U_a;              // modal rows, m x n
  MatX D;                // [H; 0 1]^T I [H; 0 1], n x n
  Eigen::LLT<MatX> llt;  // factored anew at every state
  MatX Kt;               // n x 6: K^T = L^-1 U^T
  VecX uhat;             // n
  VecX udot;             // n
  VecX addot;            // m
};

/// A motion of a link's joint: its speeds.
struct SlackMotion {
  int link;
  JointVector u;
};

/// Recursive elimination over the tree. All memory is laid out at construction.
class Elimination {
 public:
  /// The kinematics must outlive this object. `driven`: speeds whose accelerations are prescribed.
  Elimination(const Kinematics& kinematics, const Held& driven);

  /// Eliminates inward: inertias of all bodies (by link), applied forces, prescribed accelerations in udot. Throws
  /// SolverError if the inertia of a link is not positive definite.
  void inward(const std::vector<BodyInertia>& inertias, const AppliedForces& applied, const VecX& udot);

  /// Solves outward: writes the free entries of udot (tree part) and the accelerations of all bodies.
  void outward(VecX& udot);

  [[nodiscard]] const Vec6& acceleration(int body) const;
  /// addot of a body; nullptr if it is rigid.
  [[nodiscard]] const VecX* modal_acceleration(int body) const;
  /// Vdot_P of a joint's point, [linear; angular], global axes (R38).
  [[nodiscard]] Vec6 acceleration_of_point(int joint, Side side) const;

  /// Number of unknowns of a link: free joint speeds and modal speeds.
  [[nodiscard]] int n_unknowns(int link) const;

  /// Adds coordinate forces (n_u x c) on the speeds of a link's joint to forces on its unknowns (n x c); what pushes a
  /// driven speed has no effect.
  void add_coordinate_forces(int link, const Eigen::Ref<const MatX>& forces, Eigen::Ref<MatX> on_unknowns) const;

  /// Takes a generalized force (z_r: 6 x c on the rigid rows, z_a: m x c on the modal ones) on the body of a link, and
  /// in eps forces on its unknowns (n x c): makes of eps their part along the unknowns, L^-1 (eps + H^T z), and leaves
  /// in z_r what the reference body feels.
  void project(int link, Mat6X& z_r, const MatX& z_a, MatX& eps) const;

  /// Adds to a link's right side what a generalized force of projection `eps` (n numbers) adds.
  void add_force(int link, const Eigen::Ref<const VecX>& eps);

  /// The outermost link of the opened tree whose joint can move without inertia, and the joint's speeds u (n_u) in that
  /// motion, driven ones at rest; after inward(), also one that threw. "Without" means below round-off of the terms
  /// that the inertia is made of.
  [[nodiscard]] std::optional<SlackMotion> motion_without_inertia() const;

 private:
  void load_bodies(const std::vector<BodyInertia>& inertias);
  void subtract_applied(const AppliedForces& applied);
  void load_flexible(int l, const BodyInertia& inertia);
  void gather_columns(int l, const VecX& udot);
  template <int N>
  void eliminate_rigid(int l);
  void dispatch_rigid(int l);
  void eliminate_flexible(int l);
  void transmit(int l, const Mat6& I, const Vec6& p);
  [[nodiscard]] Vec6 from_reference(int l) const;
  template <int N>
  void project_rigid(int l, Mat6X& z_r, MatX& eps) const;
  template <int N>
  void solve_rigid(int l, const Vec6& A0, VecX& udot);
  void solve_flexible(int l, const Vec6& A0, VecX& udot);
  [[nodiscard]] const double* free_columns(int l) const;
  [[noreturn]] void throw_indefinite(int l) const;

  const Kinematics* kinematics_;
  std::vector<LinkFactors> links_;
  std::vector<int> flexible_of_link_;  // -1: rigid
  std::vector<FlexibleFactors> flexible_;
  Vec6 ground_ = Vec6::Zero();
};

}  // namespace concord::relative
