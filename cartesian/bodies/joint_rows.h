#pragma once

#include "common/joints/joint_type.h"
#include "common/types.h"

/// Evaluators of what a joint forbids and of how its coordinates read, on (d, R) in the parent's joint frame. A row's
/// gradient is taken over (d, rho) with dR = rho~ R, so that cdot = gradient . [ddot; omega_rel]; its bias is the rest
/// of cddot = gradient . a_rel + bias, exact along the motion.
namespace concord::cartesian {

/// The child's position and orientation seen in the parent's joint frame, and their motion.
struct RelativeMotion {
  Vec3 d = Vec3::Zero();
  Mat3 R = Mat3::Identity();
  Vec3 ddot = Vec3::Zero();
  Vec3 omega = Vec3::Zero();  // Rdot = omega~ R
  /// An arm's elevation is beyond a right angle: its bearing is that of the other side. (d, R) alone cannot tell.
  bool is_beyond_upright = false;
};

struct ConstraintRow {  // (C15)
  double value = 0.0;
  Vec3 over_d = Vec3::Zero();
  Vec3 over_rho = Vec3::Zero();
  double bias = 0.0;

  /// Whether it depends on d, and so carries the round-off of places far from the origin.
  [[nodiscard]] bool reads_places() const { return (over_d.array() != 0.0).any(); }
};

/// Room for the rows of one type: it forbids at most 6 directions.
inline constexpr int kMaxRows = 6;

/// Rows of all words of `type.forbids`, written to `rows`; returns their number (S12).
int evaluate_forbids(const joints::JointType& type, const RelativeMotion& motion, ConstraintRow* rows);

/// Rows of all words of `type.forbids_speeds`, written to `rows`; returns their number. They have no value: only their
/// rate vanishes (S13).
int evaluate_forbidden_speeds(const joints::JointType& type, const RelativeMotion& motion, ConstraintRow* rows);

/// Whether the placement is on the branch that the words mean (a hinge's axes point the same way).
bool on_branch(const joints::JointType& type, const RelativeMotion& motion);

/// How a word of `type.permits` reads; nullptr for an arm, which has no coordinate.
const joints::Read* read_of(const joints::JointType& type, int word);

/// The row of one coordinate of a reading: its value (an angle in (-pi, pi]), gradient and bias. The reading must be of
/// numbers (not of an orientation) (S16).
ConstraintRow evaluate_read(const joints::Read& read, int component, const RelativeMotion& motion);

/// Whether this coordinate is an angle known but for full turns; a reading by functions that goes on beyond a full turn
/// (a thread's height) is not. Evaluates the functions: not for hot paths.
bool reads_turn(const joints::Read& read, int component);

/// The value of a reading's row with its turns counted: an angle known but for full turns is moved by these to within
/// half a turn of `known` (C23).
double value_near(bool is_known_but_for_turns, const ConstraintRow& row, double known);

/// The whole turns [rad] that bring an angle, known but for these, nearest to `known`; in more digits than a coordinate
/// has, so that they cancel against others without loss.
long double whole_turns_between(double value, double known);

/// How far an angle that is known but for whole turns is from `asked`, in [-pi, pi]; no digit of `asked` is lost
/// however many turns it counts.
double turn_from(double asked, double value);

/// Rate of a row along the motion, gradient . [ddot; omega] (C15).
double rate_of(const ConstraintRow& row, const RelativeMotion& motion);

/// Three rows that vanish where the orientation is `target`: half the axial vector of R target^T (C21).
void evaluate_orientation(const Mat3& target, const RelativeMotion& motion, ConstraintRow* rows);

/// Coordinate wrench of the coordinate forces tau (n_u numbers): on the child at P_i in the parent's joint frame,
/// [force; torque], in the span of the slides' forces and of the turns' torques (of an arm's turns: of the forces that
/// move the arm's end; of readings by functions: of what they say), with S^T w = tau (C24).
Vec6 coordinate_wrench(const joints::JointType& type, const RelativeMotion& motion, const Eigen::Ref<const VecX>& tau);

}  // namespace concord::cartesian
