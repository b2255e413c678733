#pragma once

#include <string>
#include <vector>

#include "common/model.h"
#include "compare/report/reported_case.h"
#include "compare/verdict/verdict.h"

namespace concord::compare {

/// Version of the document below; another one is refused by whoever reads it.
inline constexpr int kVerdictFormat = 1;

/// The verdict on one model as JSON text, indented, ending with a line feed. Keys: compare/report/README. Digits have
/// two decimals, rounded down, and are null where a check did not run or did not judge; everything but `wall_s` is the
/// same from run to run.
std::string format_json(const Model& model, const Verdict& verdict);

/// The same of a case; without a verdict an empty one that says why there is none: "failed", or "bad input".
std::string format_json(const ReportedCase& one);

/// The same for several models: an object with one member for each case, by name.
std::string format_json(const std::vector<ReportedCase>& cases);

}  // namespace concord::compare
