#pragma once

#include <array>
#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "compare/audit/joint_motion.h"

/// Do the bodies move as the joints permit? Places, velocities and accelerations of the third opinion: read from the
/// bodies and differenced along their motion; no solver's Jacobian, gamma or Sdot u is used.
namespace concord::compare {

/// Sizes by unit: of what is measured along a line, and of what turns.
struct LineAndTurn {
  double line = 0.0;
  double turn = 0.0;

  [[nodiscard]] double of(bool turns) const { return turns ? turn : line; }
};

/// How well the two bodies of a joint obey it in one state, in the parent's joint frame.
struct JointKinematics {
  /// Of places: [d; rotation vector] from where the motion leads that the joint's coordinates say [m, rad].
  Vec6 place = Vec6::Zero();
  /// Of velocities: what of v_rel no permitted speed gives [m/s, rad/s].
  Vec6 velocity = Vec6::Zero();
  /// The rate of that along the motion: what of a_rel - Sdot u no permitted acceleration gives [m/s2, rad/s2].
  Vec6 acceleration = Vec6::Zero();
  /// Accelerations of the joint's speeds, udot, by differences; NaN if nothing is expected of any.
  VecX udot;
  /// How uncertain these differences are, by entry.
  Vec6 doubt_of_acceleration = Vec6::Zero();
  VecX doubt_of_udot;
  /// Near a pose where a coordinate has no meaning its reading magnifies by how much a state is closed at best: what
  /// that leaves open in q and u, by entry; zero elsewhere. doubt_of_udot has it too.
  VecX doubt_of_q;
  VecX doubt_of_u;
  /// Coordinates, speeds and permitted directions of the joint, and where its child is.
  JointMotion motion;
  RelativeMotion relative;
  /// Sizes of the terms that were added up: of the velocities, and of the accelerations.
  LineAndTurn speed;
  LineAndTurn rate_of_speed;
};

/// `hint`: coordinates from which turns are counted. `expected_udot`: n_u numbers, what the joint accelerations should
/// be; NaN where nothing is expected. `length`: of the machine [m]. Accelerations are differenced along the motion,
/// which resolves some 1e-12 of the size of the terms.
JointKinematics read_kinematics(const Joint& joint, const State& state, const Evaluation& evaluation, const VecX& hint,
                                const VecX& expected_udot, double length);

/// Accelerations of the joint's speeds, udot, in a machine that moves smoothly: by one quotient of eighth order along
/// the motion, good to some 1e-14 of the size of the terms.
VecX joint_accelerations(const Joint& joint, const State& state, const Evaluation& evaluation, const VecX& hint,
                         double length);

}  // namespace concord::compare
