#include "compare/joint_check/evaluated_pose.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "common/rotation.h"

namespace concord::compare::joint_check {

using cartesian::ConstraintRow;
using cartesian::RelativeMotion;
using joints::Placement;

Vec6 gradient_of(const ConstraintRow& row) { return (Vec6() << row.over_d, row.over_rho).finished(); }

Placement after(const Placement& at, const Vec6& v_rel, double time) {
  const Vec3 omega = v_rel.tail<3>();
  const double speed = omega.norm();
  const Mat3 turned = speed > 0.0 ? rotation_about(Vec3(omega / speed), speed * time) : Mat3(Mat3::Identity());
  return {at.d + time * v_rel.head<3>(), turned * at.R};
}

RelativeMotion relative_motion(const Placement& at, const Vec6& v_rel) {
  return {at.d, at.R, v_rel.head<3>(), v_rel.tail<3>()};
}

std::vector<ConstraintRow> forbids(const JointType& type, const RelativeMotion& motion) {
  std::vector<ConstraintRow> rows(cartesian::kMaxRows);
  rows.resize(cartesian::evaluate_forbids(type, motion, rows.data()));
  return rows;
}

std::vector<ConstraintRow> forbidden_speeds(const JointType& type, const RelativeMotion& motion) {
  std::vector<ConstraintRow> rows(cartesian::kMaxRows);
  rows.resize(cartesian::evaluate_forbidden_speeds(type, motion, rows.data()));
  return rows;
}

std::vector<ConstraintRow> reads(const JointType& type, const RelativeMotion& motion, const Mat3& target) {
  std::vector<ConstraintRow> rows;
  for (const joints::Read& word : type.reads) {
    if (is_orientation(word)) {
      rows.resize(rows.size() + 3);
      cartesian::evaluate_orientation(target, motion, &rows[rows.size() - 3]);
      continue;
    }
    for (int c = 0; c < n_u(word); ++c) rows.push_back(cartesian::evaluate_read(word, c, motion));
  }
  return rows;
}

double change(double from, double to, bool is_turn) {
  return is_turn ? std::remainder(to - from, 2.0 * std::numbers::pi) : to - from;
}

Vec6 rotation_and_displacement(const Placement& from, const Placement& to) {
  const Eigen::AngleAxisd turned(Mat3(to.R * from.R.transpose()));
  Vec6 step;
  step << to.d - from.d, turned.angle() * turned.axis();
  return step;
}

EvaluatedPose::EvaluatedPose(const JointType& of, const MotionPose& pose_of)
    : type(of), pose(pose_of), words(of), referee(referee_permits(of, pose.q, pose.u)) {
  words.evaluate(pose.q.data(), pose.u.data(), permitted);
  at = {permitted.d, permitted.R};
  motion = relative_motion(at, permitted.v_rel);
  forbidden = forbids(type, motion);
  readings = reads(type, motion, permitted.R);
}

relative::JointMotion EvaluatedPose::moved(const VecX& step) const {
  VecX q = pose.q;
  words.advance(q.data(), step.data());
  relative::JointMotion reached;
  words.evaluate(q.data(), pose.u.data(), reached);
  return reached;
}

void note_difference(Property& property, const EvaluatedPose& evaluated, const char* what, std::size_t row,
                     double found, double expected, double scale) {
  property.note((found - expected) / scale, evaluated.pose.number,
                [&] { return fmt::format("{} {}: {:.12g}, expected {:.12g}", what, row + 1, found, expected); });
}

}  // namespace concord::compare::joint_check
