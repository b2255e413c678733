#pragma once

#include <filesystem>

#include "compare/report/console.h"

namespace concord::compare::page {

/// `concord report`.
struct ReportCommand {
  std::filesystem::path folder;  // that `concord compare --out` wrote
  std::filesystem::path out;     // the page
};

/// Writes the page of all results in a folder; returns the exit code. Nothing is judged anew.
int write_report(const ReportCommand& command, const Console& console);

}  // namespace concord::compare::page
