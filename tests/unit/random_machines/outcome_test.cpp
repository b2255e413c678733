#include "compare/random_machines/outcome.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace concord::compare;
using namespace concord::compare::fuzz;

TEST(Outcome, HonestRefusalsAreOfKindsFromAList) {
  EXPECT_EQ(refusal_kind("same state: no component was judged"), "not unique anywhere");
  EXPECT_EQ(refusal_kind(
                "same run: cartesian: at t = 1 s the equations of motion are singular: the machine is in a "
                "singular pose, a body can move without inertia, or inertias lie too far apart for double precision"),
            "singular pose");
  EXPECT_EQ(refusal_kind("same run: relative: at t = 2.8 s the motion of the model has grown without bound: body 'box' "
                         "stands 7.2e+09 m from its start"),
            "grows without bound");
  EXPECT_EQ(refusal_kind("something nobody has thought of"), "");
  for (const std::string& kind : refusal_kinds()) EXPECT_FALSE(kind.empty());
}

TEST(Outcome, FailureOfNoKnownKindIsAStop) {
  Verdict verdict;
  EXPECT_EQ(outcome_of(verdict).sort, Sort::agree);
  verdict.failures = {"no component was judged"};
  EXPECT_EQ(outcome_of(verdict).sort, Sort::refusal);
  EXPECT_FALSE(outcome_of(verdict).is_wrong());
  verdict.failures.emplace_back("relative: joint 'joint7' is odd at t = 0.125 s");
  const fuzz::Outcome stop = outcome_of(verdict);
  EXPECT_EQ(stop.sort, Sort::stop);
  EXPECT_EQ(stop.kind, "stop: relative: joint ' is odd at t = #.# s");
}

/// Both solvers stop where the machine locks, and one of them says so.
TEST(Outcome, AStopThatTheOtherSolverExplainsIsARefusal) {
  Verdict verdict;
  verdict.failures = {"same run: cartesian: at t = 0.1 s the wheel locks", "same run: relative: the pose is singular"};
  EXPECT_EQ(outcome_of(verdict).kind, "singular pose");
  verdict.failures[1] = "refined: relative: the pose is singular";
  EXPECT_EQ(outcome_of(verdict).sort, Sort::stop) << "another check";
  verdict.failures[1] = "relative: at t = 0 s no accelerations close everything: the pose is singular";
  EXPECT_EQ(outcome_of(verdict).kind, "singular pose") << "a state of the run";
}

TEST(Outcome, DifferenceOutweighsFailuresAndIsNamedAfterItsCheck) {
  Verdict verdict;
  verdict.failures = {"no component was judged"};
  verdict.findings = {{"joint B on rod, F_x, t = 1 s: ...", "same run: factor 2 in all 300 samples"}};
  const fuzz::Outcome outcome = outcome_of(verdict);
  EXPECT_EQ(outcome.sort, Sort::differ);
  EXPECT_EQ(outcome.kind, "differ: same run: factor # in all # samples");
  verdict.findings.front() = {"cartesian is not in balance: body 'a' ...", "audit: ..."};
  EXPECT_EQ(outcome_of(verdict).kind, "differ: cartesian not in balance");
}

TEST(Outcome, GoesThroughTextAndComesBack) {
  for (const Sort sort : {Sort::agree, Sort::refusal, Sort::differ, Sort::stop}) {
    fuzz::Outcome outcome{sort, sort == Sort::agree ? "" : "some kind", "line one\nline two\n"};
    for (const double ratio : {0.03, 0.7, 3.0, 25.0}) outcome.ratios.add(ratio);
    const fuzz::Outcome back = outcome_of(workers::Report{workers::End::answered, 0, format_outcome(outcome), ""});
    EXPECT_EQ(back.sort, outcome.sort);
    EXPECT_EQ(back.kind, outcome.kind);
    EXPECT_EQ(back.text, outcome.text);
    EXPECT_EQ(back.ratios.counts, outcome.ratios.counts);
    EXPECT_EQ(back.ratios.largest, 25.0);
  }
}

TEST(Outcome, RatiosAreCountedByEdges) {
  ResolutionRatios ratios;
  for (int k = 0; k < 99; ++k) ratios.add(0.3);
  ratios.add(7.0);
  ResolutionRatios all;
  all.add(ratios);
  EXPECT_EQ(all.count(), 100);
  EXPECT_EQ(all.edge_of(0.99), 0.5);
  EXPECT_EQ(all.edge_of(1.0), 10.0);
  all.add(1e9);
  EXPECT_TRUE(std::isinf(all.edge_of(1.0)));
  EXPECT_EQ(all.largest, 1e9);
}

TEST(Outcome, LostWorkersAreTold) {
  const fuzz::Outcome crashed = outcome_of(workers::Report{workers::End::crashed, 11, "", "check: same run\n"});
  EXPECT_EQ(crashed.sort, Sort::lost);
  EXPECT_EQ(crashed.kind, "crashed by signal 11");
  EXPECT_EQ(crashed.text, "check: same run\n");
  EXPECT_EQ(outcome_of(workers::Report{workers::End::hung, 9, "", ""}).kind, "hung by signal 9");
  EXPECT_EQ(outcome_of(workers::Report{workers::End::threw, 0, "odd", ""}).kind, "stop: odd");
}
