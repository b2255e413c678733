#include "compare/nightly/judgement.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

namespace concord::compare::nightly {

Result result_of_case(History& history, long night, const std::string& id) {
  auto result = history.find(night, id);
  if (!result) throw DatabaseError(fmt::format("the history has lost case '{}'", id));
  return std::move(*result);
}

NightReport judge_night(History& history, const Night& night, const std::vector<const Case*>& cases,
                        const Baselines& baselines, const Judging& judging, const std::string& today) {
  NightReport report{night.suite, "concord night", night.origin, night.started, {}, {}, 0};
  report.only = night.only;
  for (const Case* one : cases) {
    const Result result = result_of_case(history, night.id, one->id);
    const auto found = baselines.find(one->id);
    const Result* baseline = found == baselines.end() ? nullptr : &found->second;
    const auto earlier = history.before(night.id, night.suite, one->id, judging.nights);
    CaseLine& line = report.cases.emplace_back(
        case_line_of(result, judge_case(*one, result, baseline, earlier, night.origin, judging, today)));
    const auto counts = [&](const Entry& entry) { return counts_as_past(entry.result, result); };
    line.has_past = (judging.against_baseline && baseline != nullptr) ||
                    (judging.against_median && std::any_of(earlier.begin(), earlier.end(), counts));
  }
  return report;
}

void add_gone(const Suite& suite, const Baselines& baselines, NightReport& report) {
  if (!suite.judging.against_baseline) return;
  std::set<std::string> there;
  for (const Case& one : suite.cases) there.insert(one.id);
  for (const auto& [id, baseline] : baselines) {
    if (there.contains(id)) continue;
    report.others.push_back({ChangeKind::gone, id, "", "case", "in the suite", "not in the suite", "baseline"});
  }
}

}  // namespace concord::compare::nightly
