#pragma once

#include <array>
#include <cmath>

#include "common/joints/joint_type.h"
#include "common/types.h"
#include "relative/bodies/motion_structure.h"

/// Mobilizers: evaluation of what a joint permits, the motion q -> (d, R) and its velocity (S14).
namespace concord::relative {

/// Six rows and as many columns as a joint has speeds, at most six, without heap memory.
using JointColumns = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6>;
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>;
using JointSquare = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;

/// The motion of a joint at (q, u), components in the parent's joint frame: position d [m] and orientation R of the
/// child, v_rel = S u = [ddot; omega_rel] and a_rel = S udot + Sdot_u.
struct JointMotion {
  Vec3 d = Vec3::Zero();
  Mat3 R = Mat3::Identity();
  Mat6 S = Mat6::Zero();  // only the first n_u columns are defined
  Vec6 v_rel = Vec6::Zero();
  Vec6 Sdot_u = Vec6::Zero();
};

/// The mobilizer of one joint type: the motion that its words permit, as a function of joint coordinates and speeds.
class Mobilizer {
 public:
  /// `length` [m]: the displacement that counts as much as a radian where the two must be weighed against each other.
  /// Throws std::invalid_argument if the words stand in an order that the vocabulary excludes: a motion is slides, then
  /// turns, then at most one ball, with arms anywhere before it; a turn before a ball must carry an arm, for the ball
  /// takes its rotation away; a motion by functions stands alone. Also if more than three speeds only displace, or only
  /// rotate.
  explicit Mobilizer(const joints::JointType& type, double length = 1.0);

  [[nodiscard]] int n_q() const { return n_q_; }
  [[nodiscard]] int n_u() const { return n_u_; }
  [[nodiscard]] double length() const { return length_; }
  [[nodiscard]] const ColumnKind& kind(int column) const { return structure_.kinds[column]; }
  /// Whether any speed both displaces and rotates the child.
  [[nodiscard]] bool couples() const { return couples_; }
  /// Whether d or R depends on q other than by slides and turns in place, so that Newton's method needs care.
  [[nodiscard]] bool is_curved() const { return structure_.is_curved; }
  [[nodiscard]] bool has_ball() const { return structure_.has_ball; }
  /// Whether d can be other than zero.
  [[nodiscard]] bool has_place() const { return structure_.has_place; }
  /// The axis about which the child turns, if it can do nothing else; -1 if it can.
  [[nodiscard]] int only_turn() const { return only_turn_; }
  /// Sine and cosine of an angle.
  struct Turned {
    double sine, cosine;
  };
  /// The same as evaluate() where the child can do nothing but turn, for a motion that evaluate() has written before.
  Turned turn_again(double angle, double speed, JointMotion& motion) const {
    Turned turned{};
    ::sincos(angle, &turned.sine, &turned.cosine);
    const int second = only_turn_ == 2 ? 0 : only_turn_ + 1;
    const int third = only_turn_ == 0 ? 2 : only_turn_ - 1;
    motion.R(second, second) = motion.R(third, third) = turned.cosine;
    motion.R(third, second) = turned.sine;
    motion.R(second, third) = -turned.sine;
    motion.v_rel(3 + only_turn_) = speed;
    return turned;
  }
  /// Whether a link on two turns carries the child, so that two sets of coordinates name each pose.
  [[nodiscard]] bool has_elevation() const { return structure_.elevation >= 0; }
  /// Whether coordinate q[c] is an angle, whose whole turns may be counted apart.
  [[nodiscard]] bool is_turn(int c) const { return c < structure_.n_scalars && !kind(c).is_length; }
  /// Whether the motion is stated by functions.
  [[nodiscard]] bool is_by_functions() const { return structure_.by_functions; }

  /// Counts whole turns apart from the coordinates (n_q numbers, zero but for turns): from now on q[c] means the angle
  /// q[c] + 2 pi turns[c], of which no digit is lost however many turns it has made.
  void count_turns(const double* turns);

