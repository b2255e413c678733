#include "compare/report/table_head.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "compare/audit/digits.h"
#include "compare/report/text_table.h"
#include "compare/verdict/refinement.h"

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
  text += fmt::format("\n  run: {:g} s, {} samples, rtol {:g}, refined {:g}, {} by {}, {} by {}\n", verdict.run.until,
                      verdict.run.samples + 1, verdict.run.rtol, refined_tolerance(verdict.run.rtol),
                      verdict.solvers[0].name, verdict.solvers[0].integrator, verdict.solvers[1].name,
                      verdict.solvers[1].integrator);
  text += fmt::format(
      "  digits needed: same state {:g}, same run {:g}, refined {:g} or {:g} more than the same run, audit {:g}, of "
      "motions {:g}{}\n",
      verdict.need.same_state, verdict.need.same_run, verdict.need.refined, kRefinedRise, kAudit, kAuditByDifferences,
      changes_needs(verdict) ? "; [[need]] of the model asks otherwise" : "");
  return text;
}

}  // namespace concord::compare
