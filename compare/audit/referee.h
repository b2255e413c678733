#pragma once

#include <vector>

#include "common/joints/by_function.h"
#include "common/joints/joint_type.h"
#include "compare/audit/speed_columns.h"

/// A third reading of the words of a joint type, beside those of the two solvers: one clause for each word, written
/// down plainly. The audit asks it for numbers, the joint check also for derivatives, which follow from the same
/// clauses by automatic differentiation. Words by functions are asked for their own derivatives.
namespace concord::compare {

/// A function of the placement along a motion with relative velocity v_rel: value, gradient over [d; rho], and the bias
/// of its second derivative, cddot = gradient . a_rel + bias.
struct RefereedRow {
  double value = 0.0;
  Vec6 gradient = Vec6::Zero();
  double bias = 0.0;
};

/// What the type forbids, row by row.
std::vector<RefereedRow> referee_forbids(const joints::JointType& type, const joints::Placement& at, const Vec6& v_rel);

/// What a reading of one number says of a placement: a length [m], or an angle in (-pi, pi]. Throws std::logic_error of
/// an orientation and of a reading by functions.
double referee_reading(const joints::Read& word, const joints::Placement& at);

/// The readings of the type's coordinates, one row for each speed; of an orientation, whose value is no number, the
/// three rows of its rotation away from `at`: value zero, rates omega, biases zero.
std::vector<RefereedRow> referee_reads(const joints::JointType& type, const joints::Placement& at, const Vec6& v_rel);

/// The motion at n_q coordinates and n_u speeds: (d, R), S (the first n_u columns mean something), Sdot u, by
/// differentiation.
joints::FunctionOfCoordinates::Motion referee_permits(const joints::JointType& type, const VecX& q, const VecX& u);

/// Where the motion leads with the n_q coordinates q, and the child's velocity [ddot; omega_rel] for a unit of each
/// speed, 6 x n_u, from the axis and the position of each turn.
struct RefereedMotion {
  joints::Placement placement;
  SpeedColumns S;
};
RefereedMotion referee_motion(const joints::JointType& type, const VecX& q);

/// v_rel = [ddot; omega_rel] of a direction of velocities, where the child stands turned by R.
Vec6 referee_permitted_speed(const joints::PermitSpeed& word, const Mat3& R);

/// Columns [F; T] on the child at P_i in the parent's joint frame whose span holds the coordinate wrenches, 6 x n_u: of
/// what reads from the gap the force along the motion's own column S, of what reads from the orientation the torque
/// about it, or what the reading states.
Mat6X referee_wrench_directions(const joints::JointType& type, const joints::Placement& at, const Mat6X& S);

/// Coordinate wrench of the coordinate forces tau (n_u numbers, zero for an orientation) on the child at P_i in the
/// parent's joint frame [F; T], in the span of referee_wrench_directions(): S^T w = tau. `motion` is that of q.
Vec6 referee_coordinate_wrench(const joints::JointType& type, const joints::FunctionOfCoordinates::Motion& motion,
                               const VecX& tau);

}  // namespace concord::compare
