#include "compare/quantities/third_opinion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "compare/report/report_json.h"
#include "compare/report/table.h"
#include "compare/report/table_parts.h"
#include "compare/verdict/third_words.h"
#include "compare/verdict/verify.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {

namespace {

using testing::AllOf;
using testing::Contains;
using testing::Field;
using testing::HasSubstr;

/// The pendulum once more, as another program that can be spoiled.
class OtherPendulum final : public ThirdOpinion {
 public:
  explicit OtherPendulum(const Model& model) : pendulum(model, "other") {}

  [[nodiscard]] std::string_view name() const override { return "other"; }
  Evaluation evaluate(const State& state) override {
    if (state.t > fails_after) throw SolverError("other: lost at " + std::to_string(state.t));
    return pendulum.evaluate(state);
  }

  FakePendulum pendulum;
  double fails_after = 1e9;
};

ThirdRow row_of(double cartesian, double relative, double between) {
  ThirdRow row;
  row.solvers_need = 12.0;
  row.shared = {Accord{cartesian, cartesian}, Accord{relative, relative}};
  row.between = {between, between};
  return row;
}

TEST(Blame, FollowsTheMajority) {
  EXPECT_EQ(blame_in(row_of(14.0, 13.5, 14.2)), Blame::nobody);
  EXPECT_EQ(blame_in(row_of(9.1, 9.1, 14.2)), Blame::nobody);
  EXPECT_EQ(blame_in(row_of(8.9, 8.9, 14.2)), Blame::third);
  EXPECT_EQ(blame_in(row_of(13.0, 4.0, 4.0)), Blame::relative);
  EXPECT_EQ(blame_in(row_of(4.0, 13.0, 4.0)), Blame::cartesian);
  // The solvers miss their own need by little: the third opinion still tells them apart.
  EXPECT_EQ(blame_in(row_of(13.0, 11.0, 11.0)), Blame::relative);
}

TEST(Blame, IsUnclearWhereAllDiffer) {
  EXPECT_EQ(blame_in(row_of(3.0, 3.1, 3.2)), Blame::unclear);
  EXPECT_EQ(blame_in(row_of(0.1, 0.2, 5.0)), Blame::unclear);
}

TEST(Blame, DoesNotCountRoundOff) {
  ThirdRow row = row_of(7.0, 7.0, 14.0);
  row.shared = {Accord{7.0, 16.0}, Accord{7.0, 16.0}};  // all of it is explained by what double precision resolves
  EXPECT_EQ(blame_in(row), Blame::nobody);
}

/// The hinge's force, and a second joint that carries nothing but what the third opinion makes of it.
class EchoWithNoise final : public ThirdOpinion {
 public:
  EchoWithNoise(Evaluation said, double noise) : said_(std::move(said)) {
    said_.joints[1].reaction[1].in_C.force.x() = noise;
  }
  [[nodiscard]] std::string_view name() const override { return "echo"; }
  Evaluation evaluate(const State&) override { return said_; }

 private:
  Evaluation said_;
};

TEST(AskThird, AllowsForRoundOffOfTheWholeMachine) {
  Model model = pendulum_model();
  FakePendulum pendulum(model, "cartesian");
  const State state = pendulum.assemble();
  Evaluation said = pendulum.evaluate(state);
  said.joints.push_back(said.joints[0]);
  said.joints[1].reaction = said.joints[1].total = {};
  model.joints.push_back(model.joints[0]);
  const QuantityLayout layout(model);
  const auto rows = static_cast<Eigen::Index>(layout.quantities().size());
  const Mask everywhere = Mask::Constant(rows, 1, true);
  const MatX fine = MatX::Constant(rows, 1, 1e-300);
  const auto blame_for = [&](double noise) {
    EchoWithNoise third(said, noise * said.joints[0].reaction[1].in_C.force.norm());
    const ThirdReport report = ask_third(layout, third, {{state, {said, said}, 0}}, {&fine, &everywhere});
    const Quantity of_second{Kind::reaction, 1, Side::child, 0};
    const auto row = std::find_if(report.rows.begin(), report.rows.end(),
                                  [&](const ThirdRow& one) { return one.quantity == of_second; });
    return blame_in(*row);
  };
  EXPECT_EQ(blame_for(1e-15), Blame::nobody);  // nine digits of a millionth of the machine's force would be 1e-15
  EXPECT_EQ(blame_for(3e-15), Blame::nobody);
  EXPECT_EQ(blame_for(1e-13), Blame::third);
}

class ThirdOpinions : public testing::Test {
 protected:
  Verdict verdict() {
    VerifyOptions options;
    options.until = 0.2;
    options.samples = 10;
    options.states = 20;
    options.refines = false;
    options.third = &other;
    return verify(model, cartesian, relative, options);
  }

