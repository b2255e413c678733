#pragma once

#include <vector>

#include "relative/dynamics/articulated_inertias.h"

/// The articulated-body pass from ground to the outermost links: accelerations of the opened tree.
namespace concord::relative {

/// Accelerations of speeds, bodies and joint points of the tree, and the right sides from which they follow. All memory
/// is laid out at construction.
class TreeAccelerations {
 public:
  /// For the links of these inertias, which need not be computed yet. The kinematics must outlive this object.
  TreeAccelerations(const Kinematics& kinematics, const ArticulatedInertias& tree);

  /// From the right sides that the inertias hold, and the prescribed accelerations in udot (n_u numbers).
  void solve(const ArticulatedInertias& tree, const VecX& udot);

  /// Adds to a link's right side what a generalized force of projection `response` (n numbers) adds; the accelerations
  /// stay what they are.
  void add_force(LinkIndex link, const Eigen::Ref<const VecX>& response);
  /// From the right sides that these have become.
  void solve_again(const ArticulatedInertias& tree);

  /// Of the speeds: n_u numbers, of cut joints only the driven ones.
  [[nodiscard]] const VecX& udot() const { return udot_; }
  /// [vdot; omegadot] of a body at its reference point, and of a link's.
  [[nodiscard]] const Vec6& of_body(BodyIndex body) const { return links_[place_of_body_[body]].Vdot; }
  [[nodiscard]] const Vec6& of_link(LinkIndex link) const { return links_[link].Vdot; }
  /// addot of a body; nullptr if it is rigid.
  [[nodiscard]] const VecX* of_modes(BodyIndex body) const;
  /// Vdot_P of a joint's point, [linear; angular], global axes (R38).
  [[nodiscard]] Vec6 of_point(JointIndex joint, Side side) const;

 private:
  struct OfLink {
    Vec6 uhat = Vec6::Zero();
    Vec6 Vdot = Vec6::Zero();
  };
  struct OfFlexible {
    VecX uhat;
    VecX udot;
    VecX addot;
  };

  [[gnu::always_inline]] inline void load(const ArticulatedInertias& tree, LinkIndex l);
  void solve_link(const ArticulatedInertias& tree, LinkIndex l);
  [[gnu::always_inline]] [[nodiscard]] inline Vec6 acceleration_from_reference(LinkIndex l) const;
  template <int N>
  [[gnu::always_inline]] inline void solve_rigid(const ArticulatedInertias& tree, LinkIndex l, const Vec6& A0);
  void solve_flexible(const ArticulatedInertias& tree, LinkIndex l, const Vec6& A0);

  const Kinematics* kinematics_;
  std::vector<OfLink> links_;                         // and ground, at rest, after the last
  std::vector<int> place_of_body_;                    // among these
  std::vector<int> place_of_reference_;               // by link
  std::vector<std::optional<int>> flexible_of_link_;  // index in flexible_; none: rigid
  std::vector<OfFlexible> flexible_;
  VecX udot_;
};

}  // namespace concord::relative
