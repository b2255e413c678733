#pragma once

#include "common/attachment.h"
#include "common/model.h"
#include "common/results.h"

/// Where a joint or a force element sits in a state, and how it moves there: kinematics of the third opinion, derived
/// for it alone.
namespace concord::compare {

/// Rotation of Euler parameters, scalar first.
Mat3 rotation_of(const Vec4& p);

/// exp(theta~).
Mat3 exponential_of(const Vec3& theta);

/// Euler parameters of the orientation p turned by the rotation vector `by`, global axes.
Vec4 turned(const Vec4& p, const Vec3& by);

/// J with (d/dt exp(theta~)) exp(theta~)^T = (J thetadot)~.
Mat3 exponential_rate(const Vec3& theta);

/// The rotation vector theta of R = exp(theta~), |theta| <= pi.
Vec3 rotation_vector_of(const Mat3& R);

/// A place on a body, all in global axes: lever A s_P from the body's origin to the deformed point, the point itself,
/// the frame A' there, and their velocities.
struct PlacedFrame {
  Vec3 lever;
  Vec3 r_P;
  Mat3 A_joint;
  Vec3 v_P;
  Vec3 omega_joint;
};
PlacedFrame place(const Attachment& side, const BodyState& body);

/// The child's frame seen from the parent's: d and R (S10) and v_rel = [ddot; omega_rel], all in the parent's joint
/// frame.
struct RelativeMotion {
  Vec3 d;
  Mat3 R;
  Vec6 v_rel;
};
RelativeMotion relative_motion(const PlacedFrame& parent, const PlacedFrame& child);

}  // namespace concord::compare
