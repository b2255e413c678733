#include "compare/analyses/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "compare/audit/digits.h"
#include "compare/quantities/observe.h"
#include "compare/report/explanations.h"
#include "compare/report/force_table.h"
#include "compare/report/redundancy_text.h"
#include "compare/report/table.h"
#include "compare/report/text_table.h"
#include "compare/verdict/carried.h"
#include "compare/verdict/refinement.h"

namespace concord::compare::analyses {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kFormat = 1;

bool is_wrench(const QuantityRow& row) {
  return row.quantity.kind == Kind::reaction || row.quantity.kind == Kind::element;
}

bool is_same_side(const QuantityRow& a, const QuantityRow& b) {
  return a.quantity.kind == b.quantity.kind && a.quantity.owner == b.quantity.owner &&
         a.quantity.side == b.quantity.side;
}

double margin(const QuantityRow& row) {
  if (!row.unique) return kMostDigits;
  return std::min(margin(row, Check::same_state), margin(row, Check::same_run));
}

/// Reactions and element wrenches: all, or of each side the one with the least margin.
std::vector<const QuantityRow*> chosen_rows(const Verdict& verdict, bool all_rows) {
  std::vector<const QuantityRow*> chosen;
  const auto take = [&](const QuantityRow& row) {
    if (!is_wrench(row)) return;
    if (all_rows || chosen.empty() || !is_same_side(*chosen.back(), row)) {
      chosen.push_back(&row);
    } else if (margin(row) < margin(*chosen.back())) {
      chosen.back() = &row;
    }
  };
  for (const QuantityRow& row : verdict.rows) take(row);
  for (const QuantityRow& row : verdict.others) take(row);
  return chosen;
}

std::string digits_cell(const QuantityRow& row, Check check) {
  return row.unique ? compare::digits_cell(digits_of(row, check)) : "-";
}

std::string row_table(const Model& model, const AnalysisVerdict& result, bool all_rows) {
  std::vector<std::vector<std::string>> lines{
      {"wrench", "component", "scale", "same state", "each its own", "need", "verdict"}};
  for (const QuantityRow* row : chosen_rows(result.wrenches, all_rows)) {
    lines.push_back({describe_owner(model, row->quantity), describe_component(row->quantity),
                     fmt::format("{:.4g}{} {}", row->scale, row->source == ScaleSource::floor ? " (floor)" : "",
                                 unit_of(model, row->quantity)),
                     digits_cell(*row, Check::same_state), digits_cell(*row, Check::same_run),
                     fmt::format("{:g} / {:g}", row->need.same_state, row->need.same_run), judgement_text(*row)});
  }
  return lines.size() > 1 ? format_table(lines, {false, false, true, true, true, false, false}) + '\n' : "";
}

std::string last_line(const AnalysisVerdict& result) {
  const Verdict& verdict = result.wrenches;
  const ComponentCount count = count_components(verdict);
  std::string text = fmt::format("{} {}: {}: {} of {} components of joints and force elements judged",
                                 to_string(verdict.outcome), verdict.name, result.analysis, count.judged, count.total);
  if (const std::string instead = judged_instead(verdict); !instead.empty()) text += ": " + instead;
  const auto add = [&](const char* name, const std::optional<double>& digits, const std::string& less) {
    if (digits) text += fmt::format(", {} {}", name, format_digits(*digits));
    if (digits && !less.empty()) text += fmt::format(" ({})", less);
  };
  add("same state", verdict.same_state.digits, passed_with_less(verdict, Check::same_state));
  add("each its own", verdict.same_run.digits, passed_with_less(verdict, Check::same_run));
  add("audit", verdict.audit.digits, "");
  std::optional<double> numbers;
  int resolved = 0;
  for (const NumberRow& row : result.numbers) {
    numbers = std::min(numbers.value_or(kMostDigits), row.digits);
    if (row.agrees() && row.digits < row.need) ++resolved;
  }
  add("numbers", numbers,
      resolved > 0 ? fmt::format("{} of {} below their need, within what is resolved", resolved, result.numbers.size())
                   : "");
  return text + '\n';
}

/// By solver: all quantities (rows) at all times (columns), none where it has found nothing.
using Observed = std::array<std::optional<MatX>, 2>;

Observed observe_all(const QuantityLayout& layout, const Verdict& verdict) {
  Observed found;
  for (std::size_t who = 0; who < 2; ++who) {
    if (!verdict.trajectories[who]) continue;
    const std::vector<Sample>& samples = verdict.trajectories[who]->samples;
    MatX values(static_cast<Eigen::Index>(layout.quantities().size()), static_cast<Eigen::Index>(samples.size()));
    for (std::size_t k = 0; k < samples.size(); ++k) {
      values.col(static_cast<Eigen::Index>(k)) = layout.observe(samples[k].state, samples[k].evaluation);
    }
    found[who] = std::move(values);
  }
  return found;
}

/// What each solver found of a quantity, a number for each time; null where one has found nothing.
Json values_json(const Verdict& verdict, const Observed& found, int row) {
  Json values = Json::object();
  for (std::size_t who = 0; who < 2; ++who) {
    Json& of_solver = values[verdict.solvers[who].name];
    if (!found[who]) continue;
    of_solver = Json::array();
    for (const double value : found[who]->row(row)) of_solver.push_back(value);
  }
  return values;
}

Json times_json(const Verdict& verdict) {
  Json times = Json::array();
  for (const auto& run : verdict.trajectories) {
    if (!run) continue;
    for (const Sample& sample : run->samples) times.push_back(sample.state.t);
    break;
  }
  return times;
}

Json row_json(const Model& model, const QuantityRow& row) {
  const bool is_element = row.quantity.kind == Kind::element;
  const std::string& name =
      is_element ? model.elements[row.quantity.owner].name : model.joints[row.quantity.owner].name;
  return {{is_element ? "element" : "joint", name},
          {"side", row.quantity.side == Side::child ? "child" : "parent"},
          {"component", describe_component(row.quantity)},
          {"scale", row.scale},
          {"unique", row.unique},
          {"same_state_digits", row.unique ? digits_json(row.same_state) : Json(nullptr)},
          {"own_digits", row.unique ? digits_json(row.same_run) : Json(nullptr)},
          {"need", {{"same_state", row.need.same_state}, {"own", row.need.same_run}}},
          {"verdict", judgement_json(row.judgement)}};
}

std::vector<const QuantityRow*> drive_rows(const Model& machine, const Verdict& verdict) {
  std::vector<const QuantityRow*> chosen;
  for (const auto* rows : {&verdict.rows, &verdict.others}) {
    for (const QuantityRow& row : *rows) {
      if (is_told_force(machine, row.quantity)) chosen.push_back(&row);
    }
  }
  return chosen;
}

/// What drivers, motors, springs, dampers and couplings exert where there is one time only: in a pose.
std::string drive_table(const Model& machine, const Verdict& verdict) {
  const QuantityLayout layout(machine);
  const Observed found = observe_all(layout, verdict);
  std::vector<std::vector<std::string>> lines{{"force", "along", "cartesian", "relative", "unit", "digits"}};
  for (const QuantityRow* row : drive_rows(machine, verdict)) {
    lines.push_back({describe_owner(machine, row->quantity), coordinate_of(machine, row->quantity)});
    for (const std::optional<MatX>& of_solver : found) {
      if (!of_solver || of_solver->cols() != 1) return "";
      const double force = (*of_solver)(layout.row_of(row->quantity), 0);
      lines.back().push_back(row->unique ? fmt::format("{:.10g}", force) : "not unique");
    }
    lines.back().push_back(unit_of(machine, row->quantity));
    lines.back().push_back(digits_cell(*row, Check::same_run));
  }
  if (lines.size() == 1) return "";
  return format_table(lines, {false, false, true, true, false, true}) +
         "positive: it pushes the coordinate, or the sum of a coupling, to grow\n\n";
}

Json drives_json(const Model& machine, const Verdict& verdict) {
  const QuantityLayout layout(machine);
  const Observed found = observe_all(layout, verdict);
  Json drives = Json::array();
  for (const QuantityRow* row : drive_rows(machine, verdict)) {
    const Quantity& one = row->quantity;
    const bool is_coupling = one.kind == Kind::coupling;
    drives.push_back({{"force", describe_owner(machine, one)},
                      {is_coupling ? "coupling" : "joint",
                       is_coupling ? machine.couplings[one.owner].name : machine.joints[one.owner].name},
                      {"along", is_coupling ? Json(nullptr) : Json(coordinate_of(machine, one))},
                      {"unit", unit_of(machine, one)},
                      {"unique", row->unique},
                      {"same_state_digits", row->unique ? digits_json(row->same_state) : Json(nullptr)},
                      {"own_digits", row->unique ? digits_json(row->same_run) : Json(nullptr)},
                      {"values", row->unique ? values_json(verdict, found, layout.row_of(one)) : Json(nullptr)}});
  }
  return drives;
}

Json wrenches_json(const Model& machine, const Verdict& verdict) {
  const QuantityLayout layout(machine);
  const Observed found = observe_all(layout, verdict);
  Json wrenches = Json::array();
  for (const auto* rows : {&verdict.rows, &verdict.others}) {
    for (const QuantityRow& row : *rows) {
      if (!is_wrench(row)) continue;
      Json entry = row_json(machine, row);
      entry["unit"] = unit_of(machine, row.quantity);
      entry["values"] = values_json(verdict, found, layout.row_of(row.quantity));
      wrenches.push_back(std::move(entry));
    }
  }
  return wrenches;
}

Json modes_json(const Linearization& found) {
  Json modes = Json::array();
  for (const Mode& mode : found.modes) {
    Json shape = Json::array();
    for (const auto& part : mode.shape) shape.push_back({part.real(), part.imag()});
    modes.push_back({{"eigenvalue", {mode.eigenvalue.real(), mode.eigenvalue.imag()}},
                     {"frequency_hz", mode.frequency()},
                     {"damping_ratio", mode.damping_ratio()},
                     {"free", mode.is_free},
                     {"motion", mode.motion},
                     {"shape", std::move(shape)}});
  }
  return modes;
}

/// Names of the numbers of a shape, with their units: "coupler.v_x [m/s]", "coupler.adot_1 [1/s]".
std::vector<std::string> shape_names(const Model& model) {
  std::vector<std::string> names;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    for (const char* axis : {"x", "y", "z"}) names.push_back(fmt::format("{}.v_{} [m/s]", body.name, axis));
    for (const char* axis : {"x", "y", "z"}) names.push_back(fmt::format("{}.omega_{} [rad/s]", body.name, axis));
    for (int mode = 1; mode <= body.n_modes(); ++mode)
      names.push_back(fmt::format("{}.adot_{} [1/s]", body.name, mode));
  }
  return names;
}

}  // namespace

