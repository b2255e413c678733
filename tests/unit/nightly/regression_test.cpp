#include "compare/nightly/regression.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace concord::compare::nightly {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;

Result sound() {
  Result one;
  one.id = "crank";
  one.definition = "as ever";
  one.ending = Ending::agree;
  one.cost = {Cost{"ida", 100, 1000}, Cost{"gbs", 20, 500}};
  for (const char* name : {"A, F_x", "A, F_y", "B, T_z"}) {
    Component& component = one.components.emplace_back();
    component.name = name;
    component.same_state = 13.0;
    component.resolvable = 13.5;
    component.same_run = 9.0;
    component.refined = 11.0;
    component.peak = 40.0;
    component.scale = 50.0;
  }
  return one;
}

std::vector<std::string> told(const std::vector<Change>& changes) {
  std::vector<std::string> all;
  for (const Change& change : changes) all.push_back(to_string(change.kind) + " " + change.measure);
  return all;
}

std::vector<std::string> changes_to(const Result& now) { return told(changes_between(sound(), now, {}, "baseline")); }

const Origin kHere{"concord 1", "abc", "gcc", "this one"};

Case ordinary() {
  Case one;
  one.id = "crank";
  return one;
}

std::vector<std::string> judged(const Case& one, const Result& now, const Result* baseline,
                                const std::vector<Entry>& earlier, const Judging& judging,
                                const std::string& today = "2026-05-05") {
  return told(judge_case(one, now, baseline, earlier, kHere, judging, today));
}

Entry night(long id, const Result& result, const std::string& commit = "before") {
  Entry entry;
  entry.night.id = id;
  entry.night.origin = kHere;
  entry.night.origin.commit = commit;
  entry.result = result;
  return entry;
}

}  // namespace

TEST(Changes, NothingIsToldOfEqualResults) { EXPECT_THAT(changes_to(sound()), IsEmpty()); }

TEST(Changes, FallOfTwoDigitsIsFoundInEachCheck) {
  Result now = sound();
  now.components[1].same_run = 7.0;
  EXPECT_THAT(changes_to(now), ElementsAre("worse same run"));
  now.components[0].refined = 9.0;
  now.components[2].same_state = 10.0;
  EXPECT_THAT(changes_to(now), ElementsAre("worse refined", "worse same run", "worse same state"));
  now = sound();
  now.components[1].same_run = 11.0;
  EXPECT_THAT(changes_to(now), ElementsAre("better same run"));
}

TEST(Changes, WorstComponentIsNamedAndTheOthersAreCounted) {
  Result now = sound();
  now.components[0].same_run = 7.5;
  now.components[2].same_run = 6.0;
  const auto changes = changes_between(sound(), now, {}, "baseline");
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].component, "B, T_z");
  EXPECT_EQ(changes[0].was, "9.0");
  EXPECT_EQ(changes[0].is, "6.0");
  EXPECT_EQ(changes[0].more, 1);
}

TEST(Changes, DigitsBeyondWhatIsResolvedAreLuck) {
  Result then = sound();
  then.components[0].same_state = 16.0;
  Result now = sound();
  now.components[0].same_state = 12.3;  // within 20 resolutions
  EXPECT_THAT(told(changes_between(then, now, {}, "")), IsEmpty());
  now.components[0].resolvable = 11.0;  // a solver that lost digits
  EXPECT_THAT(told(changes_between(then, now, {}, "")), ElementsAre("worse same state"));
}

TEST(Changes, RiseOfEvaluationsByAFifthIsFoundWallTimeNever) {
  Result now = sound();
  now.wall_s = 1000.0;
  now.cost[1].evaluations = 560;
  EXPECT_THAT(changes_to(now), IsEmpty());
  now.cost[1].evaluations = 600;
  EXPECT_THAT(changes_to(now), ElementsAre("worse evaluations of relative"));
  now.cost[1].evaluations = 400;
  EXPECT_THAT(changes_to(now), ElementsAre("better evaluations of relative"));
  now.cost[1].evaluations = 500;
  now.cost[0].steps = 121;
  EXPECT_THAT(changes_to(now), ElementsAre("worse steps of cartesian"));
}

