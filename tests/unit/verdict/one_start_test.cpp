#include "compare/verdict/one_start.h"

#include <gtest/gtest.h>

#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

/// A pendulum that knows the speed of its start to `blur` of it only: each closing ends somewhere else.
class Blurred : public FakePendulum {
 public:
  Blurred(const Model& model, std::string name, double blur) : FakePendulum(model, std::move(name)), blur_(blur) {}

  std::optional<State> close(const State& guess) override {
    auto closed = FakePendulum::close(guess);
    side_ = -side_;
    closed->bodies[1].omega *= 1.0 + side_ * blur_;
    return closed;
  }

 private:
  double blur_;
  double side_ = 1.0;
};

struct Pair {
  Model model = pendulum_model();
  Blurred cartesian;
  Blurred relative;

  explicit Pair(double blur, double other) : cartesian(model, "cartesian", blur), relative(model, "relative", other) {}

  /// The start of the second one turns faster by this part.
  std::optional<OneStart> starts_apart(double part) {
    std::array<State, 2> starts{cartesian.assemble(), relative.assemble()};
    Model faster = model;
    faster.joints[0].start[0].u *= 1.0 + part;
    starts[1] = FakePendulum(faster, "faster").assemble();
    return one_start(model, {&cartesian, &relative}, starts, 3);
  }
};

TEST(OneStart, BothStartFromOneWhereClosingKnowsNoBetter) {
  Pair pair(4e-8, 7e-8);
  const auto found = pair.starts_apart(1e-7);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->state.bodies[1].omega, pair.cartesian.assemble().bodies[1].omega);
  EXPECT_TRUE(found->note.starts_with("closing from round-off around the start ends 7.")) << found->note;
  EXPECT_TRUE(found->note.ends_with("the solvers' starts differ by 1.0e-07: both run from that of cartesian"))
      << found->note;
}

TEST(OneStart, StartsThatDifferByMoreAreADifference) {
  Pair pair(4e-8, 7e-8);
  EXPECT_FALSE(pair.starts_apart(3e-6));
}

/// Finds a start that is wrong by more than any closing near a singular pose leaves, and passes for uncertain.
TEST(OneStart, WhatNoClosingLeavesIsADifferenceHoweverUncertainTheStartsAre) {
  Pair pair(4e-5, 7e-5);
  EXPECT_TRUE(pair.starts_apart(5e-5));
  EXPECT_FALSE(pair.starts_apart(1e-3));
}

TEST(OneStart, OneSolverThatDoesNotKnowItsStartIsNoExcuseForTheOther) {
  Pair pair(1e-16, 7e-8);
  EXPECT_FALSE(pair.starts_apart(1e-7));
}

TEST(OneStart, StartsThatAreTheSameStayEachSolversOwn) {
  Pair pair(4e-8, 7e-8);
  EXPECT_FALSE(pair.starts_apart(1e-13));
}

}  // namespace
}  // namespace concord::compare
