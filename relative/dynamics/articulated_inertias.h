#pragma once

#include <array>
#include <optional>
#include <vector>

#include "common/decompositions.h"
#include "relative/bodies/body_inertia.h"
#include "relative/bodies/velocity_transformation.h"
#include "relative/closure/closure.h"
#include "relative/forces/applied_forces.h"

/// The articulated-body pass from the outermost links to ground: Mbar udot = gbar (R32) of the opened tree, eliminated
/// link by link without forming B or Mbar.
namespace concord::relative {

/// One link with all links outboard of it as an articulated body: its articulated inertia I and bias force p, and the
/// factors of its joint. With H = [H_free, -Ha] (6 rows, n columns), udot_free = L^-T (uhat - K^T A0), where A0 is the
/// acceleration that the reference body alone would give. Of a rigid link the roots of the pivots stand apart from L
/// and K, so that a light body knows its own inertia though it carries a heavy one that turns about the same axis.
struct ArticulatedBody {
  bool only_turns = false;    // about the reference point of a rigid body: the upper half of H vanishes
  int n_free = 0;             // free joint speeds
  std::array<int, 6> free{};  // their indices in u
  int n_driven = 0;
  std::array<int, 6> driven{};  // indices of the driven ones in u
  std::array<int, 6> free_column{};
  std::array<int, 6> driven_column{};
  Mat6 H_free = Mat6::Zero();  // used only where some speeds are driven
  Mat6 articulated_inertia = Mat6::Zero();
  Vec6 bias_force = Vec6::Zero();
  Vec6 c = Vec6::Zero();    // D and what the driven speeds add; used only where some are
  Vec6 tau = Vec6::Zero();  // of joint springs on the free speeds
  Mat6 W = Mat6::Zero();    // first n_free columns: those of K over the roots
  Mat6 L = Mat6::Zero();    // n_free x n_free, lower triangle: the columns of L over the roots, pivots on the diagonal
  Vec6 root = Vec6::Zero();
  Vec6 uhat = Vec6::Zero();
};

/// The same of a flexible link, whose modal speeds are among the unknowns: n = n_free + m of them. The articulated
/// inertia has the modal blocks inertia_ra and inertia_aa besides, the bias force the modal rows bias_force_a.
struct FlexibleArticulatedBody {
  Mat6X inertia_ra;
  MatX inertia_aa;
  VecX bias_force_a;
  Mat6X H;               // [H_free, -Ha]
  Mat6X U;               // top rows of I [H; 0 1]
  MatX U_a;              // modal rows, m x n
  MatX D;                // [H; 0 1]^T I [H; 0 1], n x n
  Eigen::LLT<MatX> llt;  // factored anew at every state
  MatX Kt;               // n x 6: K^T = L^-1 U^T
  VecX uhat;             // n
};

/// Articulated inertias and bias forces of all links, and the factors of their joints. All memory is laid out at
/// construction.
class ArticulatedInertias {
 public:
  /// The kinematics must outlive this object. `driven`: speeds whose accelerations are prescribed.
  ArticulatedInertias(const Kinematics& kinematics, const PrescribedMask& driven);

  /// From the inertias of all bodies (by link) in the pose of the kinematics, the applied forces and the prescribed
  /// accelerations in udot. Throws SolverError if the inertia of a link is not positive definite.
  void compute(const std::vector<BodyInertia>& inertias, const AppliedForces& applied, const VecX& udot);

  /// The least pivot of the flexible links' factors, in parts of the terms that it is made of; 1 without such links. As
  /// many digits are lost in their factors.
  [[nodiscard]] double least_pivot() const { return least_pivot_; }

  [[nodiscard]] int n_links() const { return static_cast<int>(links_.size()); }
  [[nodiscard]] const ArticulatedBody& link(LinkIndex l) const { return links_[l]; }
  /// nullptr if the link's body is rigid.
  [[nodiscard]] const FlexibleArticulatedBody* flexible(LinkIndex l) const {
    return flexible_of_link_[l] ? &flexible_[*flexible_of_link_[l]] : nullptr;
  }
  /// The columns H of a link's free joint speeds, the first n_free of this matrix.
  [[nodiscard]] const Mat6& free_columns(LinkIndex l) const {
    return links_[l].n_driven == 0 ? kinematics_->blocks(l).H : links_[l].H_free;
  }

  /// What a link's acceleration has besides its reference body's and its free speeds': D, and what driven speeds add.
  [[nodiscard]] const Vec6& given_acceleration(LinkIndex l) const {
    return links_[l].n_driven == 0 ? kinematics_->blocks(l).D : links_[l].c;
  }

  /// Number of unknowns of a link: free joint speeds and modal speeds.
  [[nodiscard]] int n_unknowns(LinkIndex link) const;

  /// Adds coordinate forces (n_u x c) on the speeds of a link's joint to forces on its unknowns (n x c); what pushes a
  /// driven speed has no effect.
  void add_coordinate_forces(LinkIndex link, const Eigen::Ref<const MatX>& forces, Eigen::Ref<MatX> on_unknowns) const;

  /// Adds to generalized forces on a link's reference body (zj_r: 6 x c, zj_a: its modes x c) what the link passes on,
  /// z_r after propagate_force() (R36).
  void add_passed_force(LinkIndex link, const Mat6X& z_r, Mat6X& zj_r, MatX& zj_a) const;

  /// Takes a generalized force (z_r: 6 x c on the rigid rows, z_a: m x c on the modal ones) on the body of a link, and
  /// in response forces on its unknowns (n x c): makes of response their part along the unknowns, L^-1
  /// (response + H^T z), and leaves in z_r what is passed to the reference body.
  void propagate_force(LinkIndex link, Mat6X& z_r, const MatX& z_a, MatX& response) const;

 private:
  void load_bodies(const std::vector<BodyInertia>& inertias);
  void subtract_applied(const AppliedForces& applied);
  void load_flexible(LinkIndex l, const BodyInertia& inertia);
  void gather_columns(LinkIndex l, const VecX& udot);
  template <int N, bool kOnlyTurns>
  [[gnu::flatten]] void eliminate_rigid(LinkIndex l);
  template <int N>
  [[gnu::noinline]] void pass_on(LinkIndex l, const Mat6& V, const Vec6& p);
  void eliminate_flexible(LinkIndex l);
  [[gnu::always_inline]] inline void add_to_reference_body(LinkIndex l, const Mat6& I, const Vec6& p);
  [[gnu::noinline]] void add_to_reference_modes(LinkIndex l, LinkIndex reference, const Mat6& I, const Vec6& p);
  template <int N>
  void propagate_force_rigid(LinkIndex l, Mat6X& z_r, MatX& response) const;
  [[noreturn, gnu::noinline]] void throw_indefinite(LinkIndex l) const;

  const Kinematics* kinematics_;
  double least_pivot_ = 1.0;
  std::vector<ArticulatedBody> links_;
  std::vector<std::optional<LinkIndex>> reference_of_link_;  // none: ground
  std::vector<std::optional<int>> flexible_of_link_;         // index in flexible_; none: rigid
  std::vector<FlexibleArticulatedBody> flexible_;
};

/// A motion of a link's joint: its speeds.
struct MotionWithoutInertia {
  LinkIndex link;
  JointVector u;
};

/// The outermost link of the opened tree whose joint can move without inertia, and the joint's speeds u (n_u) in that
/// motion, driven ones at rest; also of inertias whose computation threw. "Without" means below round-off of the terms
/// that the inertia is made of.
[[nodiscard]] std::optional<MotionWithoutInertia> find_motion_without_inertia(const ArticulatedInertias& tree);

}  // namespace concord::relative
