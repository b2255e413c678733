#include "compare/verdict/align.h"

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

TEST_F(AlignTest, AngleIsAccurateNearZeroAndNearHalfATurn) {
  const Mat3 A = rotation_about(Vec3(1, 2, 2) / 3.0, 0.7);
  const Vec3 axis = Vec3(2, -1, 2) / 3.0;
  for (const double angle : {0.0, 1e-13, 1e-3, 1.5, 3.14}) {
    EXPECT_NEAR(angle_between(A, A * rotation_about(axis, angle)), angle, 1e-15 + 1e-14 * angle);
  }
}

TEST_F(AlignTest, ComparesMotions) {
  const Trajectory one = run();
  const MotionAgreement same = compare_motions(model_, {&one, &one});
  EXPECT_EQ(same.digits, 16.0);
  Trajectory other = one;
  other.samples[9].state.bodies[1].r(1) += 1e-5 * model_.length_scale();
  const MotionAgreement moved = compare_motions(model_, {&one, &other});
  EXPECT_NEAR(moved.digits, 5.0, 1e-9);
  EXPECT_EQ(moved.worst, "origin of bob");
  EXPECT_DOUBLE_EQ(moved.t, one.samples[9].state.t);
  other.samples[9].state.bodies[1].p *= -1.0;  // the same orientation
  EXPECT_NEAR(compare_motions(model_, {&one, &other}).digits, 5.0, 1e-9);
}

/// A body that travels far is compared with the way that it goes.
TEST_F(AlignTest, PlacesAreComparedWithTheWayTravelled) {
  const double far = 1e3 * model_.length_scale();
  Trajectory one = run();
  for (std::size_t k = 0; k < one.samples.size(); ++k) {
    one.samples[k].state.bodies[1].r(0) += far * static_cast<double>(k) / static_cast<double>(one.samples.size() - 1);
  }
  Trajectory other = one;
  other.samples[9].state.bodies[1].r(1) += 1e-5 * model_.length_scale();
  EXPECT_NEAR(compare_motions(model_, {&one, &other}).digits, 8.0, 1e-2);
}

}  // namespace
}  // namespace concord::compare
