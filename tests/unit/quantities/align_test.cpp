#include "compare/quantities/align.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

class AlignTest : public ::testing::Test {
 protected:
  Trajectory run(double drift = 0.0) {
    FakePendulum solver(model_, "cartesian");
    solver.drift = drift;
    return solver.integrate({0.2, 1e-11, 20, ""}, [](double) {});
  }

  std::string refusal(const Trajectory& one, const Trajectory& other, int samples) {
    try {
      align(QuantityLayout(model_), {&one, &other}, samples);
    } catch (const IncompleteResult& error) {
      return error.what();
    }
    return "";
  }

  Model model_ = pendulum_model();
};

TEST_F(AlignTest, PutsBothOnOneGrid) {
  const Trajectory one = run();
  const Trajectory other = run(1e3);
  const QuantityLayout layout(model_);
  const Series series = align(layout, {&one, &other}, 21);
  ASSERT_EQ(series.times.size(), 21U);
  EXPECT_DOUBLE_EQ(series.times[20], 0.2);
  const int row = layout.row_of({Kind::reaction, 0, Side::child, 1});
  EXPECT_EQ(series.values[1](row, 7), other.samples[7].evaluation.joints[0].reaction[1].in_C.force(1));
  EXPECT_NE(series.values[0](row, 7), series.values[1](row, 7));
}

TEST_F(AlignTest, RefusesOtherTimesFewerSamplesAndWhatIsNotANumber) {
  const Trajectory one = run();
  Trajectory other = run();
  other.samples[3].state.t += 1e-6;
  EXPECT_EQ(refusal(one, other, 21),
            "sample 3: cartesian stands at t = 0.03 s, relative at t = 0.030001 s; they must share a grid");
  other = run();
  other.samples[4].evaluation.bodies[1].vdot(2) = std::numeric_limits<double>::infinity();
  EXPECT_EQ(refusal(one, other, 21), "relative: body bob, vdot_z is not a number at t = 0.04 s");
  other.samples[4].evaluation.bodies[1].vdot(2) = -1e160;
  EXPECT_EQ(refusal(one, other, 21),
            "relative: body bob, vdot_z is -1e+160, beyond the 1e+150 that can be judged, at t = 0.04 s");
  EXPECT_EQ(refusal(one, run(), 22), "cartesian: 21 samples, 22 were asked for");
}

TEST_F(AlignTest, TimesAreHeldAgainstTheTimeOfTheRun) {
  const auto in_picoseconds = [&](double late) {
    Trajectory fast = run();
    for (Sample& sample : fast.samples) sample.state.t *= 1e-12;
    fast.samples[3].state.t += late;
    return fast;
  };
  EXPECT_EQ(refusal(in_picoseconds(0.0), in_picoseconds(0.0), 21), "");
  EXPECT_NE(refusal(in_picoseconds(0.0), in_picoseconds(1e-15), 21), "");
}

}  // namespace
}  // namespace concord::compare
