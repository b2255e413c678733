#include "compare/states/stiff_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "common/error.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

/// A pendulum whose integrators of these names take too long.
class Slow : public FakePendulum {
 public:
  Slow(const Model& model, std::vector<std::string> slow) : FakePendulum(model, "slow"), slow_(std::move(slow)) {}

  Trajectory integrate(const RunOptions& options, const Progress& progress) override {
    if (std::find(slow_.begin(), slow_.end(), options.integrator) != slow_.end())
      throw TooManyEvaluations("slow: " + options.integrator + " gets nowhere");
    return FakePendulum::integrate(options, progress);
  }

 private:
  std::vector<std::string> slow_;
};

RunOptions by(const std::string& integrator) {
  RunOptions run;
  run.until = 0.1;
  run.samples = 4;
  run.integrator = integrator;
  return run;
}

TEST(StiffChoice, TakesTheSecondIntegratorWhereTheFirstTakesTooLong) {
  const Model model = pendulum_model();
  Slow solver(model, {"rk4"});
  MadeBy made_by;
  const Trajectory run = integrate_or_switch(solver, by("rk4"), true, {}, made_by);
  EXPECT_EQ(run.samples.size(), 5U);
  EXPECT_EQ(made_by.integrator, "other");
  EXPECT_EQ(made_by.note,
            "slow runs by other, which is for stiff machines, because rk4 took too long: slow: rk4 gets nowhere");
}

/// Each integrator needs so many evaluations.
class Counting : public FakePendulum {
 public:
  Counting(const Model& model, long first, long second) : FakePendulum(model, "counting"), needs_{first, second} {}

  Trajectory integrate(const RunOptions& options, const Progress& progress) override {
    const long needed = needs_.at(options.integrator == "rk4" ? 0 : 1);
    if (options.most_evaluations && needed > *options.most_evaluations) throw EvaluationsSpent("counting: too many");
    return FakePendulum::integrate(options, progress);
  }

 private:
  std::array<long, 2> needs_;
};

TEST(StiffChoice, ALongRunByTheFirstIsLeftForAShortOneByTheSecond) {
  const Model model = pendulum_model();
  const auto chosen = [&](long first, long second) {
    Counting solver(model, first, second);
    MadeBy made_by;
    EXPECT_EQ(integrate_or_switch(solver, by("rk4"), true, {}, made_by).samples.size(), 5U);
    EXPECT_EQ(made_by.note.empty(), made_by.integrator == "rk4");
    return made_by.integrator;
  };
  EXPECT_EQ(chosen(900'000, 1'000), "rk4");
  EXPECT_EQ(chosen(3'000'000, 1'000), "other");
  EXPECT_EQ(chosen(3'000'000, 150'000), "other");
  EXPECT_EQ(chosen(3'000'000, 600'000), "rk4");
}

TEST(StiffChoice, TheFirstMayTakeAsLongAsItNeedsWhereItMadeARunBefore) {
  const Model model = pendulum_model();
  Counting solver(model, 4'000'000, 1'000);
  MadeBy made_by;
  (void)integrate_or_switch(solver, by("rk4"), false, {}, made_by);
  EXPECT_EQ(made_by.integrator, "rk4");
}

TEST(StiffChoice, StaysWhereTheFirstGetsThrough) {
  const Model model = pendulum_model();
  Slow solver(model, {"other"});
  MadeBy made_by;
  (void)integrate_or_switch(solver, by("rk4"), true, {}, made_by);
  EXPECT_EQ(made_by.integrator, "rk4");
  EXPECT_EQ(made_by.note, "");
}

TEST(StiffChoice, AnIntegratorThatWasAskedForIsKept) {
  const Model model = pendulum_model();
  Slow solver(model, {"rk4"});
  MadeBy made_by;
  try {
    (void)integrate_or_switch(solver, by("rk4"), false, {}, made_by);
    FAIL();
  } catch (const TooManyEvaluations& error) {
    EXPECT_STREQ(error.what(), "slow: rk4 gets nowhere; other is for stiff machines");
  }
}

TEST(StiffChoice, SaysWhatBothSaid) {
  const Model model = pendulum_model();
  Slow solver(model, {"rk4", "other"});
  MadeBy made_by;
  try {
    (void)integrate_or_switch(solver, by("rk4"), true, {}, made_by);
    FAIL();
  } catch (const TooManyEvaluations& error) {
    EXPECT_STREQ(error.what(), "slow: rk4 gets nowhere; then by other: slow: other gets nowhere");
  }
}

}  // namespace
}  // namespace concord::compare
