#include "compare/verdict/assemble_both.h"

#include <gmock/gmock.h>

#include "common/error.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A pendulum that starts `off` from where the model says and by a part `faster`, or that refuses its start.
class Starter : public FakePendulum {
 public:
  Starter(const Model& model, std::string name) : FakePendulum(model, std::move(name)) {}

  std::function<void()> refuse = [] {};
  double off = 0.0;
  double faster = 0.0;
  double smallest_kept = 0.1;

  State assemble() override {
    refuse();
    State start = FakePendulum::assemble();
    start.q[0](0) += off;
    start.bodies[1].omega *= 1.0 + faster;
    return start;
  }
  RankReport rank(const State& state) override {
    RankReport report = FakePendulum::rank(state);
    report.smallest_kept = smallest_kept;
    return report;
  }
};

void finds_none() { throw StartNotFound({"pendulum.toml", 3, 1}, "the start does not close"); }
void counts_otherwise() { throw InputError({"pendulum.toml", 3, 1}, "keep one more"); }

class AssembleBoth : public ::testing::Test {
 protected:
  AssembleBoth() { model_.joints[0].start[0].role_q = StartRole::keep; }

  std::array<State, 2> ask() { return assemble_both(model_, {&cartesian_, &relative_}, 1, false, verdict_); }

  Model model_ = pendulum_model();
  Starter cartesian_{model_, "cartesian"};
  Starter relative_{model_, "relative"};
  Verdict verdict_;
};

TEST_F(AssembleBoth, TakesBothStarts) {
  const std::array<State, 2> starts = ask();
  EXPECT_EQ(starts[0].bodies.size(), model_.bodies.size());
  EXPECT_EQ(starts[1].bodies.size(), model_.bodies.size());
  EXPECT_TRUE(verdict_.failures.empty());
}

TEST_F(AssembleBoth, WhoFindsNoStartThoughTheOtherOneKeepsTheModelsIsWrong) {
  relative_.refuse = finds_none;
  EXPECT_TRUE(ask()[1].bodies.empty());
  EXPECT_THAT(verdict_.failures, ElementsAre(HasSubstr("relative refuses the start that cartesian finds: ")));
}

TEST_F(AssembleBoth, AStartThatDropsWhatIsKeptSpeaksForNobody) {
  relative_.refuse = finds_none;
  cartesian_.off = 1e-3;
  EXPECT_THROW(ask(), InputError);
}

TEST_F(AssembleBoth, OtherRefusalsAreBadInput) {
  relative_.refuse = counts_otherwise;
  EXPECT_THROW(ask(), InputError);
}

TEST_F(AssembleBoth, WhatBothRefuseIsBadInput) {
  cartesian_.refuse = finds_none;
  relative_.refuse = finds_none;
  EXPECT_THROW(ask(), InputError);
}

TEST_F(AssembleBoth, StartsThatClosingKnowsNoBetterThanTheyDifferAreRefusedBesideASingularPose) {
  cartesian_.smallest_kept = 9e-7;
  relative_.faster = 1e-7;
  ask();
  EXPECT_THAT(verdict_.failures,
              ElementsAre("the start is beside a singular pose: one of the independent constraints has a relative "
                          "singular value of 9.0e-07 there (need 1e-06), so that closing knows few digits of it, and "
                          "the starts of both solvers differ by 8.3e-08 of their size, most in the angular velocity "
                          "of bob: start farther from that pose"));
}

TEST_F(AssembleBoth, StartsThatDifferWithoutSuchAReasonAreLeftToTheRuns) {
  relative_.faster = 1e-7;
  ask();
  EXPECT_TRUE(verdict_.failures.empty()) << "apart from singular poses";
  cartesian_.smallest_kept = 9e-7;
  relative_.faster = 1e-13;
  ask();
  EXPECT_TRUE(verdict_.failures.empty()) << "the same start";
  relative_.faster = 1e-3;
  ask();
  EXPECT_TRUE(verdict_.failures.empty()) << "farther apart than any closing leaves";
}

TEST_F(AssembleBoth, WhoCannotFinishIsAFailure) {
  cartesian_.refuse = [] { throw SolverError("cartesian: no"); };
  EXPECT_TRUE(ask()[0].bodies.empty());
  EXPECT_THAT(verdict_.failures, ElementsAre("cartesian: no"));
}

}  // namespace
}  // namespace concord::compare
