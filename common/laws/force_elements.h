#pragma once

#include <array>
#include <string>
#include <variant>

#include "common/attachment.h"
#include "common/error.h"
#include "common/laws/force_law.h"
#include "common/laws/tire.h"

/// Force elements: what pushes and pulls on bodies and is no joint. Each is a statement; the solvers turn it into
/// generalized forces by virtual work (S20). Ends are places on bodies with frames, as for joints,
/// and move with the modes: A' = A R(theta) C is the end's frame.
namespace concord {

/// Axes in which the components of a load are said: those of ground, of the body frame A, or of the end's own frame A',
/// which follows the body's deformation.
enum class LoadAxes { global, body, follower };

/// A force and a torque on one body at a point, both times one law of time (S32).
struct Load {
  Attachment at;
  LoadAxes axes = LoadAxes::global;
  Vec3 force = Vec3::Zero();   // N
  Vec3 torque = Vec3::Zero();  // N m
  TimeFunction law = ConstantSpeed{1.0, 0.0};
};

/// A translational spring, damper and actuator along the line between two points, x = their distance. Tension (the law
/// and the actuator) pulls each end towards the other. Below 1e-9 of the machine's length the line
/// has no direction (S33): refused where the force jumps there.
struct LineSpring {
  std::array<Attachment, 2> ends;
  ForceLaw law;
};

/// A rotational spring, damper and actuator between two bodies about the z axis of the parent's end frame:
/// x = the angle from the parent's x axis to the child's, seen along the parent's z (as TurnOfChildAxis{z, x} reads
/// it): in (-pi, pi] at the start, and from there on continued through whole turns. With R the child's frame in the
/// parent's, g = dx/drho (dR = rho~ R) and f the law and the actuator, the torque on the child is -f g in the parent's
/// end frame, and on the parent the opposite: pure couples, conjugate to x also where the axes z do not coincide.
struct TurnSpring {  // (S34)
  std::array<Attachment, 2> ends;
  ForceLaw law;
};

/// Six springs and dampers between two frames. With d = A_j'^T (r_Pi - r_Pj), theta = log(R) (beyond 175 deg it is
/// refused, unless no stiffness or preload asks for it) and v_rel = [ddot; omega_rel], all in the parent's end frame,
/// the wrench on the child at P_i in those axes is [F; T] = -L^T (stiffness [d; theta] - preload) - damping v_rel, with
/// L = diag(1, J^-1(theta)), thetadot = J^-1 omega_rel. On the parent, at P_j: -F and -(T + d x F) (S35).
struct Bushing {
  std::array<Attachment, 2> ends;
  Mat6 stiffness = Mat6::Zero();  // symmetric; N/m, N m/rad
  Mat6 damping = Mat6::Zero();    // N s/m, N m s/rad
  Vec6 preload = Vec6::Zero();    // wrench on the child at d = 0, theta = 0
};

struct ForceElement {
  std::string name;
  std::variant<Load, LineSpring, TurnSpring, Bushing, Tire> what;
  SourceLocation where;
};

/// The element's end on `side`; a load or a tire has only that of the child, its one body.
const Attachment* end_of(const ForceElement& element, Side side);

}  // namespace concord
