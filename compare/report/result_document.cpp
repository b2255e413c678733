#include "compare/report/result_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/decompositions.h"
#include "common/overloaded.h"
#include "compare/quantities/observe.h"
#include "compare/report/explanations.h"
#include "compare/report/files.h"
#include "compare/report/force_table.h"
#include "compare/report/origin.h"
#include "compare/report/start_text.h"
#include "compare/report/table.h"
#include "compare/verdict/carried.h"
#include "compare/verdict/refinement.h"

namespace concord::compare {

namespace {

using ResultJson = nlohmann::ordered_json;

/// A flexible body is drawn through no more points than these.
constexpr std::size_t kDrawnPoints = 60;

template <class Matrix>
ResultJson numbers(const Matrix& matrix) {
  ResultJson list = ResultJson::array();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) list.push_back(matrix(row, column));
  }
  return list;
}

ResultJson or_null(const std::optional<double>& value) { return value ? ResultJson(*value) : ResultJson(); }

/// The box of even density that has a body's mass and inertia: its axes as columns, and half of its edges.
ResultJson inertia_box(const Body& body) {
  if (!(body.mass > 0.0) || body.inertia_L.isZero(0.0)) return nullptr;
  const SymmetricEigenpairs principal = symmetric_eigenpairs(body.inertia_L);
  if (!principal.values.allFinite()) return nullptr;
  Mat3 axes = principal.vectors;
  if (axes.determinant() < 0.0) axes.col(2) *= -1.0;
  const Vec3 moments = principal.values;
  const double sum = moments.sum() / 2.0;  // of m x^2, m y^2, m z^2
  const Vec3 half = (3.0 / body.mass * (sum - moments.array())).max(0.0).sqrt();
  return {{"axes", numbers(axes)}, {"half", numbers(half)}};
}

/// Points through which a flexible body is drawn: undeformed place and translation rows of the modes.
ResultJson drawn_points(const ModalData& modal) {
  ResultJson points = ResultJson::array();
  const bool has_nodes = modal.nodes.size() >= 2;
  const std::size_t count = has_nodes ? modal.nodes.size() : modal.mass_points.size();
  const std::size_t shown = std::min(count, kDrawnPoints);
  for (std::size_t k = 0; k < shown; ++k) {
    const std::size_t from = shown < 2 ? 0 : k * (count - 1) / (shown - 1);
    const auto add = [&](const auto& point) {
      points.push_back({{"point", numbers(point.s0_L)}, {"modes", numbers(point.Psi_t_L)}});
    };
    has_nodes ? add(modal.nodes[from]) : add(modal.mass_points[from]);
  }
  return points;
}

Vec3 center_of(const Body& body) {
  if (!body.modal) return body.center_of_mass_L;
  const MatX& G = body.modal->G;
  return G(0, 0) > 0.0 ? Vec3(G.block<3, 1>(1, 0) / G(0, 0)) : Vec3(Vec3::Zero());
}

ResultJson body_json(const Body& body) {
  ResultJson said{{"name", body.name}, {"mass", body.modal ? body.modal->G(0, 0) : body.mass}};
  said["center"] = numbers(center_of(body));
  said["box"] = inertia_box(body);
  said["modes"] = body.n_modes();
  if (body.modal) said["points"] = drawn_points(*body.modal);
  return said;
}

ResultJson end_json(const Attachment& end) {
  return {{"body", end.body},
          {"point", numbers(end.point_L)},
          {"frame", numbers(end.C)},
          {"modes", numbers(end.Psi_t_L)},
          {"turns", numbers(end.Psi_r_L)}};
}

/// A road's height over x: straight lines between these points are what a picture shows.
ResultJson road_json(const Road& road) {
  constexpr int kPointsOfStretch = 24;
  ResultJson points = ResultJson::array();
  for (int stretch = 0;; ++stretch) {
    const auto [first, last] = edges_of(road, stretch);
    if (!std::isfinite(last)) {
      const double x = std::isfinite(first) ? first : 0.0;
      points.push_back({x, evaluate(road, stretch, x).h});
      return points;
    }
    if (!std::isfinite(first)) continue;
    for (int k = 0; k < kPointsOfStretch; ++k) {
      const double x = first + (last - first) * k / kPointsOfStretch;
      points.push_back({x, evaluate(road, stretch, x).h});
    }
  }
}

