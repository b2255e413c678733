#include <fmt/format.h>

#include <array>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "compare/quantities/observe.h"
#include "compare/verdict/refinement.h"
#include "tests/read_back/expected.h"

namespace concord::read_back {

namespace {

using Json = nlohmann::json;
using compare::Judgement;
using compare::Kind;
using compare::QuantityRow;
using compare::Verdict;

/// A document against what it must say: numbers to the last digit, null for what is not known.
class Document {
 public:
  explicit Document(const std::filesystem::path& file) : complaints_(file.filename().string()) {
    std::ifstream stream(file);
    all = Json::parse(stream, nullptr, false);
    complaints_.expect(all.is_object(), "is no document");
  }

  void expect(const Json& where, const char* key, const Json& expected, const std::string& of = "") {
    const Json found = where.is_object() ? where.value(key, Json("missing")) : Json("missing");
    if (found != expected) {
      complaints_.add(fmt::format("{}{}: {}, expected {}", of, key, found.dump(), expected.dump()));
    }
  }
  void expect_size(const Json& where, const char* key, std::size_t size) {
    const std::size_t found = where.is_object() && where.contains(key) ? where.at(key).size() : 0;
    if (found != size) complaints_.add(fmt::format("{}: {} entries, expected {}", key, found, size));
  }
  [[nodiscard]] const Json& entry(const char* key, std::size_t k) const {
    static const Json kMissing;
    return all.contains(key) && k < all.at(key).size() ? all.at(key).at(k) : kMissing;
  }
  [[nodiscard]] std::vector<std::string> complaints() const { return complaints_.all(); }

  Json all;