std::string format_modes_csv(const Model& model, const Linearization& found) {
  std::string text = "mode,eigenvalue.re [1/s],eigenvalue.im [1/s],frequency [Hz],damping_ratio,free";
  for (const std::string& name : shape_names(model)) text += fmt::format(",re {0},im {0}", name);
  text += '\n';
  for (std::size_t k = 0; k < found.modes.size(); ++k) {
    const Mode& mode = found.modes[k];
    text += fmt::format("{},{:.17g},{:.17g},{:.17g},{:.17g},{}", k + 1, mode.eigenvalue.real(), mode.eigenvalue.imag(),
                        mode.frequency(), mode.damping_ratio(), mode.is_free ? 1 : 0);
    for (const auto& part : mode.shape) text += fmt::format(",{:.17g},{:.17g}", part.real(), part.imag());
    text += '\n';
  }
  return text;
}

std::string format_analysis(const Model& model, const AnalysisVerdict& result, bool all_rows) {
  const Verdict& verdict = result.wrenches;
  std::string text = fmt::format("{}: {}\n{}\n", verdict.name, result.analysis, result.text);
  text += drive_table(result.machine ? *result.machine : model, verdict) + row_table(model, result, all_rows);
  text += not_unique_text(model, verdict, all_rows) + pair_sums_text(verdict);
  for (const SolverSummary& solver : verdict.solvers) {
    if (solver.audit_digits) text += fmt::format("audit of {}: {}\n", solver.name, solver.audit_worst);
  }
  for (const Finding& finding : verdict.findings) {
    text += fmt::format("FAIL {}: {}\n     {}\n", verdict.name, finding.what, finding.symptom);
  }
  for (const std::string& failure : verdict.failures) text += fmt::format("STOP {}: {}\n", verdict.name, failure);
  return text + last_line(result);
}

