#include "compare/page/command.h"

#include <fmt/format.h>

#include "compare/page/machine_data.h"
#include "compare/page/page.h"
#include "compare/report/files.h"

namespace concord::compare::page {

int write_report(const ReportCommand& command, const Console& console) {
  return guarded(console, [&] {
    check_target(command.out);
    const std::vector<MachineResult> results = read_results(command.folder);
    write_file(command.out, format_page(results));
    console.out << fmt::format("{}: {} {}\n", command.out.string(), results.size(),
                               results.size() == 1 ? "machine" : "machines");
    return static_cast<int>(kAgree);
  });
}

}  // namespace concord::compare::page
