#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <cmath>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <set>

#include "cartesian/solver.h"
#include "common/error.h"
#include "common/model_file.h"
#include "compare/table.h"
#include "compare/verify.h"
#include "relative/solver.h"
#include "tests/faults/planted.h"

namespace concord::compare {
namespace {

/// What a fault in one solver, or in what both share, comes to.
struct Outcry {
  std::string rung = "not caught";
  std::set<std::string> red;  // joints and force elements that differ, or that a refusal names
  std::string blamed = "-";   // whom the first finding names
  std::string audited = "-";  // the solver that the third opinion refutes
};

bool has_joint_or_element(Kind kind) { return kind != Kind::acceleration && kind != Kind::body_sum; }

const std::string& owner_of(const Model& model, const Quantity& quantity) {
  return quantity.kind == Kind::element ? model.elements[quantity.owner].name : model.joints[quantity.owner].name;
}

/// Of joints, force elements and bodies: a solver's own check may name the body that is out of balance.
std::vector<std::string> names_of(const Model& model) {
  std::vector<std::string> names;
  for (const Joint& joint : model.joints) names.push_back(joint.name);
  for (const ForceElement& element : model.elements) names.push_back(element.name);
  for (std::size_t i = 1; i < model.bodies.size(); ++i) names.push_back(model.bodies[i].name);
  return names;
}

/// Whether the name stands in the text as a word.
bool names(const std::string& text, const std::string& name) {
  const auto is_letter = [&](std::size_t at) {
    return at < text.size() && std::isalnum(static_cast<unsigned char>(text[at]));
  };
  for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + 1)) {
    if ((at == 0 || !is_letter(at - 1)) && !is_letter(at + name.size())) return true;
  }
  return false;
}

std::string first_rung_below_need(const Verdict& verdict) {
  if (!verdict.failures.empty()) return "refused";
  if (!verdict.same_state.climbed) return "same state";
  if (!verdict.audit.climbed) return "audit";
  if (!verdict.same_run.climbed) return "same run";
  if (!verdict.refined.climbed) return "refined";
  return verdict.outcome == Outcome::agree ? "not caught" : "energy";
}

Outcry look(const Model& model) {
  Outcry found;
  const auto cartesian = cartesian::make_solver(model);
  const auto relative = relative::make_solver(model);
  Verdict verdict;
  try {
    verdict = verify(model, *cartesian, *relative, {});
  } catch (const InputError& error) {
    verdict.failures.emplace_back(error.what());
  }
  found.rung = first_rung_below_need(verdict);
  for (const auto* rows : {&verdict.rows, &verdict.others}) {
    for (const Row& row : *rows) {
      if (!has_joint_or_element(row.quantity.kind) || !row.same_state) continue;
      if (*row.same_state < row.need.same_state) found.red.insert(owner_of(model, row.quantity));
    }
  }
  std::vector<std::string> told = verdict.failures;
  for (const Finding& finding : verdict.findings) told.push_back(finding.what);
  for (const std::string& name : names_of(model)) {
    if (std::any_of(told.begin(), told.end(), [&](const std::string& text) { return names(text, name); })) {
      found.red.insert(name);
    }
    if (!told.empty() && found.blamed == "-" && names(told.front(), name)) found.blamed = name;
  }
  for (const SolverSummary& solver : verdict.solvers) {
    if (!solver.audit_digits || *solver.audit_digits >= solver.audit_need) continue;
    found.audited = found.audited == "-" ? solver.name : "both";
  }
  return found;
}

TEST_CASE("Every planted fault is caught, at the joint or force element where it sits") {
  std::ifstream file(CONCORD_FAULTS "/catalogue.json");
  const auto catalogue = nlohmann::json::parse(file);
  REQUIRE(catalogue.size() >= 30);
  std::vector<std::vector<std::string>> lines{
      {"fault", "planted in", "caught by", "looked for at", "first blamed", "audit refutes", "red"}};
  const auto model_of = [](const nlohmann::json& fault) {
    return read_model(std::string(CONCORD_FAULTS "/") + fault["machine"].get<std::string>() + ".toml");
  };
  std::set<std::string> machines;
  for (const auto& fault : catalogue) {
    if (machines.insert(fault["machine"]).second) REQUIRE(look(model_of(fault)).rung == "not caught");
  }
  for (std::size_t k = 0; k < catalogue.size(); ++k) {
    const auto& fault = catalogue[k];
    const std::string where = fault["joint"];
    const Model model = model_of(fault);
    faults::planted = static_cast<int>(k);
    const Outcry found = look(model);
    faults::planted = -1;
    lines.push_back({fault["name"], fault["file"], found.rung, where, found.blamed, found.audited,
                     std::to_string(found.red.size())});
    INFO(fault["name"]);
    CHECK(found.rung != "not caught");
    CHECK(found.red.count(where) == 1);
    const std::string file = fault["file"];
    if (file.substr(0, 7) == "common/") {
      CHECK(found.audited == "both");  // only the third opinion can see what both solvers take from there
    } else if (found.audited != "-") {
      CHECK(file.substr(0, found.audited.size()) == found.audited);
    }
  }
  std::cout << format_table(lines, std::vector<bool>(lines.front().size(), false)) << std::flush;
}

}  // namespace
}  // namespace concord::compare
