#include "compare/page/command.h"

#include <fmt/format.h>

#include "compare/page/machine_data.h"
#include "compare/page/page.h"
#include "compare/report/files.h"
#include "compare/report/result_folder.h"

namespace concord::compare::page {

namespace {

/// Results are not to be lost to a page of theirs.
void require_no_input(const std::filesystem::path& out, const std::filesystem::path& folder) {
  std::error_code unknown;
  for (const auto& entry : std::filesystem::directory_iterator(folder, unknown)) {
    const bool is_result = entry.path().string().ends_with(".result.json") || entry.path().extension() == ".nc";
    if (is_result && is_same_file(out, entry.path())) {
      throw InputError({out.string(), 0, 0}, "cannot be written: it is an input of the page");
    }
  }
}

}  // namespace

int write_report(const ReportCommand& command, const Console& console) {
  return guarded(console, [&] {
    check_target(command.out);
    require_no_input(command.out, command.folder);
    const std::vector<MachineResult> results = read_results(command.folder);
    write_file(command.out, format_page(results));
    console.out << fmt::format("{}: {} {}\n", command.out.string(), results.size(),
                               results.size() == 1 ? "machine" : "machines");
  });
}

}  // namespace concord::compare::page
