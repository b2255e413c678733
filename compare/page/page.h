#pragma once

#include <string>
#include <vector>

#include "compare/page/machine_data.h"
#include "compare/report/reported_case.h"

/// A report as one HTML page that needs nothing else: no network, no other file.
namespace concord::compare::page {

/// The page of models that were compared just now. Curves are thinned until all of them have about 2.5 MB.
std::string format_page(const std::vector<ReportedCase>& cases);

/// The page of results that stand in a folder.
std::string format_page(const std::vector<MachineResult>& results);

}  // namespace concord::compare::page
