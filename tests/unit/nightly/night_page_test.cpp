#include "compare/nightly/night_page.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "compare/nightly/judgement.h"
#include "tests/unit/temporary_folder.h"

namespace concord::compare::nightly {
namespace {

using testing::HasSubstr;
using testing::Not;

Origin made_by(const std::string& commit) { return {"concord 1", commit, "gcc", "this one"}; }

Result result_of_night(const std::string& id, double digits) {
  Result one;
  one.id = id;
  one.work = "compare";
  one.definition = "as ever";
  one.ending = Ending::agree;
  one.judged = one.total = 1;
  one.cost = {Cost{"ida", 10, 100}, Cost{"gbs", 5, 70}};
  one.wall_s = 0.25;
  Component& force = one.components.emplace_back();
  force.name = "joint A on crank, F_x";
  force.same_state = 14.0;
  force.resolvable = 13.5;
  force.same_run = digits;
  force.scale = 3.0;
  return one;
}

class NightPages : public ::testing::Test {
 protected:
  /// A finished night; its number.
  long night(const std::string& commit, const std::vector<Result>& results) {
    const std::string now = fmt::format("2026-03-{:02} 02:15:00", ++days_);
    last_ = {history_.begin("suite", "", made_by(commit), now), "suite", "", now, now, made_by(commit)};
    for (const Result& result : results) history_.store(last_.id, result);
    history_.finish(last_.id, now);
    return last_.id;
  }

  /// The page of the last night, judged by the nights before.
  std::string page() {
    Judging judging;
    judging.against_baseline = false;
    judging.against_median = true;
    std::vector<Case> cases;
    for (const std::string& id : history_.case_names(last_.id)) cases.emplace_back().id = id;
    std::vector<const Case*> meant;
    for (const Case& one : cases) meant.push_back(&one);
    NightReport report = judge_night(history_, last_, meant, {}, judging, "2026-03-31");
    report.code = code_of(report);
    return format_night_page({report, last_, judging, 100, {"a note"}}, history_);
  }

  static nlohmann::json data_of(const std::string& page) {
    const std::string start = "<script type=\"application/json\" id=\"data\">";
    const std::size_t from = page.find(start) + start.size();
    return nlohmann::json::parse(page.substr(from, page.find("</script>", from) - from));
  }

  TemporaryFolder folder_;
  History history_{folder_.path() / "nights.sqlite"};
  Night last_;
  int days_ = 0;
};

}  // namespace

// Detects trends in the wrong order or of the wrong night, and steps without the commits on both of their sides.
TEST_F(NightPages, TrendHasItsStepsBetweenTwoCommits) {
  night("aaaa", {result_of_night("crank", 9.0)});
  night("bbbb", {result_of_night("crank", 9.1), result_of_night("other", 8.0)});
  night("cccc", {result_of_night("crank", 6.2)});
  const nlohmann::json data = data_of(page());
  EXPECT_EQ(data.at("sentence"), "The night of suite is red: of 1 case 1 agrees; 1 worse.");
  EXPECT_EQ(data.at("outcome"), "differ");
  EXPECT_EQ(data.at("nights").size(), 3U);
  const nlohmann::json& crank = data.at("cases").at(0);
  EXPECT_EQ(crank.at("past"), "worse");
  EXPECT_EQ(crank.at("trend").at("same_run"), (std::vector<double>{9.0, 9.1, 6.2}));
  EXPECT_EQ(crank.at("trend").at("resolvable"), (std::vector<double>{13.5, 13.5, 13.5}));
  EXPECT_EQ(crank.at("trend").at("evaluations").at(1), (std::vector<long>{70, 70, 70}));
  ASSERT_EQ(crank.at("steps").size(), 1U);
  const nlohmann::json& step = crank.at("steps").at(0);
  EXPECT_EQ(step.at("was"), "9.1");
  EXPECT_EQ(step.at("is"), "6.2");
  EXPECT_EQ(data.at("nights").at(step.at("before").get<int>()).at("commit"), "bbbb");
  EXPECT_EQ(data.at("nights").at(step.at("night").get<int>()).at("commit"), "cccc");
}

// Detects a case that is shown in nights that did not have it, and a lost case whose cost passes for zero.
TEST_F(NightPages, NightWithoutTheCaseIsAGapAndALostCaseHasWordsAndNoCost) {
  night("aaaa", {result_of_night("crank", 9.0)});
  night("bbbb", {});
  Result lost;
  lost.id = "crank";
  lost.ending = Ending::crashed;
  lost.words = "signal 11; last words: </script><b>&\nsecond line";
  night("cccc", {lost});
  const std::string text = page();
  EXPECT_THAT(text, Not(HasSubstr("</script><b>")));
  const nlohmann::json crank = data_of(text).at("cases").at(0);
  EXPECT_EQ(crank.at("words"), lost.words);
  EXPECT_EQ(crank.at("trend").at("ending"), (nlohmann::json{"agree", nullptr, "crashed"}));
  EXPECT_EQ(crank.at("trend").at("steps").at(0), (nlohmann::json{10, nullptr, nullptr}));
}

// Detects steps that are lost without being counted, and a page whose late steps are not its last.
TEST_F(NightPages, OfManyStepsTheLastAreShownAndTheOthersCounted) {
  for (int k = 0; k < 52; ++k) night("aaaa", {result_of_night("crank", k % 2 == 0 ? 9.0 : 6.0)});
  const nlohmann::json crank = data_of(page()).at("cases").at(0);
  EXPECT_EQ(crank.at("steps").size(), 40U);
  EXPECT_EQ(crank.at("steps_left_out"), 11);
  EXPECT_EQ(crank.at("steps").back().at("night"), 51);
}

TEST_F(NightPages, SameHistoryGivesTheSameBytesUnderAStrictPolicy) {
  night("aaaa", {result_of_night("crank", 9.0)});
  const std::string text = page();
  EXPECT_EQ(text, page());
  EXPECT_THAT(text, HasSubstr("default-src 'none'; style-src 'sha256-"));
  EXPECT_THAT(text, HasSubstr("<title>concord: green suite: 1 case: 1 agree</title>"));
  EXPECT_THAT(text, HasSubstr("a note"));
}

// Detects pages that grow with the number of cases, and nights that are left out without a word.
TEST_F(NightPages, ManyCasesLeaveFewerNightsAndThePageSaysSo) {
  for (int k = 0; k < 9; ++k) night("aaaa", {result_of_night("case 0", 9.0)});
  std::vector<Result> many;
  for (int k = 0; k < 3000; ++k) {
    many.push_back(result_of_night(fmt::format("case {}", k), k == 0 ? 5.0 : 9.0));
    many.back().words = std::string(3000, 'x');
  }
  night("bbbb", many);
  const std::string text = page();
  EXPECT_LT(text.size(), 3000000U);
  const nlohmann::json data = data_of(text);
  EXPECT_EQ(data.at("nights").size(), 6U);
  EXPECT_THAT(data.at("notes").back().get<std::string>(),
              HasSubstr("show the last 6 nights; the history holds 10 up to this one"));
}

}  // namespace concord::compare::nightly
