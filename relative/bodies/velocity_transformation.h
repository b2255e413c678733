#pragma once

#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "relative/bodies/joint_point.h"
#include "relative/bodies/machine_size.h"
#include "relative/bodies/mobilizer.h"
#include "relative/bodies/small_products.h"
#include "relative/bodies/topology.h"
#include "relative/bodies/turns.h"

/// The velocity transformation Y = B u, Ydot = B udot + Bdot u, link by link (R19) to (R22).
namespace concord::relative {

/// Blocks of one link, body i on reference body j, global axes, at the reference points, without the trivial rows:
///   [v; omega]_i = Sh(rho) [v; omega]_j + Xa adot_j + H u_joint - Ha adot_i, and the same for accelerations plus D.
/// Sh(rho) = [1, -rho~; 0, 1] moves a velocity by rho = r_i - r_j; adot_i are speeds of the tree themselves (R19).
struct LinkBlocks {
  Vec3 rho = Vec3::Zero();
  Mat6 H = Mat6::Zero();  // first n_u columns
  Vec6 D = Vec6::Zero();
  Mat6X Xa;  // 6 x m_j
  Mat6X Ha;  // 6 x m_i
};

/// Moves a velocity or an acceleration [linear; angular] from one point of a frame to another, by e: Sh(e) V (R18).
[[gnu::always_inline]] inline Vec6 shift_motion(const Vec6& V, const Vec3& e) {
  const double x = V(4) * e.z() - V(5) * e.y();
  const double y = V(5) * e.x() - V(3) * e.z();
  const double z = V(3) * e.y() - V(4) * e.x();
  return sum_of_pairs(V, Pair{x, y}, Pair{z, 0.0}, Pair{});
}

/// Moves a wrench [force; torque] to a point from which the old one is seen at e: Sh(e)^T w (R18).
[[gnu::always_inline]] inline Vec6 shift_wrench(const Vec6& w, const Vec3& e) {
  const double x = e.y() * w(2) - e.z() * w(1);
  const double y = e.z() * w(0) - e.x() * w(2);
  const double z = e.x() * w(1) - e.y() * w(0);
  return sum_of_pairs(w, Pair{}, Pair{0.0, x}, Pair{y, z});
}

/// A wrench [F; T] about one point of a frame, global axes, in that frame's axes, paper (29), and in global ones. It
/// is what is reported on either side of a joint (R30).
inline SideWrench in_both_frames(const Mat3& A_joint, const Vec6& w) {
  return {{A_joint.transpose() * w.head<3>(), A_joint.transpose() * w.tail<3>()}, {w.head<3>(), w.tail<3>()}};
}

/// The opposite wrench, moved from the point `from` to the point `to`: the wrench on the other side (R30).
inline Vec6 opposite_wrench_at(const Vec6& wrench, const Vec3& from, const Vec3& to) {
  return -shift_wrench(wrench, from - to);
}

/// Velocity of the child's joint frame relative to the parent's: v_rel_C = [ddot; omega_rel] (R17).
Vec6 relative_velocity(const JointPoint& parent, const JointPoint& child);

/// Motion of all bodies and joint points for given coordinates and speeds, by a forward pass; its cost is
/// proportional to their number.
class Kinematics {
 public:
  /// The model must outlive this object. Throws InputError if the tree cannot be built.
  explicit Kinematics(const Model& model);
  Kinematics(const Kinematics&) = delete;
  Kinematics& operator=(const Kinematics&) = delete;
  Kinematics(Kinematics&&) = default;
  Kinematics& operator=(Kinematics&&) = default;
  ~Kinematics() = default;

  [[nodiscard]] const Model& model() const { return *model_; }
  [[nodiscard]] const Topology& topology() const { return topology_; }
  [[nodiscard]] const MachineSize& size() const { return size_; }
  [[nodiscard]] const Mobilizer& mobilizer(JointIndex joint) const { return mobilizers_[joint]; }

  /// Counts whole turns apart from the coordinates, which so keep their digits after many of them: from now on a
  /// coordinate q means q + 2 pi turns (n_q whole numbers, zero but for turns).
  void count_turns(const VecX& turns);
  [[nodiscard]] const VecX& turns() const { return turns_; }
  /// A coordinate with its whole turns, and one that is given with them without those that are counted apart.
  [[nodiscard]] double with_turns(int place, double q) const { return add_turns(q, turns_(place)); }
  [[nodiscard]] double without_turns(int place, double value) const { return add_turns(value, -turns_(place)); }
  /// All of them.
  [[nodiscard]] VecX with_turns(const VecX& q) const;
  [[nodiscard]] VecX without_turns(const VecX& values) const;
  /// Whole turns that coordinates have made, zero for all that have made no more than `least`.
  [[nodiscard]] VecX whole_turns(const VecX& q, double least = 1.0) const;