 private:
  Complaints complaints_;
};

/// A number, null if it is none.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }
Json number(const std::optional<double>& value) { return value ? number(*value) : Json(); }

/// Digits to two decimals, rounded down.
Json two_decimals(const std::optional<double>& digits) {
  return digits ? Json(std::floor(*digits * 100.0) / 100.0) : Json();
}

template <class Numbers>
Json list(const Numbers& numbers) {
  Json all = Json::array();
  for (Eigen::Index row = 0; row < numbers.rows(); ++row) {
    for (Eigen::Index column = 0; column < numbers.cols(); ++column) all.push_back(numbers(row, column));
  }
  return all;
}

const char* word_of(compare::Outcome outcome) {
  return outcome == compare::Outcome::agree ? "agree" : outcome == compare::Outcome::differ ? "differ" : "failed";
}

const char* word_of(Judgement judgement, const char* not_judged) {
  return judgement == Judgement::agree ? "agree" : judgement == Judgement::differ ? "differ" : not_judged;
}

bool is_element(const QuantityRow& row) { return row.quantity.kind == Kind::element; }

/// The reactions of joints, then the wrenches of force elements.
std::vector<const QuantityRow*> rows_of(const Verdict& verdict) {
  std::vector<const QuantityRow*> rows;
  for (const QuantityRow& row : verdict.rows) rows.push_back(&row);
  for (const QuantityRow& row : verdict.others) {
    if (is_element(row)) rows.push_back(&row);
  }
  return rows;
}

std::string name_of(const Model& model, const QuantityRow& row) {
  const auto owner = static_cast<std::size_t>(row.quantity.owner);
  const std::string& name = is_element(row) ? model.elements.at(owner).name : model.joints.at(owner).name;
  return fmt::format("{}.{}.{}: ", name, kSides[row.quantity.side == Side::child ? 1 : 0],
                     kComponents.at(static_cast<std::size_t>(row.quantity.component)));
}

Json states_of(const QuantityRow& row) {
  const compare::CheckDetail& detail = row.detail[0];
  return {{"judged", detail.samples}, {"not_unique", detail.not_unique}, {"too_coarse", detail.too_coarse}};
}

void expect_result_row(const Model& model, const QuantityRow& row, const Json& found, Document& document) {
  const std::string of = name_of(model, row);
  const auto expect = [&](const char* key, const Json& expected) { document.expect(found, key, expected, of); };
  const std::array<std::optional<double>, 3> digits{row.same_state, row.same_run, row.refined};
  Json shown = Json::array();
  Json scales = Json::array();
  Json resolvable = Json::array();
  for (std::size_t check = 0; check < 3; ++check) {
    const bool is_shown = is_judged(row);
    shown.push_back(is_shown ? number(digits[check]) : Json());
    resolvable.push_back(is_shown ? number(row.detail[check].resolvable) : Json());
    scales.push_back(digits[check] ? Json(row.detail[check].scale) : Json());
  }
  expect("kind", is_element(row) ? "element" : "joint");
  expect("owner", row.quantity.owner);
  expect("side", row.quantity.side == Side::child ? 1 : 0);
  expect("component", row.quantity.component);
  expect("unit", unit_of_component(static_cast<std::size_t>(row.quantity.component)));
  expect("scale", row.scale);
  expect("scales", scales);
  expect("digits", shown);
  expect("resolvable", resolvable);
  expect("need", {row.need.same_state, row.need.same_run, row.need.refined});
  expect("because", row.need.because);
  expect("worst_t", row.worst_t);
  expect("states", states_of(row));
  expect("unique", row.unique);
  expect("verdict", word_of(row.judgement, "not judged"));
}

Json end_of_machine(const Attachment* end) {
  if (end == nullptr) return {};
  return {{"body", end->body},
          {"point", list(end->point_L)},
          {"frame", list(end->C)},
          {"modes", list(end->Psi_t_L)},
          {"turns", list(end->Psi_r_L)}};
}

void expect_machine(const Model& model, const Json& machine, Document& document) {
  document.expect(machine, "gravity", list(model.gravity));
  document.expect(machine, "length", model.length_scale());
  const Json none = Json::array();
  const auto each = [&](const char* key, std::size_t size, const auto& look) {
    document.expect_size(machine, key, size);
    const Json& all = machine.is_object() && machine.contains(key) ? machine.at(key) : none;
    for (std::size_t k = 0; k < std::min(all.size(), size); ++k) look(all.at(k), k);
  };
  each("bodies", model.bodies.size(), [&](const Json& body, std::size_t k) {
    const Body& expected = model.bodies[k];
    document.expect(body, "name", expected.name);
    document.expect(body, "modes", expected.n_modes(), expected.name + ": ");
    document.expect(body, "mass", expected.modal ? expected.modal->G(0, 0) : expected.mass, expected.name + ": ");
    if (!expected.modal) document.expect(body, "center", list(expected.center_of_mass_L), expected.name + ": ");
  });
  each("joints", model.joints.size(), [&](const Json& joint, std::size_t k) {
    const Joint& expected = model.joints[k];
    document.expect(joint, "name", expected.name);
    document.expect(joint, "type", expected.type->name, expected.name + ": ");
    document.expect(joint, "parent", end_of_machine(&expected.sides[0]), expected.name + ": ");
    document.expect(joint, "child", end_of_machine(&expected.sides[1]), expected.name + ": ");
  });
  each("elements", model.elements.size(), [&](const Json& element, std::size_t k) {
    const ForceElement& expected = model.elements[k];
    document.expect(element, "name", expected.name);
    for (std::size_t side = 0; side < 2; ++side) {
      const Attachment* end =
          has_end(expected, side) ? end_of(expected, side == 1 ? Side::child : Side::parent) : nullptr;
      document.expect(element, kSides[side], end_of_machine(end), expected.name + ": ");
    }
  });
}

void expect_verdict_row(const Model& model, const QuantityRow& row, const Json& found, Document& document) {
  const std::string of = name_of(model, row);
  const auto expect = [&](const char* key, const Json& expected) { document.expect(found, key, expected, of); };
  const auto shown = [&](const std::optional<double>& digits) {
    return is_judged(row) ? two_decimals(digits) : Json();
  };
  const auto owner = static_cast<std::size_t>(row.quantity.owner);
  expect(is_element(row) ? "element" : "joint",
         is_element(row) ? model.elements[owner].name : model.joints[owner].name);
  expect("side", kSides[row.quantity.side == Side::child ? 1 : 0]);
  expect("component", kComponents[static_cast<std::size_t>(row.quantity.component)]);
  expect("scale", row.scale);
  expect("unique", row.unique);
  expect("states", states_of(row));
  expect("same_state_digits", shown(row.same_state));
  expect("same_state_resolvable_digits", shown(row.detail[0].resolvable));
  expect("same_run_digits", shown(row.same_run));
  expect("same_run_scale", row.same_run ? Json(row.detail[1].scale) : Json());
  expect("refined_digits", shown(row.refined));
  expect("need", {{"same_state", row.need.same_state}, {"same_run", row.need.same_run}, {"refined", row.need.refined}});
  expect("verdict", word_of(row.judgement, "not_judged"));
}

}  // namespace

std::vector<std::string> unlike_result(const std::filesystem::path& file, const Model& model, const Verdict& verdict) {
  Document document(file);
  const auto expect = [&](const char* key, const Json& expected) { document.expect(document.all, key, expected); };
  expect("kind", "concord result");
  expect("format", 2);
  expect("model", model.name);
  expect("outcome", word_of(verdict.outcome));
  expect("bodies", verdict.bodies);
  expect("joints", verdict.joints);
  expect("loops", verdict.loops);
  expect("modes", verdict.modes);
  expect("run", {{"until", verdict.run.until},
                 {"rtol", verdict.run.rtol},
                 {"seed", verdict.seed},
                 {"energy_allowed", verdict.energy_allowed}});
  expect("notes", verdict.notes);
  expect("failures", verdict.failures);
  for (std::size_t who = 0; who < 2; ++who) {
    const compare::SolverSummary& solver = verdict.solvers[who];
    const Json& found = document.entry("solvers", who);
    document.expect(found, "name", solver.name);
    document.expect(found, "integrator", solver.integrator);
    document.expect(found, "cut_joints", solver.cut_joints);
    document.expect(found, "rank", solver.rank.rank);
    document.expect(found, "degrees_of_freedom", solver.rank.degrees_of_freedom);
    document.expect(found, "steps", solver.statistics.steps);
    document.expect(found, "audit_digits", number(solver.audit_digits));
    document.expect(found, "energy_error", number(solver.energy_error));
  }
  const std::array<const compare::CheckSummary*, 4> checks{&verdict.same_state, &verdict.same_run, &verdict.refined,
                                                           &verdict.audit};
  const std::array<const char*, 4> names{"same state", "same run", "refined", "audit"};
  for (std::size_t k = 0; k < checks.size(); ++k) {
    document.expect(document.entry("rungs", k + 1), "name", names[k]);
    document.expect(document.entry("rungs", k + 1), "digits", number(checks[k]->digits));
    document.expect(document.entry("rungs", k + 1), "passed", checks[k]->passed);
  }
  const std::vector<const QuantityRow*> rows = rows_of(verdict);
  document.expect_size(document.all, "rows", rows.size());
  for (std::size_t k = 0; k < rows.size(); ++k) expect_result_row(model, *rows[k], document.entry("rows", k), document);
  expect_machine(model, document.all.value("machine", Json()), document);
  return document.complaints();
}

std::vector<std::string> unlike_verdict(const std::filesystem::path& file, const Model& model, const Verdict& verdict) {
  Document document(file);
  document.expect(document.all, "format", 1);
  document.expect(document.all, "name", model.name);
  document.expect(document.all, "verdict", word_of(verdict.outcome));
  const std::array<const compare::CheckSummary*, 4> checks{&verdict.same_state, &verdict.same_run, &verdict.refined,
                                                           &verdict.audit};
  const std::array<const char*, 4> names{"same_state", "same_run", "refined", "audit"};
  for (std::size_t k = 0; k < checks.size(); ++k) {
    document.expect(document.all.value(names[k], Json()), "digits", two_decimals(checks[k]->digits), names[k]);
  }
  std::array<std::size_t, 2> count{};  // of joints, of elements
  for (const QuantityRow* row : rows_of(verdict)) {
    const bool of_element = is_element(*row);
    const Json& found = document.entry(of_element ? "elements" : "joints", count[of_element ? 1 : 0]++);
    expect_verdict_row(model, *row, found, document);
  }
  document.expect_size(document.all, "joints", count[0]);
  document.expect_size(document.all, "elements", count[1]);
  return document.complaints();
}

std::vector<std::string> unlike_analysis(const std::filesystem::path& file, const Model& model,
                                         const compare::analyses::AnalysisVerdict& result) {
  Document document(file);
  const Verdict& verdict = result.wrenches;
  document.expect(document.all, "analysis", result.analysis);
  document.expect(document.all, "model", model.name);
  document.expect(document.all, "verdict", word_of(verdict.outcome));
  const auto numbers_over_time = [&](std::size_t who, const auto& pick) -> Json {
    if (!verdict.trajectories[who]) return {};
    Json numbers = Json::array();
    for (const Sample& sample : verdict.trajectories[who]->samples) numbers.push_back(pick(sample));
    return numbers;
  };
  document.expect(document.all, "t", numbers_over_time(0, [](const Sample& sample) { return sample.state.t; }));
  const std::vector<const QuantityRow*> rows = rows_of(verdict);
  document.expect_size(document.all, "wrenches", rows.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const QuantityRow& row = *rows[k];
    const std::string of = name_of(model, row);
    const Json& found = document.entry("wrenches", k);
    const auto expect = [&](const char* key, const Json& expected) { document.expect(found, key, expected, of); };
    const auto owner = static_cast<std::size_t>(row.quantity.owner);
    const auto side = static_cast<std::size_t>(row.quantity.side == Side::child ? 1 : 0);
    const int c = row.quantity.component;
    expect(is_element(row) ? "element" : "joint",
           is_element(row) ? model.elements[owner].name : model.joints[owner].name);
    expect("side", kSides[side]);
    expect("component", kComponents[static_cast<std::size_t>(c)]);
    expect("unit", unit_of_component(static_cast<std::size_t>(c)));
    expect("scale", row.scale);
    expect("unique", row.unique);
    expect("same_state_digits", row.unique ? two_decimals(row.same_state) : Json());
    expect("own_digits", row.unique ? two_decimals(row.same_run) : Json());
    expect("verdict", word_of(row.judgement, "not_judged"));
    const auto pick = [&](const Sample& sample) {
      const Wrench& wrench = is_element(row) ? sample.evaluation.elements.at(owner).on[side].in_C
                                             : sample.evaluation.joints.at(owner).reaction[side].in_C;
      return c < 3 ? wrench.force(c) : wrench.torque(c - 3);
    };
    expect("values", {{verdict.solvers[0].name, numbers_over_time(0, pick)},
                      {verdict.solvers[1].name, numbers_over_time(1, pick)}});
  }
  document.expect_size(document.all, "numbers", result.numbers.size());
  for (std::size_t k = 0; k < result.numbers.size(); ++k) {
    const compare::analyses::NumberRow& row = result.numbers[k];
    const Json& found = document.entry("numbers", k);
    document.expect(found, "name", row.name);
    document.expect(found, "unit", row.unit, row.name + ": ");
    document.expect(found, "cartesian", number(row.values[0]), row.name + ": ");
    document.expect(found, "relative", number(row.values[1]), row.name + ": ");
    document.expect(found, "digits", two_decimals(row.digits), row.name + ": ");
    document.expect(found, "need", row.need, row.name + ": ");
  }
  for (std::size_t k = 0; k < result.forces.size(); ++k) {
    const compare::analyses::AppliedForceRow& row = result.forces[k];
    const Json& found = document.entry("forces", k);
    document.expect(found, "driven", row.name);
    document.expect(found, "acceleration", row.acceleration, row.name + ": ");
    document.expect(found, "cartesian", row.tau[0], row.name + ": ");
    document.expect(found, "relative", row.tau[1], row.name + ": ");
  }
  for (std::size_t who = 0; who < 2; ++who) {
    if (!result.linearizations[who]) continue;
    Json modes = Json::array();
    for (const compare::analyses::Mode& mode : result.linearizations[who]->modes) {
      Json shape = Json::array();
      for (const auto& part : mode.shape) shape.push_back({part.real(), part.imag()});
      modes.push_back({{"eigenvalue", {mode.eigenvalue.real(), mode.eigenvalue.imag()}},
                       {"frequency_hz", mode.frequency()},
                       {"damping_ratio", mode.damping_ratio()},
                       {"free", mode.is_free},
                       {"motion", mode.motion},
                       {"shape", shape}});
    }
    document.expect(document.all.value("modes", Json()), verdict.solvers[who].name.c_str(), modes);
  }
  return document.complaints();
}

}  // namespace concord::read_back
