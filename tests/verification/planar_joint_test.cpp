#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "../conformance/free_axes.h"
#include "../unit/fake_pendulum.h"
#include "compare/audit/balance.h"
#include "compare/report/report_json.h"
#include "judged_machines.h"

/// A component that a joint cannot carry: zero by both solvers is no agreement, and anything else a breach.
namespace concord::verification {
namespace {

/// A body that slides and turns on a tilted plane and is pulled by a strut.
Model body_on_a_plane() {
  Model model = compare::sprung_pendulum_model();
  model.name = "body_on_a_plane";
  Joint& joint = model.joints[0];
  joint.type = &joints::planar;
  joint.springs.clear();
  model.elements.resize(1);
  joint.start.clear();
  for (const auto& [q, u] : {std::pair{0.13, -0.4}, {-0.21, 0.7}, {0.7, 3.1}}) {
    joint.start.push_back({StartRole::keep, StartRole::keep, VecX::Constant(1, q), VecX::Constant(1, u)});
  }
  return model;
}

}  // namespace

TEST_CASE("Of a planar joint only the force across its plane and the torques in it are judged, on both sides",
          "[planar][quick]") {
  const Model model = body_on_a_plane();
  const compare::Verdict verdict = judged(model, in_short(model, 1.0));
  const std::string table = compare::format_verdict(model, verdict, true);
  INFO(table);
  REQUIRE(verdict.outcome == compare::Outcome::agree);
  CHECK(verdict.judged == 6);
  CHECK(verdict.total == 6);
  const auto json = nlohmann::json::parse(compare::format_json(model, verdict));
  std::vector<std::string> components;
  for (const auto& row : json["joints"]) components.push_back(row["component"]);
  CHECK(components == std::vector<std::string>{"F_z", "T_x", "T_y", "F_z", "T_x", "T_y"});
  CHECK(json["judged"] == 6);
}

TEST_CASE("A torque that a planar joint cannot carry is a breach of the audit, on either side", "[planar][quick]") {
  const Model model = body_on_a_plane();
  const auto solver = relative::make_solver(model);
  const State state = solver->assemble();
  for (const Side side : kSides) {
    Evaluation evaluation = solver->evaluate(state);
    evaluation.joints[0].reaction[index(side)].in_C.torque(2) += 1e-3;
    compare::Auditor auditor(model);
    auditor.add(state, evaluation);
    const compare::AuditFinding finding =
        auditor.report().rules[static_cast<std::size_t>(compare::AuditRule::workless)];
    INFO(finding.text());
    CHECK_FALSE(finding.holds());
    CHECK_THAT(finding.row,
               Catch::EndsWith(side == Side::parent ? "T_z of reaction on parent" : "T_z of reaction on child"));
  }
}

}  // namespace concord::verification
