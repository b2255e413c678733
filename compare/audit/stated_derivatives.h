#pragma once

#include <string>
#include <vector>

#include "common/joints/joint_type.h"
#include "compare/audit/joint_motion.h"

/// Derivatives of joint types that are given by functions: both solvers take them from the same automatic
/// differentiation, so that the third opinion holds them against differences of the functions' values.
namespace concord::compare {

/// One kind of derivative of one function.
struct StatedDerivative {
  /// By how much the derivative misses the differences, and the size of its terms; in units of the function's own.
  double misfit = 0.0;
  double scale = 0.0;
};

/// What is differenced of a type, in the order of compute_stated_derivatives: "slopes of the motion", "Sdot u of the
/// motion", "slopes of the residuals", "bias of the residuals", "slopes of the reading", "bias of the reading". Empty
/// for a type without functions.
std::vector<std::string> stated_derivatives(const joints::JointType& type);

/// The derivatives of a type's functions at a placement, at velocities v_rel, coordinates q and speeds u. `length` [m]
/// is the longest way that the differences go; they go shorter ones where that shows more.
std::vector<StatedDerivative> compute_stated_derivatives(const joints::JointType& type, const RelativeMotion& relative,
                                                         const JointMotion& motion, double length);

}  // namespace concord::compare