/// Where round-off decides the steps, a suite says how much they may change.
TEST(Changes, CaseWithAnAllowanceOfItsOwnIsJudgedByIt) {
  Result now = sound();
  now.cost[1].evaluations = 700;
  Judging judging;
  judging.of_case[now.id] = {1.0, 0.5, 1e-4};
  EXPECT_THAT(told(changes_between(sound(), now, judging, "")), IsEmpty());
  now.cost[1].evaluations = 760;
  EXPECT_THAT(told(changes_between(sound(), now, judging, "")), ElementsAre("worse evaluations of relative"));
  now.id = "other";
  now.cost[1].evaluations = 700;
  EXPECT_THAT(told(changes_between(sound(), now, judging, "")), ElementsAre("worse evaluations of relative"));
}

TEST(Changes, PeakMayMoveByItsShareOfTheScale) {
  Result now = sound();
  now.components[0].peak = 40.004;
  EXPECT_THAT(changes_to(now), IsEmpty());
  now.components[0].peak = 39.99;
  EXPECT_THAT(changes_to(now), ElementsAre("worse peak"));
}

TEST(Changes, ComponentsComeAndGo) {
  Result now = sound();
  now.components.erase(now.components.begin());
  EXPECT_THAT(changes_to(now), ElementsAre("gone component"));
  now = sound();
  now.components.push_back(now.components.back());
  now.components.back().name = "C, F_x";
  EXPECT_THAT(changes_to(now), ElementsAre("new component"));
  now = sound();
  now.components[0].refined.reset();
  EXPECT_THAT(changes_to(now), ElementsAre("worse refined"));
}

TEST(Changes, LostCaseTellsItsEndingAlone) {
  Result now;
  now.id = "crank";
  now.ending = Ending::crashed;
  EXPECT_THAT(changes_to(now), ElementsAre("worse ending"));
}

TEST(Judgement, MissingBaselineIsFour) {
  const Result now = sound();
  EXPECT_THAT(judged(ordinary(), now, nullptr, {}, {}), ElementsAre("no baseline baseline"));
  const auto changes = judge_case(ordinary(), now, nullptr, {}, kHere, {}, "2026-05-05");
  EXPECT_EQ(exit_code(changes.at(0), now.ending), 4);
  Judging by_median;
  by_median.against_baseline = false;
  by_median.against_median = true;
  EXPECT_THAT(judged(ordinary(), now, nullptr, {}, by_median), IsEmpty());
}

TEST(Judgement, RedIsRedUnlessItIsKnownAndOnlyUntilItsDay) {
  Result now = sound();
  now.ending = Ending::differ;
  const Result baseline = sound();
  EXPECT_THAT(judged(ordinary(), now, &baseline, {}, {}), ElementsAre("red ending"));
  Case known = ordinary();
  known.known_red = KnownRed{"being mended", "2026-05-05"};
  EXPECT_THAT(judged(known, now, &baseline, {}, {}), ElementsAre("known red ending"));
  EXPECT_THAT(judged(known, now, &baseline, {}, {}, "2026-05-06"), ElementsAre("red ending"));
  EXPECT_THAT(judged(known, sound(), &baseline, {}, {}), ElementsAre("better ending"));
  now.ending = Ending::crashed;
  EXPECT_THAT(judged(known, now, &baseline, {}, {}), ElementsAre("red ending")) << "another end than the known one";
  const auto told_on = [&](const std::string& today) {
    return judge_case(known, now, &baseline, {}, kHere, {}, today).at(0).was;
  };
  EXPECT_EQ(told_on("2026-05-05"), "known red, but for what a solver answers: this is no answer");
  EXPECT_EQ(told_on("2026-05-06"), "known red until 2026-05-05, which is over");
}

