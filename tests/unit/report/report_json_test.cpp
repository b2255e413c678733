#include "compare/report/report_json.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "compare/quantities/observe.h"
#include "compare/verdict/verify.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

using Json = nlohmann::ordered_json;
using ::testing::ElementsAre;

std::vector<std::string> keys(const Json& object) {
  std::vector<std::string> names;
  for (const auto& [name, value] : object.items()) names.push_back(name);
  return names;
}

class ReportJsonTest : public ::testing::Test {
 protected:
  Json document() { return Json::parse(format_json(model_, verify(model_, cartesian_, relative_, {}))); }

  Model model_ = pendulum_model();
  FakePendulum cartesian_{model_, "cartesian"};
  FakePendulum relative_{model_, "relative"};
};

TEST_F(ReportJsonTest, HasTheseKeys) {
  const Json json = document();
  EXPECT_THAT(keys(json), ElementsAre("format", "name", "verdict", "judged", "total", "same_state", "same_run",
                                      "refined", "audit", "joints", "solvers", "forces"));
  for (const char* check : {"same_state", "same_run", "refined", "audit"}) {
    EXPECT_THAT(keys(json[check]), ElementsAre("digits"));
  }
  EXPECT_THAT(keys(json["joints"][0]),
              ElementsAre("joint", "side", "component", "scale", "scale_from", "unique", "states", "same_state_digits",
                          "same_state_resolvable_digits", "same_state_resolutions", "same_run_digits", "same_run_scale",
                          "refined_digits", "need", "judged_by_resolution", "verdict"));
  EXPECT_THAT(keys(json["joints"][0]["states"]), ElementsAre("judged", "not_unique", "too_coarse"));
  EXPECT_THAT(keys(json["joints"][0]["need"]), ElementsAre("same_state", "same_run", "refined"));
  EXPECT_THAT(keys(json["solvers"]), ElementsAre("cartesian", "relative"));
  EXPECT_THAT(keys(json["solvers"]["relative"]),
              ElementsAre("wall_s", "steps", "evaluations", "max_constraint", "energy_error", "energy_drift"));
  EXPECT_THAT(keys(json["forces"][0]),
              ElementsAre("kind", "of", "on", "side", "F", "T", "component", "check", "digits", "need", "verdict"));
  EXPECT_THAT(keys(json["forces"][0]["F"]), ElementsAre("peak", "t", "components"));
}

TEST_F(ReportJsonTest, TellsTheForcesOfTheTable) {
  model_ = sprung_pendulum_model();
  Verdict verdict = verify(model_, cartesian_, relative_, {});
  verdict.unique.value().row(QuantityLayout(model_).first_row(Kind::reaction, 0, Side::child)).setConstant(false);
  for (int c = 3; c < 6; ++c) {
    verdict.unique.value().row(QuantityLayout(model_).first_row(Kind::reaction, 0, Side::child) + c).setConstant(false);
  }
  verdict.trajectories[0]->samples[9].evaluation.joints[0].reaction[1].in_C.force = {1e6, 3e4, -4e4};
  const Json forces = Json::parse(format_json(model_, verdict))["forces"];
  EXPECT_EQ(forces[1]["of"], "A");
  EXPECT_EQ(forces[1]["on"], "bob");
  EXPECT_EQ(forces[1]["F"]["components"], "yz");
  EXPECT_DOUBLE_EQ(forces[1]["F"]["peak"].get<double>(), 5e4);
  EXPECT_EQ(forces[1]["F"]["t"], verdict.trajectories[0]->samples[9].state.t);
  EXPECT_EQ(forces[1]["T"], Json({{"not_unique", true}}));
  EXPECT_EQ(forces[1]["verdict"], "agree");
  const auto spring =
      std::find_if(forces.begin(), forces.end(), [](const Json& row) { return row["kind"] == "actor"; });
  ASSERT_NE(spring, forces.end());
  EXPECT_EQ((*spring)["of"], "spring of joint A");
  EXPECT_EQ((*spring)["along"], "turn_z");
  EXPECT_EQ((*spring)["unit"], "N m");
  EXPECT_THAT(keys((*spring)["force"]), ElementsAre("peak", "t", "rms"));
}

TEST_F(ReportJsonTest, SaysWhatWasFound) {
  const Json json = document();
  EXPECT_EQ(json["format"], 1);
  EXPECT_EQ(json["verdict"], "agree");
  EXPECT_EQ(json["judged"], 10);
  EXPECT_EQ(json["total"], 10);
  EXPECT_EQ(json["joints"].size(), 10U);
  EXPECT_EQ(json["same_state"]["digits"], 16.0);
  EXPECT_GE(json["audit"]["digits"], 9.0);
  EXPECT_EQ(json["joints"][0]["joint"], "A");
  EXPECT_EQ(json["joints"][0]["side"], "parent");
  EXPECT_EQ(json["joints"][9]["component"], "T_y");
  EXPECT_EQ(json["joints"][9]["verdict"], "agree");
}