ResultJson element_json(const ForceElement& element) {
  const Attachment* parent = end_of(element, Side::parent);
  const Attachment* child = end_of(element, Side::child);
  ResultJson said{{"name", element.name},
                  {"type", key_of(element)},
                  {"parent", parent != nullptr ? end_json(*parent) : ResultJson()},
                  {"child", child != nullptr ? end_json(*child) : ResultJson()}};
  if (const auto* tire = std::get_if<Tire>(&element.what)) {
    said["radius"] = tire->radius;
    said["road"] = road_json(*tire->road);
  }
  return said;
}

ResultJson machine_json(const Model& model) {
  ResultJson bodies = ResultJson::array();
  for (const Body& body : model.bodies) bodies.push_back(body_json(body));
  ResultJson joints = ResultJson::array();
  for (const Joint& joint : model.joints) {
    joints.push_back({{"name", joint.name},
                      {"type", joint.type->name},
                      {"parent", end_json(joint.on(Side::parent))},
                      {"child", end_json(joint.on(Side::child))}});
  }
  ResultJson elements = ResultJson::array();
  for (const ForceElement& element : model.elements) elements.push_back(element_json(element));
  return {{"length", model.length_scale()},
          {"gravity", numbers(model.gravity)},
          {"bodies", std::move(bodies)},
          {"joints", std::move(joints)},
          {"elements", std::move(elements)}};
}

/// The row of a joint's reaction or of a force element's wrench, by places in the machine, not by names.
ResultJson result_row(const Model& model, const QuantityRow& row) {
  ResultJson digits = ResultJson::array();
  ResultJson resolvable = ResultJson::array();
  ResultJson needs = ResultJson::array();
  ResultJson scales = ResultJson::array();
  const bool is_shown = is_judged(row);
  for (const Check check : kChecks) {
    digits.push_back(is_shown ? or_null(digits_of(row, check)) : ResultJson());
    resolvable.push_back(is_shown ? or_null(detail_of(row, check).resolvable) : ResultJson());
    needs.push_back(need_of(row, check));
    scales.push_back(digits_of(row, check) ? ResultJson(detail_of(row, check).scale) : ResultJson());
  }
  const CheckDetail& detail = detail_of(row, Check::same_state);
  return {
      {"kind", row.quantity.kind == Kind::element ? "element" : "joint"},
      {"owner", row.quantity.owner},
      {"side", index(row.quantity.side)},
      {"component", row.quantity.component},
      {"unit", unit_of(model, row.quantity)},
      {"scale", row.scale},
      {"scale_from", name_of(row.source)},
      {"scales", std::move(scales)},
      {"digits", std::move(digits)},
      {"resolvable", std::move(resolvable)},
      {"need", std::move(needs)},
      {"because", row.need.because},
      {"worst_t", row.worst_t},
      {"states", {{"judged", detail.samples}, {"not_unique", detail.not_unique}, {"too_coarse", detail.too_coarse}}},
      {"unique", row.unique},
      {"by_resolution", is_judged_by_resolution(row)},
      {"verdict", to_string(row.judgement)},
      {"said", judgement_text(row)}};
}

ResultJson result_rows(const Model& model, const Verdict& verdict) {
  ResultJson rows = ResultJson::array();
  for (const QuantityRow& row : verdict.rows) rows.push_back(result_row(model, row));
  for (const QuantityRow& row : verdict.others) {
    if (row.quantity.kind == Kind::element) rows.push_back(result_row(model, row));
  }
  return rows;
}

/// What a reference says of a component that the page draws, no more points than a picture shows.
ResultJson reference_curve(const ReferenceRow& row) {
  constexpr std::size_t kMostPoints = 500;
  const std::size_t stride = (row.times.size() + kMostPoints - 1) / kMostPoints;
  ResultJson t = ResultJson::array();
  ResultJson values = ResultJson::array();
  for (std::size_t k = 0; k < row.times.size(); k += stride) {
    t.push_back(row.times[k]);
    values.push_back(row.values[k]);
  }
  return {{"kind", row.quantity->kind == Kind::element ? "element" : "joint"},
          {"owner", row.quantity->owner},
          {"side", index(row.quantity->side)},
          {"component", row.quantity->component},
          {"t", std::move(t)},
          {"values", std::move(values)}};
}

ResultJson result_solver(const Verdict& verdict, const SolverSummary& solver) {
  return {{"name", solver.name},
          {"integrator", solver.integrator},
          {"cut_joints", solver.cut_joints},
          {"constraints", solver.rank.constraints},
          {"rank", solver.rank.rank},
          {"degrees_of_freedom", solver.rank.degrees_of_freedom},
          {"steps", solver.statistics.steps},
          {"evaluations", solver.statistics.evaluations},
          {"max_constraint", solver.statistics.max_constraint},
          {"audit_digits", or_null(solver.audit_digits)},
          {"audit_worst", solver.audit_worst},
          {"audit_need", solver.audit_need},
          {"energy_error", or_null(solver.energy_error)},
          {"energy_drift", solver.energy ? drift_text(*solver.energy, verdict.energy_allowed) : ""}};
}

