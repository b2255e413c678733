#pragma once

#include <type_traits>
#include <vector>

#include "cartesian/bodies/joint_rows.h"
#include "compare/audit/referee.h"
#include "compare/joint_check/poses.h"
#include "compare/joint_check/property.h"
#include "relative/bodies/mobilizer.h"

/// A joint type at one pose, by all who know its words, and what the checks of words share.
namespace concord::compare::joint_check {

/// Gradient of a row over [d; rho].
Vec6 gradient_of(const cartesian::ConstraintRow& row);

/// The placement after moving with constant ddot and omega for `time`.
joints::Placement after(const joints::Placement& at, const Vec6& v_rel, double time);

/// The placement on its way with v_rel = [ddot; omega_rel], as the Cartesian solver takes it.
cartesian::RelativeMotion relative_motion(const joints::Placement& at, const Vec6& v_rel);

/// What the type forbids, row by row, by the Cartesian solver.
std::vector<cartesian::ConstraintRow> forbids(const JointType& type, const cartesian::RelativeMotion& motion);

/// What the type forbids of velocities alone, likewise.
std::vector<cartesian::ConstraintRow> forbidden_speeds(const JointType& type, const cartesian::RelativeMotion& motion);

/// One row for each speed: the readings by the Cartesian solver, and of an orientation the three rows of its distance
/// from `target`.
std::vector<cartesian::ConstraintRow> reads(const JointType& type, const cartesian::RelativeMotion& motion,
                                            const Mat3& target);

/// Change of an angle, to the nearest whole turn, or of a length.
double change(double from, double to, bool is_turn);

/// The step that leads from one placement to another: displacement [m] and rotation vector [rad].
Vec6 rotation_and_displacement(const joints::Placement& from, const joints::Placement& to);

/// A joint type evaluated at one pose by all who know it: both solvers and the referee. Type and pose are the caller's.
struct EvaluatedPose {
  EvaluatedPose(const JointType& of, const MotionPose& pose_of);

  /// The motion with other coordinates: moved by `step` along the speeds.
  [[nodiscard]] relative::JointMotion moved(const VecX& step) const;

  [[nodiscard]] MatX S() const { return permitted.S.leftCols(type.n_u()); }
  [[nodiscard]] double speed() const { return 1.0 + permitted.v_rel.norm(); }

  const JointType& type;
  const MotionPose& pose;
  relative::Mobilizer words;
  relative::JointMotion permitted;
  joints::FunctionOfCoordinates::Motion referee;
  joints::Placement at;
  cartesian::RelativeMotion motion;
  std::vector<cartesian::ConstraintRow> forbidden;
  std::vector<cartesian::ConstraintRow> readings;
};

/// Notes how far a number of a row is from the one expected, in parts of `scale`.
void note_difference(Property& property, const EvaluatedPose& evaluated, const char* what, std::size_t row,
                     double found, double expected, double scale);

/// Derivative at zero of a function of one variable [m or rad]: central differences of two step lengths, extrapolated.
template <class Function>
auto differentiate(const Function& f) {
  constexpr double kStep = 1e-3;
  using Value = std::decay_t<decltype(f(0.0))>;
  const Value fine = (f(kStep) - f(-kStep)) / (2.0 * kStep);
  const Value coarse = (f(2.0 * kStep) - f(-2.0 * kStep)) / (4.0 * kStep);
  return Value((4.0 * fine - coarse) / 3.0);
}

}  // namespace concord::compare::joint_check
