#include "compare/states/branch.h"

#include <gmock/gmock.h>

#include "common/error.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

using ::testing::HasSubstr;

/// A pendulum that closes at two angles, and finds the one or the other from its guess.
class TwoWays : public FakePendulum {
 public:
  using Choice = std::function<double(double guess)>;
  TwoWays(const Model& model, std::string name, Choice choice, bool searches = false)
      : FakePendulum(model, std::move(name)), model_(model), choice_(std::move(choice)), searches_(searches) {}

  [[nodiscard]] bool has_searched_for_its_start() const override { return searches_; }

  State assemble() override {
    const double found = choice_(model_.joints[0].start[0].q(0));
    if (std::isnan(found)) throw InputError({"two_ways.toml", 3, 1}, "the start does not close");
    Model there = model_;
    there.joints[0].start[0].q(0) = found;
    return FakePendulum(there, "there").assemble();
  }

 private:
  const Model& model_;
  Choice choice_;
  bool searches_;
};

constexpr double kNear = 0.4;
constexpr double kFar = 2.6;

double nearest(double guess) { return std::abs(guess - kNear) < std::abs(guess - kFar) ? kNear : kFar; }

class BranchTest : public ::testing::Test {
 protected:
  Solvers make(const TwoWays::Choice& cartesian, const TwoWays::Choice& relative, bool relative_searches = false) {
    const SolverMakers makers{
        [=](const Model& model) { return std::make_unique<TwoWays>(model, "cartesian", cartesian); },
        [=](const Model& model) { return std::make_unique<TwoWays>(model, "relative", relative, relative_searches); }};
    return make_solvers_on_one_branch(model_, makers, note_);
  }
  void guess(double q, StartRole role = StartRole::guess) {
    WordStart& word = model_.joints[0].start[0];
    word.q(0) = q;
    word.role_q = role;
  }
  static void expect_starts(const Solvers& solvers, double q) {
    for (const auto& solver : solvers) EXPECT_NEAR(solver->assemble().q[0](0), q, 1e-15);
  }

  Model model_ = pendulum_model();
  std::string note_;
};

/// Goes far from a guess that is not near enough.
double timid(double guess) { return std::abs(guess - kNear) < 0.1 ? kNear : kFar; }
double refuses(double guess) { return std::abs(guess - kNear) < 0.1 ? kNear : std::nan(""); }

TEST_F(BranchTest, OneBranchIsLeftAsItIs) {
  guess(0.7);
  expect_starts(make(nearest, nearest), kNear);
  EXPECT_EQ(note_, "");
  EXPECT_EQ(model_.joints[0].start[0].q(0), 0.7);
}

TEST_F(BranchTest, OfTwoTheOneThatIsNearerToTheGuessIsTaken) {
  guess(0.7);
  expect_starts(make(timid, nearest), kNear);
  EXPECT_THAT(note_, HasSubstr("turn_z of A 148.969 and 22.9183 deg"));
  EXPECT_THAT(note_, HasSubstr("both start from that of relative"));
  guess(0.7);
  expect_starts(make(nearest, timid), kNear);
  EXPECT_THAT(note_, HasSubstr("both start from that of cartesian"));
}

TEST_F(BranchTest, WhatTheGuessesLeadToStandsBeforeWhatWasSearchedFor) {
  guess(0.7);
  expect_starts(make(timid, nearest, true), kFar);
  EXPECT_EQ(note_, "from the guesses relative finds no start; both start from that of cartesian");
}

TEST_F(BranchTest, WithoutAGuessTheOneThatIsNearerToZeroIsTaken) {
  guess(0.0, StartRole::unsaid);
  expect_starts(make(timid, nearest), kNear);
}

TEST_F(BranchTest, ABranchThatOneSolverFindsIsShownToTheOther) {
  guess(0.7);
  expect_starts(make(nearest, refuses), kNear);
  EXPECT_THAT(note_, HasSubstr("relative finds no start; both start from that of cartesian"));
}

