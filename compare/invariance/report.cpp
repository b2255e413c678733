#include "compare/invariance/report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "compare/audit/digits.h"
#include "compare/quantities/align.h"
#include "compare/report/explanations.h"
#include "compare/report/text_table.h"

namespace concord::compare::invariance {

namespace {

using Object = nlohmann::ordered_json;

constexpr int kFormatOfChecks = 1;

std::string solver_name(const MoveRow& row) { return kSolverNames[static_cast<std::size_t>(index(row.who))]; }

std::string verdict_of(const MoveSummary& move, const MoveRow& row) {
  if (!row.applies)
    return move.why_not.empty() ? "does not apply: the solver cuts no joint" : "does not apply: " + move.why_not;
  if (row.outcome == Outcome::failed) return "no verdict";
  std::string said = to_string(row.outcome);
  if (row.outcome == Outcome::agree && row.nearest->measured.digits < kNeed) said += ", judged by resolution";
  return said;
}

std::vector<std::string> cells(const Model& model, const MoveSummary& move, const MoveRow& row) {
  const std::string said = verdict_of(move, row);
  if (!row.applies || !row.nearest) return {move.name, solver_name(row), "-", "-", "-", "-", said};
  const Nearest& nearest = *row.nearest;
  const std::string of = describe_owner(model, nearest.quantity);
  return {move.name,
          solver_name(row),
          nearest.variant.empty() ? of : fmt::format("{}, {}", of, nearest.variant),
          describe_component(nearest.quantity),
          format_nearest(nearest),
          format_digits(row.start.digits),
          said};
}

std::string difference_text(const Model& model, const MoveSummary& move, const MoveRow& row) {
  const Nearest& nearest = *row.nearest;
  const Measured& measured = nearest.measured;
  return fmt::format(
      "{}{}, {}: {}, {}, t = {:.6g} s: {:+.6g} as the model says it, {:+.6g} {} in the other description, "
      "{} digits (need {:g})",
      move.name, nearest.variant.empty() ? "" : ", " + nearest.variant, solver_name(row),
      describe_owner(model, nearest.quantity), describe_component(nearest.quantity), measured.t, measured.values[0],
      measured.values[1], unit_of(model, nearest.quantity), format_digits(measured.unexplained_digits), kNeed);
}

Object row_object(const Model& model, const MoveRow& row) {
  Object found{{"solver", solver_name(row)}, {"applies", row.applies}};
  if (!row.applies) return found;
  found["verdict"] = to_string(row.outcome);
  found["judged"] = row.judged;
  found["total"] = row.total;
  found["start_digits"] = digits_json(row.start.digits);
  if (row.nearest) {
    const Nearest& nearest = *row.nearest;
    found["digits"] = digits_json(nearest.measured.digits);
    found["resolvable_digits"] = digits_json(nearest.resolvable());
    found["judged_by_resolution"] = nearest.measured.digits < kNeed && nearest.measured.unexplained_digits >= kNeed;
    found["nearest"] = {{"of", describe_owner(model, nearest.quantity)},
                        {"component", describe_component(nearest.quantity)},
                        {"description", nearest.variant},
                        {"t", nearest.measured.t},
                        {"scale", nearest.measured.scale},
                        {"values", nearest.measured.values}};
  }
  found["words"] = row.words;
  return found;
}

Object object_of(const Model& model, const InvarianceChecks& checks) {
  Object moves = Object::array();
  for (std::size_t k = 0; k < checks.moves.size(); ++k) {
    const MoveSummary& move = checks.moves[k];
    Object rows = Object::array();
    for (const MoveRow& row : checks.rows) {
      if (row.move == k) rows.push_back(row_object(model, row));
    }
    moves.push_back({{"move", move.name},
                     {"about", move.about},
                     {"applies", move.why_not.empty()},
                     {"why_not", move.why_not},
                     {"descriptions", move.variants},
                     {"left_as_it_is", move.left},
                     {"solvers", std::move(rows)}});
  }
  return {{"format", kFormatOfChecks},
          {"kind", "concord invariance"},
          {"model", checks.name},
          {"verdict", to_string(checks.outcome)},
          {"need", kNeed},
          {"states", {{"run", checks.run_states}, {"random", checks.random_states}}},
          {"moves", std::move(moves)},
          {"notes", checks.notes},
          {"findings", findings_of(model, checks)}};
}

std::string last_line(const InvarianceChecks& checks) {
  const auto applied = std::count_if(checks.moves.begin(), checks.moves.end(),
                                     [](const MoveSummary& move) { return move.why_not.empty(); });
  std::string text =
      fmt::format("{} {}: {} of {} moves apply", to_string(checks.outcome), checks.name, applied, checks.moves.size());
  if (const MoveRow* row = nearest_row(checks)) {
    text += fmt::format("; nearest {} ({}, {})", format_nearest(*row->nearest), checks.moves[row->move].name,
                        solver_name(*row));
  }
  return text + '\n';
}

}  // namespace

std::string format_nearest(const Nearest& nearest) {
  return digits_cell(nearest.measured.digits, nearest.resolvable());
}

const MoveRow* nearest_row(const InvarianceChecks& checks) {
  const MoveRow* found = nullptr;
  for (const MoveRow& row : checks.rows) {
    if (!row.nearest) continue;
    if (found == nullptr || is_nearer(row.nearest->measured, found->nearest->measured)) found = &row;
  }
  return found;
}

std::vector<std::string> findings_of(const Model& model, const InvarianceChecks& checks) {
  std::vector<std::string> findings = checks.failures;
  for (const MoveRow& row : checks.rows) {
    const MoveSummary& move = checks.moves[row.move];
    for (const std::string& words : row.words) {
      findings.push_back(fmt::format("{}, {}: {}", move.name, solver_name(row), words));
    }
    if (row.applies && row.start.digits < kNeed) {
      findings.push_back(fmt::format("{}, {}: the start is another one: {}, {} digits (need {:g})", move.name,
                                     solver_name(row), row.start.worst, format_digits(row.start.digits), kNeed));
    }
    if (row.nearest && row.nearest->measured.unexplained_digits < kNeed) {
      findings.push_back(difference_text(model, move, row));
    }
  }
  return findings;
}

std::string format_checks(const Model& model, const InvarianceChecks& checks) {
  std::string text = fmt::format(
      "{}: each solver against itself, at {} states of a run and {} near them; need: {:g} digits, or all that double "
      "precision resolves\n\n",
      checks.name, checks.run_states, checks.random_states, kNeed);
  std::vector<std::vector<std::string>> lines{{"move", "solver", "nearest", "component", "digits", "start", "verdict"}};
  for (const MoveRow& row : checks.rows) lines.push_back(cells(model, checks.moves[row.move], row));
  if (lines.size() > 1) text += format_table(lines, {false, false, false, false, true, true, false}) + '\n';
  for (const MoveSummary& move : checks.moves) {
    if (!move.why_not.empty() || move.left.empty()) continue;
    text += fmt::format("{} leaves as they are: {}\n", move.name, fmt::join(move.left, "; "));
  }
  for (const std::string& note : checks.notes) text += fmt::format("note: {}\n", note);
  for (const std::string& finding : findings_of(model, checks)) {
    text += fmt::format("{} {}: {}\n", checks.outcome == Outcome::failed ? "STOP" : "FAIL", checks.name, finding);
  }
  return text + last_line(checks);
}

std::string format_checks_json(const std::vector<std::pair<const Model*, const InvarianceChecks*>>& all_checks,
                               bool several_asked) {
  if (!several_asked) return object_of(*all_checks.front().first, *all_checks.front().second).dump(2) + '\n';
  Object all = Object::object();
  for (const auto& [model, checks] : all_checks) all[checks->name] = object_of(*model, *checks);
  return all.dump(2) + '\n';
}

}  // namespace concord::compare::invariance