std::string format_analysis_json(const Model& model, const AnalysisVerdict& result) {
  const Verdict& verdict = result.wrenches;
  const ComponentCount count = count_components(verdict);
  Json document{{"format", kFormat},
                {"analysis", result.analysis},
                {"model", verdict.name},
                {"verdict", to_string(verdict.outcome)},
                {"judged", count.judged},
                {"total", count.total},
                {"same_state", {{"digits", digits_json(verdict.same_state.digits)}}},
                {"own", {{"digits", digits_json(verdict.same_run.digits)}}},
                {"audit", {{"digits", digits_json(verdict.audit.digits)}}}};
  const Model& machine = result.machine ? *result.machine : model;
  document["t"] = times_json(verdict);
  document["wrenches"] = wrenches_json(machine, verdict);
  document["drives"] = drives_json(machine, verdict);
  add_redundancy(document, machine, verdict);
  document["numbers"] = Json::array();
  for (const NumberRow& row : result.numbers) {
    document["numbers"].push_back({{"name", row.name},
                                   {"unit", row.unit},
                                   {"cartesian", row.values[0]},
                                   {"relative", row.values[1]},
                                   {"digits", digits_json(row.digits)},
                                   {"resolvable_digits", digits_json(row.resolvable)},
                                   {"need", row.need},
                                   {"verdict", row.agrees() ? "agree" : "differ"}});
  }
  for (const AppliedForceRow& row : result.forces) {
    document["forces"].push_back({{"driven", row.name},
                                  {"acceleration", row.acceleration},
                                  {"unit", row.unit},
                                  {"cartesian", row.tau[0]},
                                  {"relative", row.tau[1]},
                                  {"digits", digits_json(row.digits)}});
  }
  for (std::size_t who = 0; who < 2; ++who) {
    if (!result.linearizations[who]) continue;
    document["modes"][verdict.solvers[who].name] = modes_json(*result.linearizations[who]);
  }
  return document.dump(2) + '\n';
}

}  // namespace concord::compare::analyses
