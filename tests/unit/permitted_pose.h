#pragma once

#include <Eigen/Geometry>
#include <random>

#include "common/joints/joint_type.h"
#include "common/rotation.h"

/// What a joint type permits, followed word by word for tests: by code that neither a solver nor the referee has.
namespace concord::joints {

/// A pose of the permitted motion and its directions [ddot; omega_rel], in the parent's joint frame.
struct PermittedPose {
  Vec3 d = Vec3::Zero();
  Mat3 R = Mat3::Identity();
  Mat6X S = Mat6X(6, 0);

  void add(const Vec3& velocity, const Vec3& turning) {
    S.conservativeResize(6, S.cols() + 1);
    S.rightCols<1>() << velocity, turning;
  }
  /// An arm moves as the turns before it turn.
  void reach(const Vec3& arm) {
    d += arm;
    for (auto column : S.colwise()) column.head<3>() += Vec3(column.tail<3>()).cross(arm);
  }
  /// The turns before a ball are not the child's.
  void turn_alone() {
    R.setIdentity();
    S.bottomRows<3>().setZero();
  }
};

inline PermittedPose random_pose(const JointType& type, std::mt19937& generator) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  PermittedPose pose;
  for (const Permit& word : type.permits) {
    if (const auto* slide = std::get_if<Slide>(&word)) {
      const Vec3 axis = pose.R.col(index(slide->axis));
      pose.add(axis, Vec3::Zero());
      pose.d += uniform(generator) * axis;
    } else if (const auto* turn = std::get_if<Turn>(&word)) {
      pose.add(Vec3::Zero(), pose.R.col(index(turn->axis)));
      pose.R = pose.R * rotation_about(turn->axis, uniform(generator));
    } else if (const auto* arm = std::get_if<Arm>(&word)) {
      pose.reach(arm->length * pose.R.col(index(arm->axis)));
    } else if (const auto* by = std::get_if<ByMotion>(&word)) {
      const VecX q = VecX::NullaryExpr(n_q(word), [&] { return uniform(generator); });
      FunctionOfCoordinates::Motion motion;
      by->motion->evaluate(q.data(), q.data(), motion);
      pose.d = motion.placement.d;
      pose.R = motion.placement.R;
      pose.S = motion.S.leftCols(n_q(word));
    } else {
      pose.turn_alone();
      for (int k = 0; k < 3; ++k) pose.add(Vec3::Zero(), Vec3::Unit(k));
      const Vec3 axis = Vec3::NullaryExpr([&] { return uniform(generator); }).normalized();
      pose.R = pose.R * rotation_about(axis, 1.0 + uniform(generator));
    }
  }
  return pose;
}

/// An axis of the parent or of the child in the pose, in the parent's joint frame.
inline Vec3 axis_in(const PermittedPose& pose, Side axis_of, Axis axis) {
  return axis_of == Side::parent ? Vec3::Unit(index(axis)) : Vec3(pose.R.col(index(axis)));
}

inline Vec6 direction_of(const PermitSpeed& word, const PermittedPose& pose) {
  Vec6 direction;
  if (const auto* along = std::get_if<SpeedAlong>(&word)) {
    direction << axis_in(pose, along->axis_of, along->axis), Vec3::Zero();
  } else {
    const auto& about = std::get<SpeedAbout>(word);
    const Vec3 axis = axis_in(pose, about.axis_of, about.axis);
    direction << about.below * axis.cross(Vec3::UnitZ()), axis;
  }
  return direction;
}

}  // namespace concord::joints
