#include "compare/report/explanations.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "compare/report/report_json.h"
#include "compare/report/result_document.h"
#include "compare/verdict/verify.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

using Json = nlohmann::ordered_json;

class ExplanationsTest : public ::testing::Test {
 protected:
  Verdict found() { return verify(model_, cartesian_, relative_, {}); }

  Model model_ = pendulum_model();
  FakePendulum cartesian_{model_, "cartesian"};
  FakePendulum relative_{model_, "relative"};
};

TEST_F(ExplanationsTest, AreAbsentWhereThereIsNothingToExplain) {
  Json said = Json::object();
  add_explanations(said, model_, found());
  EXPECT_TRUE(said.empty()) << said;
}

TEST_F(ExplanationsTest, StandInTheVerdictAndInTheResultFileAlike) {
  relative_.spoil = [](const State&, Evaluation& evaluation) {
    evaluation.joints[0].reaction[1].in_C.force(0) *= 1.001;
  };
  Verdict verdict = found();
  verdict.references.push_back({.of = "joint A on bob", .component = "F_x", .unit = "N", .peak = 3.0});
  verdict.third.emplace().name = "another";
  const Json result = Json::parse(format_result(model_, verdict));
  const Json document = Json::parse(format_json(model_, verdict));
  EXPECT_EQ(result.at("attribution").at("solver"), "relative");
  EXPECT_EQ(result.at("attribution").at("place"), "joint A");
  for (const char* key : {"attribution", "reference", "third_opinion"}) EXPECT_EQ(result.at(key), document.at(key));
}

TEST(DigitsJson, HaveTwoDecimalsRoundedDownOrAreNull) {
  EXPECT_EQ(digits_json(12.349), Json(12.34));
  EXPECT_TRUE(digits_json({}).is_null());
}

}  // namespace
}  // namespace concord::compare
