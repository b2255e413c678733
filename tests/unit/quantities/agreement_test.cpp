#include "compare/quantities/agreement.h"

#include <gtest/gtest.h>

#include "compare/quantities/align.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

/// A pendulum with a second joint, so that the machine has a length (the distance of the points on the bob) and one
/// joint can be small beside the other.
class AgreementTest : public ::testing::Test {
 protected:
  static Model two_joints() {
    Model model = pendulum_model();
    Joint second = model.joints[0];
    second.name = "B";
    second.sides[1].point_L += Vec3(0.0, 0.3, 0.4);
    model.joints.push_back(second);
    return model;
  }

  AgreementTest() {
    const auto rows = static_cast<Eigen::Index>(layout_.quantities().size());
    series_.times = {0.0, 0.1, 0.2};
    series_.spin = {0.0, 0.0};
    for (MatX& values : series_.values) values = MatX::Zero(rows, 3);
  }

  void put(const Quantity& quantity, int sample, double cartesian, double relative) {
    const int row = layout_.row_of(quantity);
    series_.values[0](row, sample) = cartesian;
    series_.values[1](row, sample) = relative;
  }

  Measured of(const Quantity& quantity) { return measure(layout_, series_)[layout_.row_of(quantity)]; }

  Model model_ = two_joints();
  QuantityLayout layout_{model_};
  Series series_;
  Quantity F_x{Kind::reaction, 0, Side::child, 0};
  Quantity F_y{Kind::reaction, 0, Side::child, 1};
  Quantity T_x{Kind::reaction, 0, Side::child, 3};
};

TEST_F(AgreementTest, ForceScaleIsThePeakOfTheVectorOverAllSamplesAndBothSolvers) {
  put(F_x, 0, 3.0, 3.0);
  put(F_y, 0, 4.0, 4.0);
  put(F_x, 2, 0.0, 6.0);
  const Measured measured = of(F_x);
  EXPECT_DOUBLE_EQ(measured.scale, 6.0);
  EXPECT_DOUBLE_EQ(of(F_y).scale, 6.0);
  EXPECT_EQ(measured.t, 0.2);
  EXPECT_EQ(measured.difference, 6.0);
  EXPECT_EQ(measured.values[1], 6.0);
  EXPECT_EQ(measured.digits, 0.0);
}

TEST_F(AgreementTest, TorqueScaleIsAtLeastForceTimesLength) {
  put(F_x, 0, 10.0, 10.0);
  put(T_x, 1, 1e-3, 1.5e-3);
  ASSERT_NEAR(model_.length_scale(), 0.5, 1e-12);
  EXPECT_NEAR(of(T_x).scale, 5.0, 1e-12);
  EXPECT_NEAR(of(T_x).digits, 4.0, 1e-12);
  put(T_x, 2, 70.0, 70.0);
  EXPECT_NEAR(of(T_x).scale, 70.0, 1e-12);
}

TEST_F(AgreementTest, SmallJointsAreHeldAgainstTheMachinesLargest) {
  put({Kind::total, 1, Side::parent, 2}, 0, 1e7, 1e7);
  put(F_x, 0, 1.0, 1.1);
  EXPECT_DOUBLE_EQ(of(F_x).scale, 10.0);
  EXPECT_EQ(of(F_x).source, ScaleSource::floor);
  EXPECT_EQ(of({Kind::total, 1, Side::parent, 2}).source, ScaleSource::own_peak);
  EXPECT_NEAR(of(F_x).digits, 2.0, 1e-12);
}

TEST_F(AgreementTest, AccelerationsTakeTheScaleOfTheirBody) {
  put({Kind::acceleration, 1, Side::child, 1}, 0, 40.0, 40.0);
  put({Kind::acceleration, 1, Side::child, 5}, 1, 1.0, 1.08);
  EXPECT_DOUBLE_EQ(of({Kind::acceleration, 1, Side::child, 0}).scale, 40.0);
  EXPECT_NEAR(of({Kind::acceleration, 1, Side::child, 5}).scale, 80.0, 1e-12);
  EXPECT_NEAR(of({Kind::acceleration, 1, Side::child, 5}).digits, 3.0, 1e-12);
}

TEST_F(AgreementTest, ABodyThatTurnsSteadilyHasTheScaleOfItsSpin) {
  series_.spin[1] = 20.0;
  put({Kind::acceleration, 1, Side::child, 5}, 0, 0.0, 4e-7);
  EXPECT_NEAR(of({Kind::acceleration, 1, Side::child, 5}).scale, 400.0, 1e-9);
  EXPECT_NEAR(of({Kind::acceleration, 1, Side::child, 5}).digits, 9.0, 1e-9);
}

TEST_F(AgreementTest, SumsTakeTheScaleOfTheLargestWrenchInThem) {
  put({Kind::total, 0, Side::child, 0}, 0, 200.0, 200.0);
  put({Kind::total, 1, Side::child, 0}, 0, -200.0, -200.0);
  put({Kind::body_sum, 1, Side::child, 0}, 0, 0.0, 2e-3);
  EXPECT_NEAR(of({Kind::body_sum, 1, Side::child, 0}).digits, 5.0, 1e-12);
}

}  // namespace
}  // namespace concord::compare
