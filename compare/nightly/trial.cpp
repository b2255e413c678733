#include "compare/nightly/trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "common/joints/catalogue.h"
#include "compare/analyses/judge.h"
#include "compare/equilibrium/started_machine.h"
#include "compare/invariance/report.h"
#include "compare/joint_check/coupling_check.h"
#include "compare/nightly/case_model.h"
#include "compare/page/page.h"
#include "compare/random_machines/generator.h"
#include "compare/random_machines/trial.h"
#include "compare/report/files.h"
#include "compare/report/start_text.h"
#include "compare/states/near_frames.h"
#include "compare/verdict/refinement.h"

namespace concord::compare::nightly {

namespace {

void tell_stage(std::string_view stage) {
  std::fprintf(stderr, "stage: %.*s\n", static_cast<int>(stage.size()), stage.data());
}

/// What is recorded of each component; of other kinds only the worst of a kind.
bool is_told(const QuantityRow& row) {
  const Kind kind = row.quantity.kind;
  return kind == Kind::reaction || is_scalar_force(kind) || kind == Kind::element;
}

std::string name_of_kind(Kind kind) {
  switch (kind) {
    case Kind::reaction_global:
      return "all reactions in global axes";
    case Kind::total:
      return "all total wrenches";
    case Kind::acceleration:
      return "all accelerations";
    default:
      return "all sums on bodies";
  }
}

void take_worse(std::optional<double>& worst, const std::optional<double>& digits) {
  if (digits && (!worst || *digits < *worst)) worst = digits;
}

Component component_of(const Model& model, const QuantityRow& row, const VecX& peaks, const QuantityLayout& layout) {
  Component one;
  one.name = fmt::format("{}, {}", describe_owner(model, row.quantity), describe_component(row.quantity));
  one.same_state = row.same_state;
  one.resolvable = detail_of(row, Check::same_state).resolvable;
  one.same_run = row.same_run;
  one.refined = row.refined;
  one.need = {row.need.same_state, row.need.same_run, row.need.refined};
  if (peaks.size() > 0) one.peak = peaks(layout.row_of(row.quantity));
  one.scale = row.scale;
  return one;
}

/// Largest sizes along a run, by row of the layout; of a single sample, as analyses have it, the numbers themselves
/// with their signs; empty if there is none.
VecX peaks_of(const QuantityLayout& layout, const Verdict& verdict) {
  const auto& run = verdict.trajectories[1] ? verdict.trajectories[1] : verdict.trajectories[0];
  VecX peaks;
  if (!run) return peaks;
  if (run->samples.size() == 1) return layout.observe(run->samples.front().state, run->samples.front().evaluation);
  for (const Sample& sample : run->samples) {
    const VecX sizes = layout.observe(sample.state, sample.evaluation).cwiseAbs();
    peaks = peaks.size() == 0 ? sizes : VecX(peaks.cwiseMax(sizes));
  }
  return peaks;
}

void add_components(const Model& model, const Verdict& verdict, std::vector<Component>& components) {
  const QuantityLayout layout(model);
  const VecX peaks = peaks_of(layout, verdict);
  std::map<Kind, Component> worst;
  for (const auto* rows : {&verdict.rows, &verdict.others}) {
    for (const QuantityRow& row : *rows) {
      if (!is_judged(row)) continue;
      if (is_told(row)) {
        components.push_back(component_of(model, row, peaks, layout));
        continue;
      }
      Component& all = worst.try_emplace(row.quantity.kind, component_of(model, row, {}, layout)).first->second;
      all.name = name_of_kind(row.quantity.kind);
      take_worse(all.same_state, row.same_state);
      take_worse(all.resolvable, detail_of(row, Check::same_state).resolvable);
      take_worse(all.same_run, row.same_run);
      take_worse(all.refined, row.refined);
    }
  }
  for (auto& [kind, component] : worst) components.push_back(std::move(component));
  for (const SolverSummary& solver : verdict.solvers) {
    if (!solver.audit_digits) continue;
    Component& audit = components.emplace_back();
    audit.name = "audit of " + solver.name;
    audit.same_state = solver.audit_digits;
    audit.need[0] = solver.audit_need;
  }
}

std::string words_of(const Verdict& verdict) {
  constexpr std::size_t kMost = 5;
  std::string text;
  std::size_t told = 0;
  const auto tell = [&](const std::string& line) {
    if (++told <= kMost) text += (text.empty() ? "" : "\n") + line;
  };
  for (const Finding& finding : verdict.findings) tell(fmt::format("{}: {}", finding.what, finding.symptom));
  for (const std::string& failure : verdict.failures) tell(failure);
  if (told > kMost) text += fmt::format("\nand {} more", told - kMost);
  if (verdict.attribution) text += fmt::format("\nto blame: {}", describe(*verdict.attribution));
  if (verdict.outcome == Outcome::agree && verdict.same_run.horizon) {
    text = fmt::format("judged up to t = {:.4g} s of {:g} s: the motion is too sensitive beyond",
                       *verdict.same_run.horizon, verdict.run.until);
  }
  return text;
}

Ending ending_of_outcome(Outcome outcome) {
  switch (outcome) {
    case Outcome::agree:
      return Ending::agree;
    case Outcome::differ:
      return Ending::differ;
    default:
      return Ending::failed;
  }
}

void take_verdict(const Model& model, const Verdict& verdict, Result& result) {
  result.ending = ending_of_outcome(verdict.outcome);
  result.words = words_of(verdict);
  const ComponentCount count = count_components(verdict);
  result.judged = count.judged;
  result.total = count.total;
  for (std::size_t who = 0; who < 2; ++who) {
    const SolverSummary& solver = verdict.solvers[who];
    result.cost[who] = {solver.integrator, solver.statistics.steps, solver.statistics.evaluations};
  }
  add_components(model, verdict, result.components);
}

void check_integrators(const Case& one, const StartedMachine& machine) {
  for (const Who who : kBothSolvers) {
    try {
      chosen_integrator(machine.model(), machine.solver(who), one.options.integrators[index(who)]);
    } catch (const InputError& error) {
      throw refusal(one, error.diagnostics().front().message);
    }
  }
}

void compare_case(const Case& one, const SolverMakers& makers, const std::filesystem::path& page, Result& result) {
  const StartedMachine machine(model_of(one), makers);
  check_integrators(one, machine);
  VerifyOptions options = one.options;
  options.makers = &makers;
  options.progress = [last = std::string()](std::string_view check, const auto&) mutable {
    if (check != last) tell_stage(last = check);
  };
  Verdict verdict = verify(machine.model(), machine.solver(Who::cartesian), machine.solver(Who::relative), options);
  verdict.trajectories = machine.back(std::move(verdict.trajectories));
  take_verdict(machine.model(), verdict, result);
  const bool is_shown = !page.empty() && verdict.outcome != Outcome::agree;
  if (is_shown) write_file(page, page::format_page({{one.id, &machine.model(), &verdict, ""}}));
  if (!result.is_green() || !result.words.empty()) return;
  const auto found = start_of(machine.model(), machine, makers, SeekPoses::of_few_joints);
  if (found) result.words = poses_line(machine.model(), *found);
}

/// Numbers of an analysis keep their signs. Where they have no scale of their own, it is the largest of their unit.
void add_numbers(const std::vector<analyses::NumberRow>& numbers, std::vector<Component>& components) {
  std::map<std::string, double> scales;
  for (const analyses::NumberRow& row : numbers) {
    for (const double value : row.values) {
      if (std::isfinite(value)) scales[row.unit] = std::max(scales[row.unit], std::abs(value));
    }
  }
  for (const analyses::NumberRow& row : numbers) {
    Component& one = components.emplace_back();
    one.name = row.name;
    one.same_run = row.digits;
    one.need[1] = row.need;
    if (std::isfinite(row.values[1])) one.peak = row.values[1];
    one.scale = row.scale.value_or(scales[row.unit]);
  }
}

void analyse_case(const Case& one, const SolverMakers& makers, Result& result) {
  const NearFrames near(model_of(one));
  const Model& model = near.model();
  analyses::AnalysisVerdict found;
  switch (one.work) {
    case Work::statics:
      found = analyses::judge_statics(model, makers);
      break;
    case Work::linearize:
      found = analyses::judge_linearization(model, makers, one.at_equilibrium);
      break;
    case Work::kinematics:
      found = analyses::judge_kinematics(model, makers, one.options);
      break;
    default:
      found = analyses::judge_inverse(model, makers, one.accelerations);
  }
  found.wrenches.trajectories = near.back(std::move(found.wrenches.trajectories));
  take_verdict(found.machine ? *found.machine : model, found.wrenches, result);
  add_numbers(found.numbers, result.components);
}

void check_joint_case(const Case& one, Result& result) {
  joint_check::SheetOptions options;
  for (int k = 0; k < one.poses; ++k) options.poses.push_back(k);
  const joint_check::Sheet sheet = one.joint == joint_check::kCouplings
                                       ? joint_check::check_couplings(options)
                                       : joint_check::check_joint(*joints::find(one.joint), options);
  result.ending = sheet.holds() ? Ending::agree : Ending::differ;
  result.judged = sheet.held();
  result.total = sheet.looked();
  for (const joint_check::Property& property : sheet.properties) {
    if (!property.looked) continue;
    if (!property.holds() && result.words.empty()) result.words = fmt::format("{}: {}", property.name, property.where);
    if (!property.need) continue;
    Component& component = result.components.emplace_back();
    component.name = property.name;
    component.same_state = property.digits;
    component.need[0] = *property.need;
  }
  if (!sheet.holds() && result.words.empty()) result.words = "the wrenches differ in some rig";
}

/// A component for each move and solver.
void invariance_case(const Case& one, const SolverMakers& makers, Result& result) {
  std::string note;
  const Model model = as_it_starts(NearFrames(model_of(one)).model(), makers, note);
  tell_stage("moves");
  invariance::InvarianceOptions options;
  options.until = one.options.until;
  const invariance::InvarianceChecks checks = invariance::check_invariance(model, makers, options);
  result.ending = ending_of_outcome(checks.outcome);
  for (const std::string& finding : invariance::findings_of(model, checks)) {
    result.words += (result.words.empty() ? "" : "\n") + finding;
  }
  for (const invariance::MoveRow& row : checks.rows) {
    if (!row.applies) continue;
    result.judged += row.judged;
    result.total += row.total;
    if (!row.nearest) continue;
    Component& component = result.components.emplace_back();
    component.name =
        fmt::format("{}, {}", checks.moves[row.move].name, kSolverNames[static_cast<std::size_t>(index(row.who))]);
    component.same_state = row.nearest->measured.digits;
    component.resolvable = row.nearest->resolvable();
    component.need[0] = invariance::kNeed;
    component.scale = row.nearest->measured.scale;
  }
}

void fuzz_case(const Case& one, const std::filesystem::path& scratch, const SolverMakers& makers, Result& result) {
  const auto& styles = fuzz::style_names();
  const auto style = static_cast<fuzz::Style>(std::find(styles.begin(), styles.end(), one.fuzz.style) - styles.begin());
  result.ending = Ending::agree;
  result.total = static_cast<int>(one.fuzz.count);
  long regular = 0;
  long refused = 0;
  for (std::uint64_t k = one.fuzz.first; k < one.fuzz.first + one.fuzz.count; ++k) {
    tell_stage(fmt::format("machine {} of seed {}, style {}", k, one.fuzz.seed, one.fuzz.style));
    const fuzz::Machine machine = fuzz::draw_machine(one.fuzz.seed, k, style);
    const fuzz::Outcome outcome = fuzz::try_machine(fuzz::write_machine(machine), scratch, makers);
    if (outcome.sort == fuzz::Sort::agree) ++result.judged;
    if (machine.should_be_judged()) {
      ++regular;
      if (outcome.sort == fuzz::Sort::refusal) ++refused;
    }
    if (!outcome.is_wrong()) continue;
    result.ending = Ending::differ;
    if (result.words.size() < 2000) {
      result.words += fmt::format("{}machine {}: {}", result.words.empty() ? "" : "\n", k, outcome.kind);
    }
  }
  if (result.judged == 0 && result.ending == Ending::agree) {
    result.ending = Ending::failed;
    result.words = "none of the machines was judged";
  }
  if (result.ending == Ending::agree && fuzz::refuses_too_many(regular, refused)) {
    result.ending = Ending::differ;
    result.words =
        fmt::format("{} of {} regular machines are refused, where sound solvers refuse about 1 %", refused, regular);
  }
}

void do_work(const Case& one, const std::filesystem::path& scratch, const SolverMakers& makers,
             const std::filesystem::path& page, Result& result) {
  switch (one.work) {
    case Work::compare:
      return compare_case(one, makers, page, result);
    case Work::joint:
      return check_joint_case(one, result);
    case Work::fuzz:
      return fuzz_case(one, scratch, makers, result);
    case Work::invariance:
      return invariance_case(one, makers, result);
    default:
      return analyse_case(one, makers, result);
  }
}

}  // namespace

Result try_case(const Case& one, const std::filesystem::path& scratch, const SolverMakers& makers,
                const std::filesystem::path& page) {
  Result result;
  result.id = one.id;
  result.work = name_of(one.work);
  tell_stage("reading");
  try {
    do_work(one, scratch, makers, page, result);
  } catch (const InputError& error) {
    result.ending = Ending::bad_input;
    result.words = error.what();
  } catch (const SolverError& error) {
    result.ending = Ending::failed;
    result.words = error.what();
  }
  put_in_order(result.components);
  return result;
}

}  // namespace concord::compare::nightly