TEST_F(BranchTest, AModelThatBothRefuseIsRefused) {
  guess(0.7);
  EXPECT_THROW(make(refuses, refuses), InputError);
}

/// Who is wrong, the model or the solver, is for the verdict to tell.
TEST_F(BranchTest, ASolverThatRefusesTheOthersStartTooIsLeftToSayWhy) {
  guess(0.7);
  const auto never = [](double) { return std::nan(""); };
  const Solvers solvers = make(nearest, never);
  EXPECT_EQ(note_, "");
  EXPECT_EQ(model_.joints[0].start[0].q(0), 0.7);
  EXPECT_NEAR(solvers[0]->assemble().q[0](0), kNear, 1e-15);
  EXPECT_THROW(solvers[1]->assemble(), InputError);
}

TEST_F(BranchTest, SolversThatPartFromOneGuessAreRefused) {
  guess(0.7);
  const auto stubborn = [](double) { return kFar; };
  try {
    make(nearest, stubborn);
    FAIL() << "no refusal";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the guesses do not choose a branch of the machine"));
  }
}

/// A solver with a wrong constraint closes elsewhere, and takes no other closed state for closed: the model is sound,
/// and the verdict, which has states to look at, says who is wrong.
TEST_F(BranchTest, AStartThatTheOtherOneTakesForOpenIsNoBranch) {
  guess(0.7);
  class Strict : public TwoWays {
   public:
    using TwoWays::TwoWays;
    Evaluation evaluate(const State& state) override {
      if (std::abs(state.q[0](0) - kFar) > 1e-9) throw SolverError("relative: joint 'A' is open by 0.8 rad");
      return TwoWays::evaluate(state);
    }
  };
  const auto stubborn = [](double) { return kFar; };
  const Solvers solvers = make_solvers_on_one_branch(
      model_,
      {[](const Model& model) { return std::make_unique<TwoWays>(model, "cartesian", nearest); },
       [&](const Model& model) { return std::make_unique<Strict>(model, "relative", stubborn); }},
      note_);
  EXPECT_EQ(note_, "");
  EXPECT_EQ(model_.joints[0].start[0].q(0), 0.7);
  EXPECT_NEAR(solvers[0]->assemble().q[0](0), kNear, 1e-15);
  EXPECT_NEAR(solvers[1]->assemble().q[0](0), kFar, 1e-15);
}

/// What is kept is no guess: a solver that does not keep it is wrong, and the verdict has states to say so.
TEST_F(BranchTest, AStartWithoutWhatIsKeptIsNoBranch) {
  guess(kNear, StartRole::keep);
  const auto off = [](double kept) { return 1.0001 * kept; };
  const Solvers solvers = make(nearest, off);
  EXPECT_EQ(note_, "");
  EXPECT_NEAR(solvers[0]->assemble().q[0](0), kNear, 1e-15);
  EXPECT_NEAR(solvers[1]->assemble().q[0](0), 1.0001 * kNear, 1e-15);
}

/// Two turns off, unless it is told the angle.
double turned(double guess) { return guess == kNear ? kNear : kNear - 4.0 * M_PI; }

TEST_F(BranchTest, WholeTurnsThatNothingReadsAreOnePose) {
  guess(0.7);
  expect_starts(make(turned, nearest), kNear);  // in one count of turns
  EXPECT_EQ(note_, "");
  guess(0.7);
  const auto stubborn = [](double) { return kNear + 2.0 * M_PI; };
  EXPECT_NO_THROW(make(nearest, stubborn));
  EXPECT_EQ(note_, "");
}

TEST_F(BranchTest, WholeTurnsOfASprungAngleAreBranches) {
  model_.joints[0].springs.emplace_back().law.stiffness = 2.0;
  guess(0.7);
  expect_starts(make(turned, nearest), kNear);
  EXPECT_THAT(note_, HasSubstr("different branches (turn_z of A -697.082 and 22.9183 deg)"));
}

}  // namespace
}  // namespace concord::compare
