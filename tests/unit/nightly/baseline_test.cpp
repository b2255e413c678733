#include "compare/nightly/baseline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <limits>
#include <nlohmann/json.hpp>

#include "common/error.h"

namespace concord::compare::nightly {
namespace {

using testing::HasSubstr;

Result crank() {
  Result one;
  one.id = "crank, \"long\"";
  one.work = "compare";
  one.ending = Ending::agree;
  one.judged = 3;
  one.total = 4;
  one.cost = {Cost{"ida", 120, 340}, Cost{"gbs", 21, 900}};
  Component force;
  force.name = "joint A on rod, F_x";
  force.same_state = 12.345;
  force.resolvable = 12.9;
  force.refined = 10.0;
  force.peak = 17.25;
  force.scale = 17.25;
  one.components = {force};
  return one;
}

std::string refusal(const std::string& text) {
  try {
    parse_baselines(text, "old.csv");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST(Baselines, TextIsReadBackAndWrittenTheSame) {
  const std::string text = format_baselines({{crank().id, crank()}});
  const Baselines read = parse_baselines(text, "x.csv");
  ASSERT_EQ(read.size(), 1U);
  const Result& one = read.at(crank().id);
  EXPECT_EQ(one.cost[1].evaluations, 900);
  EXPECT_EQ(one.cost[0].integrator, "ida");
  EXPECT_EQ(one.judged, 3);
  ASSERT_EQ(one.components.size(), 1U);
  EXPECT_NEAR(*one.components[0].same_state, 12.345, 0.006);
  EXPECT_FALSE(one.components[0].same_run);
  EXPECT_DOUBLE_EQ(*one.components[0].peak, 17.25);
  EXPECT_EQ(format_baselines(parse_baselines(format_baselines(read), "x.csv")), format_baselines(read));
}

TEST(Baselines, TellWhatWasAskedWhereThatIsKnown) {
  Result one = crank();
  EXPECT_EQ(parse_baselines(format_baselines({{one.id, one}}), "x.csv").at(one.id).definition, "");
  one.definition = "compare crank.toml 00ff, until=1";
  const Baselines read = parse_baselines(format_baselines({{one.id, one}}), "x.csv");
  EXPECT_EQ(read.at(one.id).definition, one.definition);
  EXPECT_EQ(read.at(one.id).components.size(), 1U);
}

/// Finds a baseline that is written with what no later night can read.
TEST(Baselines, WhatIsNoNumberIsLeftOut) {
  Result one = crank();
  one.components[0].same_state = std::numeric_limits<double>::quiet_NaN();
  one.components[0].peak = std::numeric_limits<double>::infinity();
  const Baselines read = parse_baselines(format_baselines({{one.id, one}}), "x.csv");
  EXPECT_FALSE(read.at(one.id).components[0].same_state);
  EXPECT_FALSE(read.at(one.id).components[0].peak);
  EXPECT_TRUE(read.at(one.id).components[0].resolvable);
}

TEST(Baselines, VersionThatIsNotKnownIsRefusedByName) {
  EXPECT_THAT(refusal("concord baseline,7\n"),
              HasSubstr("old.csv:1:1: error: version 7 of the baselines is not known: this program reads version 1"));
  EXPECT_THAT(refusal("something else\n"), HasSubstr("old.csv:1:1: error: this is no baseline"));
  EXPECT_THAT(refusal(""), HasSubstr("this is no baseline"));
}

TEST(Baselines, WrongLinesAreToldWithTheirNumber) {
  const std::string title = "concord baseline,1\n";
  EXPECT_THAT(refusal(title + "case,a,agree,1 of 2,ida,x,2,gbs,3,4\n"),
              HasSubstr("old.csv:2:1: error: expected a number, found 'x'"));
  EXPECT_THAT(refusal(title + ",F_x,1,2,3,4,5,6\n"), HasSubstr("a component stands before the first case"));
  EXPECT_THAT(refusal(title + "case,a\n"), HasSubstr("expected 10 fields, found 2"));
  EXPECT_THAT(refusal(title + "case,\"a\n"), HasSubstr("a quotation mark is not closed"));
  EXPECT_THAT(refusal(title + "row,a\n"), HasSubstr("found 'row'"));
  const std::string start = title + "case,a,agree,1 of 2,ida,1,2,gbs,3,4\n";
  EXPECT_THAT(refusal(start + ",F_x,nan,2,3,4,5,6\n"),
              HasSubstr("old.csv:3:1: error: expected a finite number, found"));
  EXPECT_THAT(refusal(start + ",F_x,1,2,3,4,5,6\n,F_x,1,2,3,4,5,6\n"),
              HasSubstr("old.csv:4:1: error: 'F_x' of case 'a' stands there twice"));
  EXPECT_THAT(refusal(title + "case,a,agree,1 of 2,ida,-1,2,gbs,3,4\n"), HasSubstr("expected a count, found '-1'"));
}

TEST(Results, JsonIsReadBack) {
  Result one = crank();
  one.words = "two\nlines";
  const Result read = nlohmann::ordered_json(one).get<Result>();
  EXPECT_EQ(read.id, one.id);
  EXPECT_EQ(read.words, one.words);
  EXPECT_EQ(read.ending, Ending::agree);
  EXPECT_EQ(read.components.at(0).same_state, one.components[0].same_state);
  EXPECT_EQ(read.components.at(0).same_run, std::nullopt);
  EXPECT_EQ(read.cost[0].steps, 120);
}

TEST(Results, LostTaskKeepsItsLastWords) {
  workers::Report report;
  report.end = workers::End::crashed;
  report.signal = 11;
  report.last_words = "stage: same run\n";
  const Result lost = result_of("car", "compare", report);
  EXPECT_EQ(lost.ending, Ending::crashed);
  EXPECT_THAT(lost.words, HasSubstr("signal 11; last words: stage: same run"));
  EXPECT_EQ(exit_code(lost.ending), 3);
  report.last_words = "stage: reading\nstage: same run\nt = 0.4 s\n";
  EXPECT_EQ(result_of("car", "compare", report).words,
            "signal 11; last words: stage: same run\nt = 0.4 s\nbefore: stage: reading");
  report.signal = SIGINT;  // the user interrupts the whole group of processes
  EXPECT_EQ(result_of("car", "compare", report).ending, Ending::not_run);
}

}  // namespace concord::compare::nightly