  /// The motion at n_q coordinates q and n_u speeds u. Euler parameters need not be of unit length (R9).
  void evaluate(const double* q, const double* u, JointMotion& motion) const;

  /// Whether the columns of S are dependent in this pose, to 1e-6 of the largest, displacements counted in `length`.
  [[nodiscard]] bool loses_rank(const JointMotion& motion) const {  // (R13)
    return !structure_.rank_is_certain && columns_are_dependent(motion);
  }

  /// The coordinate wrench w_d of the coordinate forces tau (n_u numbers, N or N m) on the child at P_i, [F; T] in the
  /// parent's joint frame: S^T w_d = tau, with F in the span of the slides' axes and T in that of the turns' (a screw
  /// counts as a turn). A turn before a ball moves a link without mass, which passes no torque to the child: its
  /// coordinate wrench is a force. A motion by functions may state its own span (R12).
  [[nodiscard]] Vec6 coordinate_wrench(const JointMotion& motion, const JointVector& tau) const;

  /// qdot = N(q) u; for a ball pdot = E^T omega / 2 (R10).
  void compute_qdot(const double* q, const double* u, double* qdot) const;

  /// Moves q by a finite step of n_u numbers in the directions of u: a ball turns by exp(step), all else adds (R11).
  void advance(double* q, const double* step) const;

  /// Euler parameters to unit length.
  void normalize(double* q) const;

  /// Gives q the values of the same pose that are meant: where a link stands on two turns at right angles, the name
  /// whose elevation (the second) lies on the same side of a quarter turn as that of `near`; then each turn to the
  /// number of whole turns that is nearest to `near` (R14).
  void choose_chart(double* q, const double* near) const;

  /// Whether q means the branch that `near` means: the elevation of a link on the same side of a quarter turn, turns of
  /// a motion by functions less than half a turn away. All else has one branch.
  [[nodiscard]] bool is_on_branch_of(const double* q, const double* near) const;

  /// The name of a link's pose with its elevation in [-pi/2, pi/2], turns nearest to those of q.
  void choose_canonical_chart(double* q) const;

  /// q of the unmoved joint: zero, and Euler parameters of no rotation; of a motion by functions that may not stand at
  /// zero, the nearest value at which it may.
  [[nodiscard]] VecX home() const;

  /// Whether coordinate q[c] is worth trying elsewhere when a pose is not found, and its k-th trial value, k = 0 .. 3:
  /// quarter turns from `given`, or values spread over the range that a motion by functions states.
  [[nodiscard]] bool has_trials(int c) const;
  [[nodiscard]] double trial(int c, int k, double given) const;

 private:
  void require_three_of_a_kind(const std::string& name) const;
  void rename(double* q, const double* near, bool on_far_side) const;
  [[nodiscard]] bool columns_are_dependent(const JointMotion& motion) const;
  [[nodiscard]] Vec6 comparable(const JointMotion& motion, int column) const;
  [[nodiscard]] bool depend_separately(const JointMotion& motion) const;
  [[nodiscard]] bool depend_together(const JointMotion& motion) const;
  [[nodiscard]] bool has_range(int c) const { return c < static_cast<int>(structure_.ranges.size()); }
  [[nodiscard]] JointColumns wrench_columns(const JointMotion& motion) const;

  std::vector<joints::Permit> words_;
  std::vector<joints::CoordinateKind> coordinates_;  // of all words, in their order
  MotionStructure structure_;
  /// Of a motion by functions, the columns whose span its coordinate wrenches have, if it says so.
  joints::WrenchesOfPlacement stated_wrenches_ = nullptr;
  std::array<double, 6> turns_{};  // of a motion by functions; nothing else knows of whole turns
  double length_;
  int only_turn_ = -1;
  int n_q_ = 0;
  int n_u_ = 0;
  bool couples_ = false;
};

}  // namespace concord::relative
