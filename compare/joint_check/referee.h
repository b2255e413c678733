#pragma once

#include <vector>

#include "common/joints/by_function.h"
#include "common/joints/joint_type.h"

/// A third reading of the words of a joint type, beside those of the two solvers: values written down plainly, every
/// derivative by automatic differentiation. Words by functions are asked for their own derivatives.
namespace concord::compare::joint_check {

using joints::JointType;
using joints::Placement;

/// A function of the placement along a motion with relative velocity v_rel: value, gradient over [d; rho], and the bias
/// of its second derivative, cddot = gradient . a_rel + bias.
struct RefereedRow {
  double value = 0.0;
  Vec6 gradient = Vec6::Zero();
  double bias = 0.0;
};

/// What the type forbids, row by row.
std::vector<RefereedRow> referee_forbids(const JointType& type, const Placement& at, const Vec6& v_rel);

/// The readings of the type's coordinates, one row for each speed; of an orientation, whose value is no number, the
/// three rows of its rotation away from `at`: value zero, rates omega, biases zero.
std::vector<RefereedRow> referee_reads(const JointType& type, const Placement& at, const Vec6& v_rel);

/// The motion at n_q coordinates and n_u speeds: (d, R), S (the first n_u columns mean something), Sdot u.
joints::FunctionOfCoordinates::Motion referee_permits(const JointType& type, const VecX& q, const VecX& u);

/// Coordinate wrench of the coordinate forces tau (n_u numbers, zero for an orientation) on the child at P_i in the
/// parent's joint frame [F; T]: a force along each slide, a torque about each turn, a force on the end of the arm for a
/// turn that carries one, or what a reading by functions says; S^T w = tau. `motion` is that of q.
Vec6 referee_coordinate_wrench(const JointType& type, const joints::FunctionOfCoordinates::Motion& motion,
                               const VecX& tau);

}  // namespace concord::compare::joint_check
