#include "compare/report/table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "compare/audit/digits.h"
#include "compare/report/force_table.h"
#include "compare/report/redundancy_text.h"
#include "compare/report/start_text.h"
#include "compare/report/table_parts.h"
#include "compare/report/text_table.h"
#include "compare/states/states.h"
#include "compare/verdict/carried.h"
#include "compare/verdict/refinement.h"

namespace concord::compare {

namespace {

/// When the check with the least margin differs most.
std::string worst_time(const QuantityRow& row) {
  const Check check = tightest_check(row);
  if (!row.unique || !digits_of(row, check)) return "-";
  return fmt::format("{:.4g} s, {}", row.worst_t[static_cast<std::size_t>(check)], name_of(check));
}

std::string same_state_cell(const QuantityRow& row) {
  if (!is_judged(row) || !row.same_state) return "-";
  return digits_cell(row.same_state, detail_of(row, Check::same_state).resolvable);
}

/// In how many of the states a row is not unique, in words; empty if in none.
std::string share_not_unique(const CheckDetail& detail) {
  const int all = detail.samples + detail.too_coarse + detail.not_unique;
  if (detail.not_unique == 0) return "";
  return fmt::format("not unique in {} of {} states", detail.not_unique, all);
}

}  // namespace

std::string judgement_text(const QuantityRow& row) {
  const CheckDetail& detail = detail_of(row, Check::same_state);
  if (!row.unique) return "not unique, not judged";
  if (!is_judged(row)) return "not judged: double precision resolves too little";
  std::string said = to_string(row.judgement);
  for (const Check check : kChecks) {
    if (row.judgement == Judgement::not_judged && detail_of(row, check).unconverged) {
      return fmt::format("not judged: not converged ({})", name_of(check));
    }
    if (row.judgement != Judgement::agree || !is_judged_by_resolution(row, check)) continue;
    said += fmt::format(", judged by resolution ({})", name_of(check));
    break;
  }
  if (detail.unresolved) said += ", unresolved";
  if (detail.not_unique > 0) said += ", " + share_not_unique(detail);
  return said;
}

namespace {

std::vector<std::string> cells(const Model& model, const Verdict& verdict, const QuantityRow& row) {
  const auto [owner, body] = owner_names(model, row.quantity);
  const bool judged = is_judged(row);
  const auto shown = [&](const std::optional<double>& digits) { return judged ? digits_cell(digits) : "-"; };
  std::string said = judgement_text(row);
  if (!row.need.because.empty()) said += fmt::format(" (need lowered: {})", row.need.because);
  return {verdict.name,
          owner,
          body,
          describe_component(row.quantity),
          fmt::format("{:.4g} {}", row.scale, unit_of(model, row.quantity)),
          name_of(row.source),
          same_state_cell(row),
          shown(row.same_run),
          shown(row.refined),
          fmt::format("{:g} / {:g} / {:g}", row.need.same_state, row.need.same_run, row.need.refined),
          said,
          worst_time(row)};
}

std::string component_table(const char* owner, const Model& model, const Verdict& verdict,
                            const std::vector<QuantityRow>& rows) {
  if (rows.empty()) return "";
  std::vector<std::vector<std::string>> lines{{"case", owner, "on", "component", "scale", "from", "same state",
                                               "same run", "refined", "need", "verdict", "worst at"}};
  for (const QuantityRow& row : rows) lines.push_back(cells(model, verdict, row));
  return format_table(lines, {false, false, false, false, true, false, true, true, true, false, false, false}) + '\n';
}

/// Every component of joints and of force elements, with the scale that its differences are divided by.
std::string component_tables(const Model& model, const Verdict& verdict) {
  std::vector<QuantityRow> elements;
  std::copy_if(verdict.others.begin(), verdict.others.end(), std::back_inserter(elements),
               [](const QuantityRow& row) { return row.quantity.kind == Kind::element; });
  return component_table("joint", model, verdict, verdict.rows) +
         component_table("force element", model, verdict, elements);
}

/// Worst digits of each kind of the other quantities.
std::string also_compared(const Verdict& verdict, Check check) {
  constexpr std::array kKinds{
      std::pair{Kind::total, "total wrenches"},    std::pair{Kind::reaction_global, "global axes"},
      std::pair{Kind::tau, "coordinate forces"},   std::pair{Kind::share, "shares of them"},
      std::pair{Kind::coupling, "couplings"},      std::pair{Kind::element, "force elements"},
      std::pair{Kind::body_sum, "sums on bodies"}, std::pair{Kind::acceleration, "accelerations"}};
  std::string text;
  for (const auto& [kind, name] : kKinds) {
    std::optional<double> worst;
    for (const QuantityRow& row : verdict.others) {
      const auto digits = digits_of(row, check);
      if (row.quantity.kind == kind && row.unique && digits) worst = std::min(worst.value_or(kMostDigits), *digits);
    }
    if (worst) text += fmt::format("{} {} {}", text.empty() ? "" : ",", name, format_digits(*worst));
  }
  return text;
}

/// Components that are unique in some states only: judged there, and named with their share.
std::string unique_in_part(const Model& model, const Verdict& verdict) {
  std::map<std::string, std::string> components;  // by owner and share
  for (const std::vector<QuantityRow>* rows : {&verdict.rows, &verdict.others}) {
    for (const QuantityRow& row : *rows) {
      const bool is_named = rows == &verdict.rows || is_scalar_force(row.quantity.kind);
      const CheckDetail& detail = detail_of(row, Check::same_state);
      if (!row.unique || !is_named || detail.not_unique == 0) continue;
      components[fmt::format("{}, {}", describe_owner(model, row.quantity), share_not_unique(detail))] +=
          " " + describe_component(row.quantity);
    }
  }
  std::string text;
  for (const auto& [where, names] : components) text += fmt::format("judged where unique: {}:{}\n", where, names);
  return text;
}

}  // namespace

std::string not_unique_text(const Model& model, const Verdict& verdict, bool all_rows) {
  using RowKey = std::tuple<int, int, Kind, Actor>;
  std::map<RowKey, std::string> names;
  for (const std::vector<QuantityRow>* rows : {&verdict.rows, &verdict.others}) {
    for (const QuantityRow& row : *rows) {
      const bool is_named = rows == &verdict.rows || is_scalar_force(row.quantity.kind);
      if (row.unique || !is_named) continue;
      const bool is_reaction = row.quantity.kind == Kind::reaction;
      if (!all_rows && is_reaction && is_across_plane(verdict.planar, row.quantity.owner)) continue;
      std::string& line =
          names[RowKey(row.quantity.owner, index(row.quantity.side), row.quantity.kind, row.quantity.actor)];
      if (line.empty()) line = describe_owner(model, row.quantity) + ":";
      line += " " + describe_component(row.quantity);
    }
  }
  std::string text;
  if (verdict.planar) {
    text += fmt::format("not unique, not judged: {}{}\n", planar_text(model, *verdict.planar),
                        all_rows ? "" : " (--all lists them)");
  }
  for (const auto& [place, line] : names) text += fmt::format("not unique, not judged: {}\n", line);
  return text + unique_in_part(model, verdict) + partly_unique_text(model, verdict) + cures_text(model, verdict.cures);
}

namespace {

std::string vector_text(const Vec3& v) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", v(0), v(1), v(2)); }

}  // namespace

std::string pair_sums_text(const Verdict& verdict) {
  std::string text;
  for (const PairSum& pair : verdict.pair_sums) {
    const std::string digits = pair.samples > 0 ? format_digits(pair.digits) + " digits at the same state"
                                                : std::string("not unique, not judged");
    text += fmt::format("sum of {}: {}; at the first state", pair.what, digits);
    for (std::size_t who = 0; who < 2; ++who) {
      text += fmt::format("{} {} F {} N, T {} N m", who == 0 ? "" : ";", verdict.solvers[who].name,
                          vector_text(pair.at_start[who].force), vector_text(pair.at_start[who].torque));
    }
    text += '\n';
  }
  return text;
}

namespace {

std::string motion_text(const Verdict& verdict) {
  std::string text;
  const auto add = [&](const char* check, const std::optional<MotionAgreement>& motion) {
    if (!motion) return;
    text += fmt::format("{} {} {}", text.empty() ? "motions, digits:" : ",", check, format_digits(motion->digits));
    if (!motion->worst.empty()) text += fmt::format(" ({}, t = {:.4g} s)", motion->worst, motion->t);
  };
  add("same run", verdict.motion);
  add("refined", verdict.refined_motion);
  return text.empty() ? text : text + '\n';
}

std::string check_text(const char* name, const CheckSummary& check) {
  return check.digits ? fmt::format("{} {}", name, format_digits(*check.digits)) : std::string(name);
}

/// With how rows pass it that do not reach their need.
std::string check_text(const Verdict& verdict, Check check) {
  const std::string less = passed_with_less(verdict, check);
  return check_text(name_of(check), summary_of(verdict, check)) + (less.empty() ? "" : fmt::format(" ({})", less));
}

std::string audit_text(const Verdict& verdict) {
  std::string text;
  for (const SolverSummary& solver : verdict.solvers) {
    if (solver.audit_digits) text += fmt::format("audit of {}: {}\n", solver.name, solver.audit_worst);
  }
  std::vector<std::string> errors;
  for (const SolverSummary& solver : verdict.solvers) {
    if (!solver.energy) continue;
    errors.push_back(fmt::format("{} {}", solver.name, drift_text(*solver.energy, verdict.energy_allowed)));
  }
  if (!errors.empty()) text += fmt::format("energy drift: {}\n", fmt::join(errors, "; "));
  return text;
}

std::string reference_table(const Verdict& verdict) {
  if (verdict.references.empty()) return "";
  std::vector<std::vector<std::string>> lines{
      {"against " + verdict.reference_file, "component", "peak", "error", "cartesian off", "relative off", "verdict"}};
  for (const ReferenceRow& row : verdict.references) {
    lines.push_back({row.of, row.component, fmt::format("{:.4g}{}", row.peak, row.unit == "1" ? "" : " " + row.unit),
                     fmt::format("{:.3g}", row.allowed), fmt::format("{:.3g}", row.differences[0]),
                     fmt::format("{:.3g}", row.differences[1]), to_string(row.word)});
  }
  return '\n' + format_table(lines, {false, false, true, true, true, true, false}) + '\n';
}

int count_too_coarse(const Verdict& verdict) {
  return static_cast<int>(std::count_if(verdict.rows.begin(), verdict.rows.end(), [](const QuantityRow& row) {
    return detail_of(row, Check::same_state).too_coarse > 0 && !is_judged(row) && row.unique;
  }));
}

std::string last_line(const Verdict& verdict) {
  std::vector<std::string> passed;
  std::vector<std::string> missed;
  const auto sort = [&](bool is_passed, std::string text) { (is_passed ? passed : missed).push_back(std::move(text)); };
  sort(verdict.rank_agrees, "rank");
  for (const Check check : kChecks) {
    if (check == Check::same_state || verdict.integrates)
      sort(summary_of(verdict, check).passed, check_text(verdict, check));
  }
  sort(verdict.audit.passed, check_text("audit", verdict.audit));
  if (verdict.integrates) sort(keeps_energy(verdict), "energy");
  if (!verdict.references.empty()) sort(agrees_with_reference(verdict), "reference");
  const ComponentCount count = count_components(verdict);
  std::string text = fmt::format("{} {}: {} of {} components judged", to_string(verdict.outcome), verdict.name,
                                 count.judged, count.total);
  if (const std::string instead = judged_instead(verdict); !instead.empty()) text += ": " + instead;
  const int coarse = count_too_coarse(verdict);
  if (coarse > 0) text += fmt::format(" ({} not, because double precision resolves too little)", coarse);
  if (!passed.empty()) text += fmt::format("; passed: {}", fmt::join(passed, ", "));
  // Who agrees all the same has nothing to judge there.
  const char* why = verdict.outcome == Outcome::agree ? "not judged" : "not passed";
  if (!missed.empty()) text += fmt::format("; {}: {}", why, fmt::join(missed, ", "));
  return text + '\n';
}

std::string trouble(const Verdict& verdict, bool all_rows) {
  constexpr std::size_t kShown = 8;
  std::string text;
  for (std::size_t k = 0; k < verdict.findings.size(); ++k) {
    if (k == kShown && !all_rows) {
      text += fmt::format("     and {} more: --all names them\n", verdict.findings.size() - k);
      break;
    }
    const Finding& finding = verdict.findings[k];
    text += fmt::format("FAIL {}: {}\n", verdict.name, finding.what);
    const bool is_last_of_its_kind =
        k + 1 == verdict.findings.size() || verdict.findings[k + 1].symptom != finding.symptom;
    if (is_last_of_its_kind) text += fmt::format("     {}\n", finding.symptom);
  }
  for (const std::string& failure : verdict.failures) text += fmt::format("STOP {}: {}\n", verdict.name, failure);
  return text;
}

}  // namespace

bool agrees_with_reference(const Verdict& verdict) {
  const auto& rows = verdict.references;
  const auto is_equal = [](const ReferenceRow& row) { return row.word == ReferenceWord::equal; };
  return std::any_of(rows.begin(), rows.end(), is_equal) && std::none_of(rows.begin(), rows.end(), is_off);
}

std::string format_verdict(const Model& model, const Verdict& verdict, bool all_rows) {
  std::string text = table_head(verdict) + '\n';
  text += format_forces(model, verdict);
  if (all_rows) text += component_tables(model, verdict);
  if (verdict.start) text += format_start(model, *verdict.start, all_rows) + '\n';
  text += not_unique_text(model, verdict, all_rows) + pair_sums_text(verdict);
  for (const Check check : kChecks) {
    const std::string others = also_compared(verdict, check);
    if (!others.empty()) text += fmt::format("also compared, digits at {}:{}\n", name_of(check), others);
  }
  text += motion_text(verdict) + audit_text(verdict);
  if (verdict.same_state.samples > 0) {
    text += fmt::format("states handed to both: {}, of which {} perturbed with seed {}{}\n", verdict.same_state.samples,
                        kRandomStates, verdict.seed,
                        verdict.drawn_anew > 0 ? fmt::format(", {} drawn anew", verdict.drawn_anew) : "");
  }
  text += reference_table(verdict) + format_third(model, verdict, all_rows);
  for (const std::string& note : verdict.notes) text += fmt::format("note: {}\n", note);
  return text + trouble(verdict, all_rows) + last_line(verdict);
}

}  // namespace concord::compare
