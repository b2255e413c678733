#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "compare/audit/law_of_force.h"
#include "compare/audit/places.h"
#include "compare/audit/speed_columns.h"

/// Coordinates, speeds and permitted directions of a joint as the third opinion reads them from the bodies alone.
namespace concord::compare {

struct JointMotion {
  /// Joint coordinates, turns counted from the hint; Euler parameters of a ball.
  VecX q;
  /// Joint speeds: those with S u nearest to v_rel.
  SpeedVector u;
  /// v_rel = S u, 6 x n_u, in the parent's joint frame.
  SpeedColumns S;
  /// The speeds that are possible, u = free w: identity but where the type forbids velocities alone (n_u rows).
  SpeedMatrix free;
  /// Where the motion leads with the coordinates q: position and orientation in the parent's joint frame.
  Vec3 d = Vec3::Zero();
  Mat3 R = Mat3::Identity();
};

/// JointMotion::free of a type where its child stands turned by R and its speeds have the columns S.
SpeedMatrix free_speeds(const joints::JointType& type, const Mat3& R, const SpeedColumns& S);

/// The child's frame of a joint seen from the parent's.
RelativeMotion relative_motion_of(const Joint& joint, const State& state);

/// Reads a joint's motion from where its frames are. `hint`: coordinates near the wanted ones, which fix the number of
/// turns; an empty one means none.
JointMotion read_motion(const joints::JointType& type, const RelativeMotion& relative, const VecX& hint);
/// All of it but the speeds u.
JointMotion read_pose(const joints::JointType& type, const RelativeMotion& relative, const VecX& hint);

/// Columns [F; T] on the child at P_i in the parent's joint frame whose span holds the coordinate wrenches, 6 x n: the
/// permitted directions themselves (a slide's force along it, a turn's torque about it, for a turn with an arm the
/// force at the arm's end), or what a type by functions states.
Mat6X coordinate_wrench_directions(const joints::JointType& type, const RelativeMotion& relative, const Mat6X& S);

/// The laws of a joint's springs, in the order of Joint::springs, which must outlive them.
std::vector<LawOfForce> laws_of_springs(const Joint& joint);

/// What each actor exerts on the speeds of a joint by the laws of Joint::springs, zero where it does nothing [n_u
/// numbers each; zero of drivers, whose force no law gives]. A spring exerts what its law says at rest in the same
/// place, a damper the rest. `springs`: the laws of Joint::springs, in their order.
std::array<VecX, kActors.size()> shares_by_laws(const Joint& joint, const std::vector<LawOfForce>& springs,
                                                const JointMotion& motion, double t);

/// tau that the springs, dampers and actuators of a joint exert by their laws, and zero where there are none; NaN
/// where a driver acts, whose force no law gives [n_u numbers]. Couplings are left out. `springs`: the laws of
/// Joint::springs, in their order.
VecX tau_by_laws(const Joint& joint, const std::vector<LawOfForce>& springs, const JointMotion& motion, double t);

/// Sizes of what springs and dampers, and actuators, of a joint exert on each speed [n_u numbers], though a driver may
/// hold them.
VecX sizes_of_springs(const Joint& joint, const std::vector<LawOfForce>& springs, const JointMotion& motion, double t);

/// tau that the couplings of a model exert on the speeds of joint k, given their forces (one for each coupling).
VecX coupled_tau(const Model& model, int k, const std::vector<double>& forces);

/// Whether each joint speed is an angular one [rad/s] or else a velocity [m/s].
std::vector<bool> turning_speeds(const joints::JointType& type);
/// The same of the columns of JointMotion::free.
std::vector<bool> turning_free_speeds(const joints::JointType& type);

/// Names of the joint speeds: "slide_z", "turn_x", "ball_x" for the three of a ball.
std::vector<std::string> speed_names(const joints::JointType& type);

}  // namespace concord::compare
