#include "compare/page/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "compare/page/fill.h"
#include "compare/report/files.h"
#include "compare/report/result_document.h"
#include "compare/report/result_folder.h"

namespace concord::compare::page {

namespace {

using PageJson = nlohmann::ordered_json;

constexpr std::size_t kBytesOfCurves = 2500000;
constexpr std::size_t kLeastBytes = 60000;  // of one machine

std::size_t bytes_for_each(std::size_t machines) {
  return std::max(kLeastBytes, kBytesOfCurves / std::max<std::size_t>(1, machines));
}

PageJson without_result(const ReportedCase& one) {
  std::string words = one.trouble;
  while (!words.empty() && words.back() == '\n') words.pop_back();
  return {{"model", one.name},
          {"outcome", one.is_bad_input ? "bad input" : "failed"},
          {"sentence", fmt::format("There is no verdict: {}", words)}};
}

MachineResult result_of(const ReportedCase& one) {
  MachineResult result;
  result.document = format_result(*one.model, *one.verdict);
  for (std::size_t who = 0; who < 2; ++who) {
    const auto& run = one.verdict->trajectories[who];
    if (run) result.runs[who] = curves_of(*one.model, one.verdict->solvers[who].name, *run);
  }
  return result;
}

std::string title_of(const PageJson& machines) {
  if (machines.size() != 1) return fmt::format("concord: {} machines", machines.size());
  return fmt::format("concord: {}, {}", machines[0]["model"].get<std::string>(),
                     machines[0]["outcome"].get<std::string>());
}

std::string format(PageJson machines) {
  const std::string title = title_of(machines);
  return fill_page(machine_parts(), title, {{"made", made_words()}, {"machines", std::move(machines)}});
}

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

std::string format_page(const std::vector<ReportedCase>& cases) {
  PageJson machines = PageJson::array();
  for (const ReportedCase& one : cases) {
    const bool is_there = one.model != nullptr && one.verdict != nullptr;
    machines.push_back(is_there ? machine_data(result_of(one), bytes_for_each(cases.size())) : without_result(one));
  }
  return format(std::move(machines));
}

std::string format_page(const std::vector<MachineResult>& results) {
  PageJson machines = PageJson::array();
  for (const MachineResult& result : results) machines.push_back(machine_data(result, bytes_for_each(results.size())));
  return format(std::move(machines));
}

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