/// A table as it is printed: its lines, the head first, and which columns stand right.
ResultJson table_json(const TextTable& table) { return {{"lines", table.lines}, {"right", table.right}}; }

/// What is told beside the verdict, as it is printed: the forces of the run, and the pose at the start.
ResultJson told_tables(const Model& model, const Verdict& verdict) {
  ResultJson told = ResultJson::array();
  const auto add = [&](const char* title, std::vector<std::string> words, const std::vector<TextTable>& tables) {
    ResultJson& one = told.emplace_back(ResultJson{{"title", title}, {"words", std::move(words)}});
    for (const TextTable& table : tables) one["tables"].push_back(table_json(table));
  };
  const auto [axes, forces] = force_tables(model, verdict);
  if (!forces.empty()) add("Forces", axes.empty() ? std::vector<std::string>{} : std::vector{axes}, forces);
  if (verdict.start && !verdict.start->coordinates.empty()) {
    const auto [table, lines] = start_table(model, *verdict.start);
    add("Pose at the start", lines, {table});
  }
  return told;
}

ResultJson result_check(const char* name, const CheckSummary& check) {
  return {{"name", name},
          {"digits", or_null(check.digits)},
          {"states", check.samples},
          {"passed", check.passed},
          {"horizon_s", or_null(check.horizon)}};
}

ResultJson result_check(const Verdict& verdict, Check check) {
  ResultJson said = result_check(name_of(check), summary_of(verdict, check));
  said["passed_with_less"] = passed_with_less(verdict, check);
  return said;
}

ResultJson result_checks(const Verdict& verdict) {
  ResultJson checks = ResultJson::array();
  checks.push_back({{"name", "rank"}, {"digits", nullptr}, {"passed", verdict.rank_agrees}});
  for (const Check check : kChecks) checks.push_back(result_check(verdict, check));
  checks.push_back(result_check("audit", verdict.audit));
  checks.push_back({{"name", "energy"}, {"digits", nullptr}, {"passed", keeps_energy(verdict)}});
  if (!verdict.references.empty()) {
    checks.push_back({{"name", "reference"}, {"digits", nullptr}, {"passed", agrees_with_reference(verdict)}});
  }
  return checks;
}

/// Null of a model that was made without a file.
ResultJson file_json(const std::string& file) {
  if (file.empty()) return nullptr;
  return {{"name", file}, {"fnv1a", fmt::format("{:016x}", hash_of_file(file))}};
}

}  // namespace

std::string format_result(const Model& model, const Verdict& verdict) {
  ResultJson findings = ResultJson::array();
  for (const Finding& finding : verdict.findings) {
    findings.push_back({{"what", finding.what}, {"symptom", finding.symptom}});
  }
  ResultJson solvers = ResultJson::array();
  for (const SolverSummary& solver : verdict.solvers) solvers.push_back(result_solver(verdict, solver));
  const ComponentCount count = count_components(verdict);
  ResultJson said{{"kind", "concord result"},
                  {"format", kResultFormat},
                  {"program", version_words()},
                  {"model", verdict.name},
                  {"file", file_json(model.file)},
                  {"outcome", to_string(verdict.outcome)},
                  {"judged", count.judged},
                  {"total", count.total},
                  {"judged_instead", judged_instead(verdict)},
                  {"bodies", verdict.bodies},
                  {"joints", verdict.joints},
                  {"loops", verdict.loops},
                  {"modes", verdict.modes},
                  {"run",
                   {{"until", verdict.run.until},
                    {"rtol", verdict.run.rtol},
                    {"seed", verdict.seed},
                    {"energy_allowed", verdict.energy_allowed}}},
                  {"rungs", result_checks(verdict)},
                  {"solvers", std::move(solvers)},
                  {"findings", std::move(findings)},
                  {"notes", verdict.notes},
                  {"failures", verdict.failures},
                  {"told", told_tables(model, verdict)},
                  {"rows", result_rows(model, verdict)},
                  {"machine", machine_json(model)}};
  add_explanations(said, model, verdict);
  for (std::size_t k = 0; k < verdict.references.size(); ++k) {
    if (verdict.references[k].quantity) said["reference"][k]["curve"] = reference_curve(verdict.references[k]);
  }
  return said.dump(-1, ' ', false, ResultJson::error_handler_t::replace) + '\n';
}

}  // namespace concord::compare
