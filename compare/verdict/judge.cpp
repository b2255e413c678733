#include "compare/verdict/judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "compare/audit/digits.h"
#include "compare/quantities/needs.h"
#include "compare/verdict/findings.h"

namespace concord::compare {

Judge::Judge(const QuantityLayout& layout, std::vector<Check> checks, Verdict& verdict)
    : layout_(layout), checks_(std::move(checks)), verdict_(verdict) {}

void Judge::describe(const std::array<Solver*, 2>& solvers) {
  const Model& model = layout_.model();
  verdict_.name = model.name;
  verdict_.bodies = static_cast<int>(model.bodies.size()) - 1;
  verdict_.joints = static_cast<int>(model.joints.size());
  verdict_.loops = verdict_.joints - verdict_.bodies;
  for (const Body& body : model.bodies) verdict_.modes += body.n_modes();
  verdict_.need = default_needs(model);
  for (std::size_t who = 0; who < solvers.size(); ++who) verdict_.solvers[who].name = solvers[who]->name();
}

std::vector<Measured> Judge::measure_check(const Series& series, const Budget& budget, Check check) {
  std::vector<Measured> measured = measure(layout_, series, budget);
  record(layout_, measured, check, verdict_);
  return measured;
}

void Judge::find_differences_on(const Series& series, const std::vector<Measured>& measured, Check check) {
  std::vector<Finding> found = find_differences(layout_, series, measured, verdict_, check, known_);
  std::move(found.begin(), found.end(), std::back_inserter(verdict_.findings));
}

void Judge::judge_uniqueness(WeighedStates& weighed) {
  if (!weighed.dropped.empty()) verdict_.failures.push_back(weighed.dropped);
  if (weighed.beside_singular > 0) {
    verdict_.notes.push_back(fmt::format("{} perturbed state{} closed beside a singular pose and {} left out",
                                         weighed.beside_singular, weighed.beside_singular == 1 ? "" : "s",
                                         weighed.beside_singular == 1 ? "was" : "were"));
  }
  verdict_.rank_agrees = weighed.findings.empty() && !weighed.reports.empty();
  std::move(weighed.findings.begin(), weighed.findings.end(), std::back_inserter(verdict_.findings));
  weighed.findings.clear();
}

void Judge::note_singular_states(const WeighedStates& weighed) {
  const std::vector<std::string>& singular = weighed.singular;
  const auto is_singular = [](const std::string& why) { return !why.empty(); };
  const auto first = std::find_if(singular.begin(), singular.end(), is_singular);
  if (first == singular.end()) return;
  verdict_.singular_states += static_cast<int>(std::count_if(first, singular.end(), is_singular));
  verdict_.failures.push_back(*first);
}

void Judge::judge_audit(Who who, const AuditReport& found) {
  if (found.states == 0) return;
  SolverSummary& summary = verdict_.solvers[index(who)];
  summary.audit_digits = found.digits();
  summary.audit_worst = found.worst.text();
  summary.audit_need = need_of(found.worst.rule);
  verdict_.audit.digits = std::min(verdict_.audit.digits.value_or(kMostDigits), found.digits());
  verdict_.audit.samples = static_cast<int>(found.states);
  if (found.holds()) return;
  verdict_.findings.push_back({fmt::format("{} {}: {} (need {:g})", summary.name, breach_of(found.worst.rule),
                                           summary.audit_worst, summary.audit_need),
                               "audit: from motions, wrenches, force laws and mass points alone; look into this solver "
                               "first"});
}

void Judge::judge_start(Who who, const KeptStart& found) {
  if (found.holds()) return;
  verdict_.findings.push_back({fmt::format("{} {}", verdict_.solvers[index(who)].name, found.text()),
                               "start: what the model keeps and drives; all later samples follow from it"});
}

void Judge::judge_reported(Who who, const ReportedCoordinate& found) {
  if (found.holds()) return;
  SolverSummary& summary = verdict_.solvers[index(who)];
  verdict_.audit.digits = std::min(verdict_.audit.digits.value_or(kMostDigits), found.digits);
  if (summary.audit_digits.value_or(kMostDigits) >= summary.audit_need) {
    summary.audit_digits = found.digits;
    summary.audit_worst = found.text();
    summary.audit_need = kAudit;
  }
  verdict_.findings.push_back({fmt::format("{} {}", summary.name, found.text()),
                               "audit: joint coordinates and speeds read from the bodies; the wrenches may be right"});
}

void Judge::judge_rows() {
  judge(verdict_, checks_);
  verdict_.audit.passed = std::all_of(
      verdict_.solvers.begin(), verdict_.solvers.end(),
      [](const SolverSummary& solver) { return solver.audit_digits && *solver.audit_digits >= solver.audit_need; });
}

void conclude(Verdict& verdict) {
  leave_out_repeated(verdict.failures);
  if (!verdict.failures.empty()) {
    verdict.outcome = Outcome::failed;
  } else {
    verdict.outcome = verdict.findings.empty() ? Outcome::agree : Outcome::differ;
  }
}

void require_passed_checks(Verdict& verdict) {
  if (verdict.outcome != Outcome::agree) return;
  const auto require = [&](bool is_passed, const char* check) {
    if (is_passed) return;
    verdict.failures.push_back(fmt::format(
        "{} is not passed, and nothing was found to differ there: a fault of the comparator, not of the model", check));
  };
  const auto passes = [](const CheckSummary& check) { return check.passed || !check.digits; };
  require(verdict.rank_agrees, "rank");
  require(passes(verdict.same_state), "same state");
  require(passes(verdict.same_run), "same run");
  require(passes(verdict.refined), "refined");
  require(verdict.audit.passed, "audit");
  if (verdict.integrates) require(keeps_energy(verdict), "energy");
  conclude(verdict);
}

}  // namespace concord::compare
