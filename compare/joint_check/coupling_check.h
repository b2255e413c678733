#pragma once

#include "compare/joint_check/sheet.h"

namespace concord::compare::joint_check {

/// What a sheet of couplings is called, beside the names of joint types.
inline constexpr std::string_view kCouplings = "coupling";

/// All that there is a sheet of: the joint types of the catalogue, and couplings.
std::vector<std::string> subject_names();

/// Relations between joint coordinates through both solvers: a planetary gear and a mixing lever on a body that flies
/// free, between a cylindrical joint, a hinge stated the other way round and a slide; rigid and flexible bodies, the
/// hinge in the tree and cut, coordinates free, sprung and driven. Rows, power, and the wrenches on every body
/// involved.
Sheet check_couplings(const SheetOptions& options);

}  // namespace concord::compare::joint_check