TEST(Judgement, KnownRedIsNoExcuseForAnotherEndThanTheAcceptedOne) {
  Result baseline = sound();
  baseline.ending = Ending::differ;
  Result now = baseline;
  Case known = ordinary();
  known.known_red = KnownRed{"being mended", "2026-05-05"};
  EXPECT_THAT(judged(known, now, &baseline, {}, {}), ElementsAre("known red ending"));
  now.ending = Ending::failed;
  EXPECT_THAT(judged(known, now, &baseline, {}, {}), ElementsAre("red ending"));
  EXPECT_EQ(judge_case(known, now, &baseline, {}, kHere, {}, "2026-05-05").at(0).was,
            "known red, accepted as 'differ'");
  const auto advice = judge_case(known, now, nullptr, {}, kHere, {}, "2026-05-05").at(1).is;
  EXPECT_EQ(advice, "run concord accept") << "which takes what is known to be red";
}

TEST(Judgement, LostCoverageIsWorse) {
  Result baseline = sound();
  baseline.judged = baseline.total = 3;
  Result now = baseline;
  now.judged = 2;
  EXPECT_THAT(judged(ordinary(), now, &baseline, {}, {}), ElementsAre("worse judged"));
}

/// Finds a night that calls a model that was changed on purpose worse.
TEST(Judgement, NumbersOfAnotherModelAreChangedAndNeitherWorseNorBetter) {
  Result baseline = sound();
  baseline.judged = baseline.total = 3;
  Result now = baseline;
  now.definition = "a heavier crank";
  EXPECT_THAT(judged(ordinary(), now, &baseline, {}, {}), IsEmpty()) << "nothing differs";
  now.judged = 2;
  now.components[0].same_run = 7.0;
  now.components[1].refined = 13.0;
  now.components[2].peak = 60.0;
  now.components.pop_back();
  now.cost[0].evaluations = 5000;
  const auto changes = judge_case(ordinary(), now, &baseline, {}, kHere, {}, "2026-05-05");
  EXPECT_THAT(told(changes), ElementsAre("changed component", "changed evaluations of cartesian", "changed judged",
                                         "changed refined", "changed same run"));
  for (const Change& change : changes) EXPECT_EQ(exit_code(change, now.ending), 4) << change.measure;
  baseline.definition.clear();
  EXPECT_THAT(judged(ordinary(), now, &baseline, {}, {}), Contains("worse same run")) << "asked nobody knows what";
  baseline.definition = "the crank";
  now.ending = Ending::differ;
  EXPECT_THAT(judged(ordinary(), now, &baseline, {}, {}), Contains("red ending")) << "no model excuses that";
  EXPECT_THAT(told(changes_between(baseline, now, {}, "A")), Contains("worse ending"));
}

TEST(Judgement, MedianOfGreenNightsOfTheSameQuestionIsWhatCounts) {
  Judging judging;
  judging.against_baseline = false;
  judging.against_median = true;
  Result lucky = sound();
  lucky.components[0].same_run = 12.0;
  Result red = sound();
  red.ending = Ending::differ;
  red.components[0].same_run = 1.0;
  Result other = sound();
  other.definition = "something else";
  other.cost[1].evaluations = 5;
  const std::vector<Entry> earlier{night(5, sound()), night(4, lucky), night(3, red), night(2, other),
                                   night(1, sound())};
  EXPECT_THAT(judged(ordinary(), sound(), nullptr, earlier, judging), IsEmpty());
  Result now = sound();
  now.components[0].same_run = 7.0;
  const auto changes = judge_case(ordinary(), now, nullptr, earlier, kHere, judging, "2026-05-05");
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].against, "median of 3 nights");
  EXPECT_EQ(changes[0].was, "9.0");
}

TEST(Judgement, OneProgramWithTwoResultsIsFlaky) {
  const Result baseline = sound();
  Result earlier = sound();
  earlier.cost[0].evaluations = 1001;
  EXPECT_THAT(judged(ordinary(), sound(), &baseline, {night(3, earlier, "abc")}, {}),
              ElementsAre("flaky same program"));
  EXPECT_THAT(judged(ordinary(), sound(), &baseline, {night(3, earlier, "another commit")}, {}), IsEmpty());
}

TEST(Codes, WorstIsNoVerdictThenBadInputThenDifferThenMissing) {
  EXPECT_EQ(worse_code(4, 1), 1);
  EXPECT_EQ(worse_code(0, 4), 4);
  EXPECT_EQ(worse_code(1, 2), 2);
  EXPECT_EQ(worse_code(3, 2), 3);
}

}  // namespace concord::compare::nightly