  Model model = pendulum_model();
  FakePendulum cartesian{model, "cartesian"};
  FakePendulum relative{model, "relative"};
  OtherPendulum other{model};
};

/// A wrong force of the hinge on the bob.
void spoil_force(const State&, Evaluation& found) { found.joints[0].reaction[1].in_C.force.x() += 0.01; }

TEST_F(ThirdOpinions, AreOneLineAndATableWhereAllAgree) {
  const Verdict found = verdict();
  EXPECT_EQ(found.outcome, Outcome::agree);
  ASSERT_TRUE(found.third);
  EXPECT_EQ(found.third->states, found.same_state.samples);
  EXPECT_EQ(found.third->digits(Kind::reaction), kMostDigits);
  const std::string table = format_verdict(model, found, false);
  EXPECT_THAT(table, AllOf(HasSubstr("cartesian, other"), HasSubstr("nobody"), HasSubstr("other at "),
                           HasSubstr("reactions 16.0")));
}

TEST_F(ThirdOpinions, SayWhichSolverIsOff) {
  relative.spoil = spoil_force;
  EXPECT_THAT(verdict().notes, Contains(AllOf(HasSubstr("cartesian and other agree to 16.0 digits, relative is off: "),
                                              HasSubstr("F_x"))));
  relative.spoil = [](const State&, Evaluation&) {};
  cartesian.spoil = spoil_force;
  EXPECT_THAT(verdict().notes, Contains(HasSubstr("relative and other agree to 16.0 digits, cartesian is off: ")));
}

TEST_F(ThirdOpinions, MakeADifferenceWhereBothSolversAgree) {
  other.pendulum.spoil = spoil_force;
  const Verdict found = verdict();
  EXPECT_EQ(found.outcome, Outcome::differ);
  EXPECT_THAT(found.findings, Contains(Field(&Finding::what, AllOf(HasSubstr("cartesian and relative agree"),
                                                                   HasSubstr("other is off"), HasSubstr("(need 9)")))));
}

TEST_F(ThirdOpinions, KeepToTheModelsLowerNeeds) {
  other.pendulum.spoil = spoil_force;
  NeedOverride low;
  low.same_state = 1.0;
  low.because = "a test";
  model.needs.push_back(low);
  EXPECT_EQ(verdict().outcome, Outcome::agree);
}

TEST_F(ThirdOpinions, CountStatesInWhichTheyFail) {
  other.fails_after = 0.1;
  const Verdict found = verdict();
  EXPECT_EQ(found.outcome, Outcome::agree);
  EXPECT_GT(found.third->failed, 0);
  EXPECT_THAT(found.notes, Contains(AllOf(HasSubstr("other failed in "), HasSubstr("lost at"))));
  other.fails_after = -1.0;
  const Verdict none = verdict();
  EXPECT_EQ(none.outcome, Outcome::failed);
  EXPECT_THAT(none.failures, Contains(HasSubstr("other failed in ")));
}

TEST_F(ThirdOpinions, StandInTheJson) {
  Verdict found = verdict();
  const auto said = nlohmann::json::parse(format_json(model, found))["third_opinion"];
  EXPECT_EQ(said["name"], "other");
  EXPECT_EQ(said["failed"], 0);
  ASSERT_FALSE(said["rows"].empty());
  EXPECT_EQ(said["rows"][0]["off"], "nobody");
  EXPECT_EQ(said["rows"][0]["cartesian_digits"], 16.0);
  found.third->not_expressible = "body bob is flexible";
  const auto silent = nlohmann::json::parse(format_json(model, found))["third_opinion"];
  EXPECT_EQ(silent["not_expressible"], "body bob is flexible");
  EXPECT_THAT(format_third(model, found, false), HasSubstr("other was not asked: body bob is flexible"));
}

}  // namespace

}  // namespace concord::compare
