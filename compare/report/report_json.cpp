#include "compare/report/report_json.h"

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "compare/audit/geometric_stiffness.h"
#include "compare/quantities/align.h"
#include "compare/report/explanations.h"
#include "compare/report/force_json.h"
#include "compare/report/redundancy_text.h"
#include "compare/report/start_text.h"
#include "compare/report/told_axes.h"
#include "compare/verdict/carried.h"
#include "compare/verdict/refinement.h"

namespace concord::compare {

namespace {

using Json = nlohmann::ordered_json;

Json check(const CheckSummary& summary) {
  Json found{{"digits", digits_json(summary.digits)}};
  if (summary.horizon) found["horizon_s"] = *summary.horizon;
  return found;
}

Json check(const Verdict& verdict, Check of) {
  Json found = check(summary_of(verdict, of));
  if (std::string less = passed_with_less(verdict, of); !less.empty()) found["passed_with_less"] = std::move(less);
  return found;
}

/// A row of a joint's reaction or of a force element's wrench; `owner` says which.
Json wrench_row(const char* owner, const std::string& name, const QuantityRow& row) {
  const bool is_shown = is_judged(row);
  const auto judged = [&](const std::optional<double>& value) { return is_shown ? digits_json(value) : Json(nullptr); };
  const CheckDetail& detail = detail_of(row, Check::same_state);
  Json need{{"same_state", row.need.same_state}, {"same_run", row.need.same_run}, {"refined", row.need.refined}};
  return {
      {owner, name},
      {"side", row.quantity.side == Side::child ? "child" : "parent"},
      {"component", describe_component(row.quantity)},
      {"scale", row.scale},
      {"scale_from", name_of(row.source)},
      {"unique", row.unique},
      {"states", {{"judged", detail.samples}, {"not_unique", detail.not_unique}, {"too_coarse", detail.too_coarse}}},
      {"same_state_digits", judged(row.same_state)},
      {"same_state_resolvable_digits", judged(detail.resolvable)},
      {"same_state_resolutions", detail.ratio},
      {"same_run_digits", judged(row.same_run)},
      {"same_run_scale", row.same_run ? Json(detail_of(row, Check::same_run).scale) : Json(nullptr)},
      {"refined_digits", judged(row.refined)},
      {"need", std::move(need)},
      {"judged_by_resolution", is_judged_by_resolution(row)},
      {"verdict", judgement_json(row.judgement)}};
}

Json solver(const SolverSummary& summary) {
  return {{"wall_s", summary.statistics.wall_s},
          {"steps", summary.statistics.steps},
          {"evaluations", summary.statistics.evaluations},
          {"max_constraint", summary.statistics.max_constraint},
          {"energy_error", summary.energy_error ? Json(*summary.energy_error) : Json(nullptr)},
          {"energy_drift", summary.energy ? Json(summary.energy->drift) : Json(nullptr)}};
}

/// Null where it is not known.
Json geometric_stiffness_of(const Model& model, const Verdict& verdict) {
  Json ratios = Json::array();
  for (const GeometricStiffness& ratio : verdict.geometric_stiffness.value_or(geometric_stiffness(model, {}))) {
    if (!ratio.is_known) {
      ratios.push_back({{"body", ratio.body}, {"lowest", nullptr}, {"highest", nullptr}});
      continue;
    }
    ratios.push_back({{"body", ratio.body},
                      {"plane", ratio.plane},
                      {"mode", ratio.mode},
                      {"lowest", ratio.lowest},
                      {"t_lowest", ratio.t_lowest},
                      {"highest", ratio.highest},
                      {"t_highest", ratio.t_highest}});
  }
  return ratios;
}

Json orders_of(const Orders& orders) {
  const auto of = [](const ObservedOrder& order) {
    return Json{{"order", order.exponent ? Json(*order.exponent) : Json(nullptr)}, {"errors", order.errors}};
  };
  Json told{{"rtol", orders.tolerances}, {"against", orders.against}};
  for (std::size_t who = 0; who < 2; ++who) {
    const SolverOrders& solver = orders.solvers[who];
    told[kSolverNames[who]] = {
        {"places", of(solver.places)}, {"velocities", of(solver.velocities)}, {"reactions", of(solver.reactions)}};
  }
  return told;
}

Json document(const Model& model, const Verdict& verdict) {
  Json joints = Json::array();
  for (const QuantityRow& row : verdict.rows) {
    joints.push_back(wrench_row("joint", model.joints[row.quantity.owner].name, row));
  }
  Json elements = Json::array();
  for (const QuantityRow& row : verdict.others) {
    if (row.quantity.kind != Kind::element) continue;
    elements.push_back(wrench_row("element", model.elements[row.quantity.owner].name, row));
  }
  Json solvers;
  solvers["cartesian"] = solver(verdict.solvers[0]);
  solvers["relative"] = solver(verdict.solvers[1]);
  const ComponentCount reactions = count_reactions(verdict);
  Json said{{"format", kVerdictFormat},
            {"name", verdict.name},
            {"verdict", to_string(verdict.outcome)},
            {"judged", reactions.judged},
            {"total", reactions.total},
            {"same_state", check(verdict, Check::same_state)},
            {"same_run", check(verdict, Check::same_run)},
            {"refined", check(verdict, Check::refined)},
            {"audit", check(verdict.audit)},
            {"joints", std::move(joints)},
            {"solvers", std::move(solvers)},
            {"forces", forces_json(model, verdict)}};
  if (std::string instead = judged_instead(verdict); !instead.empty()) said["judged_instead"] = std::move(instead);
  for (const Finding& finding : verdict.findings) {
    said["findings"].push_back({{"what", finding.what}, {"looks_like", finding.symptom}});
  }
  if (!verdict.failures.empty()) said["failures"] = verdict.failures;
  if (!verdict.notes.empty()) said["notes"] = verdict.notes;
  add_explanations(said, model, verdict);
  if (verdict.axes) said["axes"] = words_of(model, verdict.axes);
  add_redundancy(said, model, verdict);
  if (verdict.start) said["start"] = start_json(model, *verdict.start);
  if (verdict.orders) said["orders"] = orders_of(*verdict.orders);
  if (!elements.empty()) said["elements"] = std::move(elements);
  if (model.is_flexible()) said["geometric_stiffness"] = geometric_stiffness_of(model, verdict);
  return said;
}

Json document(const ReportedCase& one) {
  if (one.verdict != nullptr) return document(*one.model, *one.verdict);
  Verdict none;
  none.failures.push_back(one.trouble.substr(0, one.trouble.find_last_not_of('\n') + 1));
  Json said = document(Model{}, none);
  if (one.is_bad_input) said["verdict"] = "bad input";
  return said;
}

/// Words of an error may hold bytes of a file that are no text.
std::string dumped(const Json& document) { return document.dump(2, ' ', false, Json::error_handler_t::replace) + '\n'; }

}  // namespace

std::string format_json(const Model& model, const Verdict& verdict) { return dumped(document(model, verdict)); }

std::string format_json(const ReportedCase& one) { return dumped(document(one)); }

std::string format_json(const std::vector<ReportedCase>& cases) {
  Json all = Json::object();
  for (const ReportedCase& one : cases) all[one.name] = document(one);
  return dumped(all);
}

}  // namespace concord::compare