  /// Takes n_q coordinates and n_u speeds (cut joints' included, which have no effect here) and computes all that
  /// follows. Throws SolverError if a joint frame has turned too far on a flexible body, or if a joint of the tree
  /// loses a direction of its motion in this pose.
  void update(const VecX& q, const VecX& u);

  /// Takes the motion of all bodies (of their origins) as given, for measuring joints between them; blocks are left
  /// alone.
  void place(const std::vector<BodyState>& bodies);

  /// At the reference point of a body, and at the origin of its frame.
  [[nodiscard]] const BodyMotion& body(BodyIndex i) const { return bodies_[i]; }
  [[nodiscard]] BodyMotion motion_of_origin(BodyIndex i) const;
  /// [vdot; omegadot] at the origin of a body's frame, from that at its reference point, as of the last update.
  [[nodiscard]] Vec6 acceleration_of_origin(BodyIndex i, const Vec6& Vdot) const;
  /// Largest entry of the places of all bodies' origins [m], whose round-off states hold.
  [[nodiscard]] double farthest_place() const;
  [[nodiscard]] const LinkBlocks& blocks(LinkIndex link) const { return blocks_[link]; }
  [[nodiscard]] const JointPoint& point(JointIndex joint, Side side) const { return points_[2 * joint + index(side)]; }
  /// Joint motion of a tree joint, as of the last update.
  [[nodiscard]] const JointMotion& joint_motion(JointIndex joint) const { return joint_motions_[joint]; }

  /// Throws SolverError, naming the joint, if the columns S of its motion are dependent.
  void require_rank(JointIndex joint, const JointMotion& motion) const;

  /// Rows W_b (rows x (6 + m_b)) that act on Y_b of a body, carried to ground: adds W_b B_b to `rows`
  /// (rows x n_tree_u) (R23).
  void add_times_B(BodyIndex body, MatX rows_on_body, MatX& rows) const;

  /// Row of the first of the 6 + m_i numbers Y_i in B; bodies in the order of the model, without ground.
  [[nodiscard]] int first_row(BodyIndex body) const { return first_rows_[body]; }
  [[nodiscard]] int n_rows() const { return n_rows_; }

  /// The explicit B, by (R23): n_rows x n_tree_u. For inspection; the solver never forms it.
  [[nodiscard]] MatX explicit_B() const;
  /// The same, of the origins of the bodies' frames.
  [[nodiscard]] MatX explicit_B_of_origins() const;
  /// Bdot u (R22), n_rows numbers.
  [[nodiscard]] VecX Bdot_u() const;
  /// Y of all bodies, n_rows numbers.
  [[nodiscard]] VecX Y() const;

 private:
  JointPoint& moving_point(JointIndex joint, Side side) { return points_[2 * joint + index(side)]; }
  void deform(JointIndex joint, Side side);
  /// What a joint of the tree moves, in global axes.
  struct JointStep {
    Vec3 d = Vec3::Zero();
    Vec3 sliding_velocity = Vec3::Zero();
    Vec3 spin = Vec3::Zero();
  };

  void update_link(LinkIndex l);
  void update_turning_link(LinkIndex l);
  /// What the forward pass reads and writes on a link, where it stands.
  struct LinkPlaces {
    const Mobilizer* mobilizer;
    JointMotion* motion;
    JointPoint* reference;
    JointPoint* own;
    const BodyMotion* reference_body;
    BodyMotion* body;
    LinkBlocks* blocks;
    int first_q, first_u;
    int only_turn;     // the axis, if the joint can do nothing but turn; else -1
    double sign;       // 1 if the tree runs along the joint, else -1
    bool is_flexible;  // whether either body has modes
  };

  void lay_out_places();
  void deform_both_sides(const Link& link);
  void place_child_side(const Link& link, JointStep& step);
  void place_parent_side(const Link& link, JointStep& step);
  void take_joint_step(const Link& link, JointStep& step) const;
  void compute_blocks(LinkIndex l, const JointStep& step);
  void compute_columns(LinkIndex l, const Vec3& from_child);
  void shift_modes(LinkIndex l, const Vec3& from_reference, const Vec3& from_own);
  void place_cut_joint_points();

  const Model* model_;
  Topology topology_;
  MachineSize size_;
  std::vector<Mobilizer> mobilizers_;
  std::vector<JointPoint> points_;
  std::vector<JointMotion> joint_motions_;
  std::vector<BodyMotion> bodies_;
  std::vector<LinkBlocks> blocks_;
  std::vector<LinkPlaces> places_;
  std::vector<int> first_rows_;
  int n_rows_ = 0;
  VecX turns_;
  VecX q_;
  VecX u_;
};

}  // namespace concord::relative
