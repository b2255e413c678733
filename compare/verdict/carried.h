#pragma once

#include <string>

#include "compare/verdict/refinement.h"
#include "compare/verdict/verdict.h"

/// What carried a verdict that was not reached by every single component with all the digits that it needs, in few
/// words: for its last line and for reports.
namespace concord::compare {

/// How judged rows pass a check with fewer digits than the comparator asks for, or without any, each way with the
/// number of its rows: "2 of 36 below 7 digits, within round-off"; and up to which time it is judged, if not to the
/// end. Empty where all rows that give the check its digits reach their needs, and where the check was not passed.
std::string passed_with_less(const Verdict& verdict, Check check);

/// What is judged where no component of a joint or force element is: "no single component is unique; judged instead:
/// 4 totals of joints that share what they carry". Empty where some component is judged, and where there is no verdict.
std::string judged_instead(const Verdict& verdict);

}  // namespace concord::compare
