#pragma once

#include <optional>
#include <string>
#include <vector>

#include "compare/nightly/history.h"
#include "compare/nightly/suite.h"

namespace concord::compare::nightly {

/// A line of eight heights, the lowest value the lowest; a space where a value is missing. Equal values stand in the
/// middle.
std::string sparkline(const std::vector<std::optional<double>>& values);

/// The trend of a case over nights, the latest first: a table, sparklines, and each step between two nights with the
/// commits before and after. `component`: the numbers of this one alone (its name or a part of it, the first that
/// matches), else the worst digits. Throws InputError if no night has such a component.
std::string format_trend(const std::string& id, std::vector<Entry> nights, const std::string& component,
                         const Judging& judging);

}  // namespace concord::compare::nightly
