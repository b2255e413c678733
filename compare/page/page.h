#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "compare/page/machine_data.h"
#include "compare/report/console.h"
#include "compare/report/reported_case.h"

/// A report as one HTML page that needs nothing else: no network, no other file.
namespace concord::compare::page {

/// The page of models that were compared just now. Curves are thinned until all of them have about 2.5 MB.
std::string format_page(const std::vector<ReportedCase>& cases);

/// The page of results that stand in a folder.
std::string format_page(const std::vector<MachineResult>& results);

/// `concord report`.
struct ReportCommand {
  std::filesystem::path folder;  // that `concord compare --out` wrote
  std::filesystem::path out;     // the page
};

/// Writes the page of all results in a folder; returns the exit code. Nothing is judged anew.
int write_report(const ReportCommand& command, const Console& console);

}  // namespace concord::compare::page
