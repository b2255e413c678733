#pragma once

#include <string>
#include <vector>

#include "compare/report/reported_case.h"

namespace concord::compare {

/// Text for an attribute or an element; control characters, which XML 1.0 cannot hold, become spaces.
std::string escape_xml(const std::string& text);

/// JUnit XML: a test suite for each model; in it a test case for each judged row, for each reference column, and for
/// rank, audit and energy of each solver, a failed one with its digits and need; what stood in the way of a verdict is
/// an error. Names are escaped. Holds no wall time: the same results give the same bytes.
std::string format_junit(const std::vector<ReportedCase>& cases);

}  // namespace concord::compare