TEST_F(ReportJsonTest, OrdersThatWereAskedForStandInIt) {
  cartesian_.drift = relative_.drift = 2.0;
  VerifyOptions options;
  options.orders = true;
  const Json json = Json::parse(format_json(model_, verify(model_, cartesian_, relative_, options)));
  const Json& orders = json["orders"];
  EXPECT_THAT(keys(orders), ElementsAre("rtol", "against", "cartesian", "relative"));
  EXPECT_EQ(orders["rtol"].size(), 3U);
  EXPECT_THAT(keys(orders["relative"]), ElementsAre("places", "velocities", "reactions"));
  EXPECT_NEAR(orders["relative"]["places"]["order"].get<double>(), 1.0, 0.01);
  EXPECT_EQ(orders["relative"]["places"]["errors"].size(), 3U);
}

TEST_F(ReportJsonTest, WorstDigitsAreTheWorstOfTheRows) {
  relative_.drift = 300.0;
  const Json json = document();
  double worst = 16.0;
  for (const Json& row : json["joints"]) worst = std::min(worst, row["same_run_digits"].get<double>());
  EXPECT_EQ(json["same_run"]["digits"], worst);
  EXPECT_LT(worst, 10.0);
}

TEST_F(ReportJsonTest, WhatIsNotUniqueIsNotJudged) {
  const auto redundant = [](RankReport& report) { report.joints[0].unique[0][0] = false; };
  cartesian_.spoil_rank = relative_.spoil_rank = redundant;
  const Json json = document();
  EXPECT_EQ(json["joints"][0]["unique"], false);
  EXPECT_EQ(json["joints"][0]["verdict"], "not_judged");
  EXPECT_TRUE(json["joints"][0]["same_state_digits"].is_null());
  EXPECT_EQ(json["judged"], 9);
}

TEST_F(ReportJsonTest, AFailedRunIsStillADocument) {
  relative_.cannot_integrate = true;
  const Json json = document();
  EXPECT_EQ(json["verdict"], "failed");
  EXPECT_TRUE(json["same_run"]["digits"].is_null());
  EXPECT_TRUE(json["solvers"]["relative"]["energy_error"].is_null());
  ASSERT_EQ(json["failures"].size(), 1U);
  EXPECT_THAT(json["failures"][0].get<std::string>(), testing::HasSubstr("same run"));
}

TEST_F(ReportJsonTest, ADifferenceIsNamedWithWhatItLooksLike) {
  relative_.spoil = [](const State&, Evaluation& evaluation) {
    evaluation.joints[0].reaction[1].in_C.force(0) *= 1.001;
  };
  const Json json = document();
  EXPECT_EQ(json["verdict"], "differ");
  ASSERT_FALSE(json["findings"].empty());
  EXPECT_THAT(json["findings"][0]["what"].get<std::string>(), testing::HasSubstr("need"));
  EXPECT_FALSE(json["findings"][0]["looks_like"].get<std::string>().empty());
}

TEST_F(ReportJsonTest, ACaseWithoutAVerdictSaysWhy) {
  const ReportedCase refused{"refused", nullptr, nullptr, "refused.toml:3:1: error: no mass\n", true};
  const ReportedCase stopped{"stopped", nullptr, nullptr, "stopped: cannot be closed\n", false};
  const Json json = Json::parse(format_json(std::vector{refused, stopped}));
  EXPECT_EQ(json["refused"]["verdict"], "bad input");
  EXPECT_EQ(json["refused"]["failures"], Json::array({"refused.toml:3:1: error: no mass"}));
  EXPECT_EQ(json["stopped"]["verdict"], "failed");
  EXPECT_TRUE(json["stopped"]["joints"].empty());
  EXPECT_TRUE(json["stopped"]["same_state"]["digits"].is_null());
}

TEST_F(ReportJsonTest, SeveralCasesStandUnderTheirNames) {
  const Verdict verdict = verify(model_, cartesian_, relative_, {});
  Verdict other = verdict;
  other.name = "second";
  const Json json = Json::parse(
      format_json(std::vector<ReportedCase>{{verdict.name, &model_, &verdict, ""}, {other.name, &model_, &other, ""}}));
  EXPECT_THAT(keys(json), ElementsAre("pendulum", "second"));
}

}  // namespace
}  // namespace concord::compare
