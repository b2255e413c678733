#include "compare/report/table_parts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "compare/audit/digits.h"
#include "compare/report/text_table.h"
#include "compare/verdict/refinement.h"
#include "compare/verdict/third_words.h"

namespace concord::compare {

namespace {

std::string cuts_of(const SolverSummary& solver) {
  return solver.cut_joints.empty() ? "" : fmt::format("{} cuts {}", solver.name, fmt::join(solver.cut_joints, ", "));
}

/// Whether the model asks something else of a component than the comparator does.
bool changes_needs(const Verdict& verdict) {
  return std::ranges::any_of(verdict.rows, [&](const QuantityRow& row) {
    return row.need.same_state != verdict.need.same_state || row.need.same_run != verdict.need.same_run ||
           row.need.refined != verdict.need.refined;
  });
}

/// A solver that could not evaluate its start has found no rank there.
bool has_rank(const Verdict& verdict, const SolverSummary& solver) {
  return verdict.joints == 0 || !solver.rank.joints.empty();
}

std::string freedom_text(const Verdict& verdict) {
  for (const SolverSummary& solver : verdict.solvers) {
    if (!has_rank(verdict, solver)) continue;
    return fmt::format("{} of which {} modal",
                       plural(solver.rank.degrees_of_freedom, "degree of freedom", "degrees of freedom"),
                       verdict.modes);
  }
  return "degrees of freedom not known";
}

std::string third_table_of(const Model& model, const ThirdReport& third, const std::vector<const ThirdRow*>& rows) {
  std::vector<std::vector<std::string>> lines{{"at the same state", "what", "component", "scale",
                                               "cartesian, " + third.name, "relative, " + third.name,
                                               "cartesian, relative", "need", "off"}};
  for (const ThirdRow* row : rows) {
    lines.push_back(
        {describe_owner(model, row->quantity), word_of(row->quantity.kind), describe_component(row->quantity),
         fmt::format("{:.4g} {}", row->scale, unit_of(model, row->quantity)), third_digits_text(row->shared[0].digits),
         third_digits_text(row->shared[1].digits), third_digits_text(row->between.digits),
         fmt::format("{:g}", row->need), name_of(blame_in(*row), third.name)});
  }
  return format_table(lines, {false, false, false, true, true, true, true, true, false});
}

std::string third_summary_of(const ThirdReport& third) {
  std::string text = fmt::format("{} at {}:", third.name, plural(third.states, "state", "states"));
  const auto add = [&](const char* what, Kind kind) {
    if (const auto digits = third.digits(kind)) text += fmt::format(" {} {},", what, third_digits_text(*digits));
  };
  add("accelerations", Kind::acceleration);
  add("reactions", Kind::reaction);
  add("total wrenches", Kind::total);
  add("coordinate forces", Kind::tau);
  add("couplings", Kind::coupling);
  add("sums on bodies", Kind::body_sum);
  text.back() = ';';
  return text + fmt::format(" digits with both, need {:g}\n", kThirdNeed);
}

std::string runs_and_needs(const Verdict& verdict) {
  std::string text = fmt::format(
      "\n  run: {:g} s, {} samples, rtol {:g}, refined {:g}, {} by {}, {} by {}\n", verdict.run.until,
      verdict.run.samples + 1, verdict.run.rtol, verdict.refined_rtol.value_or(refined_tolerance(verdict.run.rtol)),
      verdict.solvers[0].name, verdict.solvers[0].integrator, verdict.solvers[1].name, verdict.solvers[1].integrator);
  text += fmt::format(
      "  digits needed: same state {:g}, same run {:g}, refined {:g} or {:g} more than the same run, audit {:g}, of "
      "motions {:g}{}\n",
      verdict.need.same_state, verdict.need.same_run, verdict.need.refined, required_rise(verdict), kAudit,
      kAuditByDifferences, changes_needs(verdict) ? "; [[need]] of the model asks otherwise" : "");
  return text;
}

std::string states_and_needs(const Verdict& verdict) {
  return fmt::format(
      "\n  no run: the start, a short step from it, and states drawn near these\n"
      "  digits needed: same state {:g}, audit {:g}, of motions {:g}{}\n",
      verdict.need.same_state, kAudit, kAuditByDifferences,
      changes_needs(verdict) ? "; [[need]] of the model asks otherwise" : "");
}

}  // namespace

std::string table_head(const Verdict& verdict) {
  std::string text = fmt::format("{}: {}, {}, {}", verdict.name, plural(verdict.bodies, "body", "bodies"),
                                 plural(verdict.joints, "joint", "joints"), plural(verdict.loops, "loop", "loops"));
  std::vector<std::string> cuts;
  for (const SolverSummary& solver : verdict.solvers) {
    if (const std::string cut = cuts_of(solver); !cut.empty()) cuts.push_back(cut);
  }
  if (!cuts.empty()) text += fmt::format(" ({})", fmt::join(cuts, "; "));
  text += fmt::format(", {}\n", freedom_text(verdict));
  text += "  constraints at the start:";
  for (std::size_t who = 0; who < 2; ++who) {
    const SolverSummary& solver = verdict.solvers[who];
    text +=
        fmt::format("{} {} {}", who == 0 ? "" : ",", solver.name,
                    has_rank(verdict, solver) ? fmt::format("{} of rank {}", solver.rank.constraints, solver.rank.rank)
                                              : "not known");
  }
  return text + (verdict.integrates ? runs_and_needs(verdict) : states_and_needs(verdict));
}

std::string format_third(const Model& model, const Verdict& verdict, bool all_rows) {
  if (!verdict.third) return "";
  const ThirdReport& third = *verdict.third;
  if (!third.not_expressible.empty()) {
    return fmt::format("{} was not asked: {}\n", third.name, third.not_expressible);
  }
  if (third.states == 0) return "";
  const auto is_shown = [&](const ThirdRow& row) { return all_rows || row.quantity.kind != Kind::body_sum; };
  std::vector<const ThirdRow*> rows;
  if (all_rows) {
    for (const ThirdRow& row : third.rows) rows.push_back(&row);
  } else {
    rows = worst_third_rows(third.rows, is_shown);
  }
  return '\n' + third_table_of(model, third, rows) + '\n' + third_summary_of(third);
}

}  // namespace concord::compare
