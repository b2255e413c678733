#include "compare/report/report_json.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "compare/audit/geometric_stiffness.h"
#include "compare/verdict/refinement.h"
#include "compare/verdict/third_words.h"

namespace concord::compare {

namespace {

using Json = nlohmann::ordered_json;

Json digits(const std::optional<double>& value) {
  if (!value) return nullptr;
  return std::floor(*value * 100.0) / 100.0;
}

Json rung(const RungSummary& summary) {
  Json found{{"digits", digits(summary.digits)}};
  if (summary.horizon) found["horizon_s"] = *summary.horizon;
  return found;
}

/// A row of a joint's reaction or of a force element's wrench; `owner` says which.
Json wrench_row(const char* owner, const std::string& name, const QuantityRow& row) {
  const bool is_shown = is_judged(row);
  const auto judged = [&](const std::optional<double>& value) { return is_shown ? digits(value) : Json(nullptr); };
  const RungDetail& detail = detail_of(row, Rung::same_state);
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
      {"refined_digits", judged(row.refined)},
      {"need", std::move(need)},
      {"judged_by_resolution", is_judged_by_resolution(row, Rung::same_state)},
      {"verdict", row.judgement == Judgement::agree    ? "agree"
                  : row.judgement == Judgement::differ ? "differ"
                                                       : "not_judged"}};
}

Json reference_row(const ReferenceRow& row) {
  return {{"of", row.of},
          {"component", row.component},
          {"peak", row.peak},
          {"stated_error", row.allowed},
          {"cartesian_off", row.differences[0]},
          {"relative_off", row.differences[1]},
          {"verdict", !row.is_judged ? "not_judged"
                      : row.agrees   ? "agree"
                                     : "differ"}};
}

Json third_row(const Model& model, const ThirdRow& row, const std::string& third) {
  return {{"of", describe_owner(model, row.quantity)},
          {"kind", word_of(row.quantity.kind)},
          {"component", describe_component(row.quantity)},
          {"scale", row.scale},
          {"cartesian_digits", digits(row.shared[0].digits)},
          {"relative_digits", digits(row.shared[1].digits)},
          {"between_digits", digits(row.between.digits)},
          {"need", row.need},
          {"off", name_of(blame_in(row), third)}};
}

Json third_opinion(const Model& model, const ThirdReport& third) {
  Json said{{"name", third.name}};
  if (!third.not_expressible.empty()) {
    said["not_expressible"] = third.not_expressible;
    return said;
  }
  said["states"] = third.states;
  said["failed"] = third.failed;
  said["rows"] = Json::array();
  for (const ThirdRow& row : third.rows) said["rows"].push_back(third_row(model, row, third.name));
  return said;
}

Json solver(const SolverSummary& summary) {
  return {{"wall_s", summary.statistics.wall_s},
          {"steps", summary.statistics.steps},
          {"evaluations", summary.statistics.evaluations},
          {"max_constraint", summary.statistics.max_constraint},
          {"energy_error", summary.energy_error ? Json(*summary.energy_error) : Json(nullptr)}};
}

/// Of the first run that there is; null where it is not known.
Json geometric_stiffness_of(const Model& model, const Verdict& verdict) {
  Json ratios = Json::array();
  const auto& run = verdict.trajectories[verdict.trajectories[0] ? 0 : 1];
  const Trajectory none;
  for (const GeometricStiffness& ratio : geometric_stiffness(model, run ? *run : none)) {
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

/// Whose fault a difference is, and whether motions or equations differ; empty where nothing differs.
Json attribution_of(const Verdict& verdict) {
  Json told = Json::object();
  if (verdict.attribution) {
    constexpr std::array kSolvers{"cartesian", "relative", "both"};
    const bool is_nobodys = verdict.attribution->term == Term::statement;
    told["solver"] = is_nobodys ? "none" : kSolvers[verdict.attribution->solver];
    told["place"] = verdict.attribution->where;
    told["term"] = name_of(verdict.attribution->term);
    told["because"] = verdict.attribution->because;
    if (verdict.attribution->closed_digits) told["closed_digits"] = digits(verdict.attribution->closed_digits);
  }
  if (verdict.two_by_two) {
    const TwoByTwo& table = *verdict.two_by_two;
    told["two_by_two"] = {
        {"of", table.of},
        {"unit", table.unit},
        {"samples", table.samples},
        {"formulation", {{"cartesian_motion", table.formulation[0]}, {"relative_motion", table.formulation[1]}}},
        {"integration", {{"cartesian_equations", table.integration[0]}, {"relative_equations", table.integration[1]}}},
        {"curves",
         {{"peak", table.curves.peak},
          {"t_peak", table.curves.t_peak},
          {"rms_over_range", table.curves.rms_over_range},
          {"magnitude", table.curves.magnitude},
          {"phase", table.curves.phase},
          {"combined", table.curves.combined}}}};
  }
  return told;
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
  Json said{{"format", kVerdictFormat},
            {"verdict", to_string(verdict.outcome)},
            {"judged", verdict.judged},
            {"total", verdict.total},
            {"same_state", rung(verdict.same_state)},
            {"same_run", rung(verdict.same_run)},
            {"refined", rung(verdict.refined)},
            {"audit", rung(verdict.audit)},
            {"joints", std::move(joints)},
            {"solvers", std::move(solvers)}};
  for (const ReferenceRow& row : verdict.references) said["reference"].push_back(reference_row(row));
  if (verdict.attribution || verdict.two_by_two) said["attribution"] = attribution_of(verdict);
  if (verdict.orders) said["orders"] = orders_of(*verdict.orders);
  if (verdict.third) said["third_opinion"] = third_opinion(model, *verdict.third);
  if (!elements.empty()) said["elements"] = std::move(elements);
  if (model.is_flexible()) said["geometric_stiffness"] = geometric_stiffness_of(model, verdict);
  return said;
}

}  // namespace

std::string format_json(const Model& model, const Verdict& verdict) { return document(model, verdict).dump(2) + '\n'; }

std::string format_json(const std::vector<std::pair<const Model*, const Verdict*>>& cases) {
  Json all = Json::object();
  for (const auto& [model, verdict] : cases) all[verdict->name] = document(*model, *verdict);
  return all.dump(2) + '\n';
}

}  // namespace concord::compare
