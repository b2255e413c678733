#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "compare/nightly/result.h"
#include "compare/report/origin.h"

/// Accepted results as text that is kept in version control beside the suite. Holds no time, host or folder: the same
/// results give the same bytes.
namespace concord::compare::nightly {

/// By the name of the case. Digits and peaks are rounded; needs, words and times are not kept.
using Baselines = std::map<std::string, Result, std::less<>>;

std::string format_baselines(const Baselines& baselines);

/// Throws InputError at the line that is wrong; a version that is not known is refused by name.
Baselines parse_baselines(std::string_view text, const std::string& file);

/// What stands in the file; nothing if there is no file.
Baselines read_baselines(const std::filesystem::path& file);

/// Where it is written down who accepted what, and why: beside the baselines.
std::filesystem::path log_of(const std::filesystem::path& baselines);

/// Adds to log_of(baselines) that now this program's results were accepted, for this reason, with these lines of what
/// changed.
void write_down(const std::filesystem::path& baselines, const Origin& origin, const std::string& reason,
                const std::string& changes);

/// What a baseline keeps of a result.
Result as_baseline(const Result& result);

/// The fields of a line of comma-separated values, quoted where they must be; and back. Nothing if a quote is not
/// closed.
std::string format_fields(const std::vector<std::string>& fields);
std::optional<std::vector<std::string>> split_fields(std::string_view line);

}  // namespace concord::compare::nightly
