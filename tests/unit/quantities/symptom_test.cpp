#include "compare/quantities/symptom.h"

#include <gmock/gmock.h>

#include "compare/quantities/align.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

/// A true run in both columns of a series, then a fault in relative's.
class SymptomTest : public ::testing::Test {
 protected:
  SymptomTest() {
    FakePendulum solver(model_, "cartesian");
    run_ = solver.integrate({0.3, 1e-11, 60, ""}, [](double) {});
  }

  /// Diagnosis of `quantity` after `fault` changed every evaluation of one solver.
  std::string diagnosis(const Quantity& quantity, const std::function<void(const State&, JointWrenches&)>& fault,
                        Who faulty = Who::relative) {
    Trajectory spoiled = run_;
    for (Sample& sample : spoiled.samples) fault(sample.state, sample.evaluation.joints[0]);
    const QuantityLayout layout(model_);
    const std::array<const Trajectory*, 2> both = faulty == Who::relative
                                                      ? std::array<const Trajectory*, 2>{&run_, &spoiled}
                                                      : std::array<const Trajectory*, 2>{&spoiled, &run_};
    return diagnose(layout, align(layout, both, 61), layout.row_of(quantity));
  }

  static Wrench& child(JointWrenches& wrenches) { return wrenches.reaction[index(Side::child)].in_C; }

  Model model_ = pendulum_model();
  Trajectory run_;
  Quantity force_{Kind::reaction, 0, Side::child, 1};
  Quantity torque_{Kind::reaction, 0, Side::child, 3};
};

TEST_F(SymptomTest, OppositeSign) {
  EXPECT_EQ(diagnosis(force_, [](const State&, JointWrenches& w) { child(w).force *= -1.0; }),
            "same size, opposite sign in all 61 samples: check side, point and frame before the dynamics");
}

TEST_F(SymptomTest, OppositeSignOfOneComponentAlone) {
  EXPECT_THAT(diagnosis(torque_, [](const State&, JointWrenches& w) { child(w).torque(0) *= -1.0; }),
              StartsWith("same size, opposite sign in all 61 samples"));
}

TEST_F(SymptomTest, FactorTwo) {
  const auto twice = [](const State&, JointWrenches& w) { child(w).torque *= 2.0; };
  EXPECT_EQ(diagnosis(torque_, twice), "factor two: relative is twice cartesian in all 61 samples");
  EXPECT_EQ(diagnosis(torque_, twice, Who::cartesian), "factor two: cartesian is twice relative in all 61 samples");
}

TEST_F(SymptomTest, AnotherConstantFactor) {
  EXPECT_EQ(diagnosis(force_, [](const State&, JointWrenches& w) { child(w).force *= 1.001; }),
            "constant factor: relative is 1.001 times cartesian in all 61 samples");
}

TEST_F(SymptomTest, Zero) {
  const auto nothing = [](const State&, JointWrenches& w) { child(w).force.setZero(); };
  EXPECT_EQ(diagnosis(force_, nothing), "relative gives zero in all 61 samples");
  EXPECT_EQ(diagnosis(force_, nothing, Who::cartesian), "cartesian gives zero in all 61 samples");
}

TEST_F(SymptomTest, GlobalAxes) {
  EXPECT_EQ(
      diagnosis(force_, [](const State&, JointWrenches& w) { child(w) = w.reaction[index(Side::child)].in_global; }),
      "other frame: relative gives components in global axes");
}

TEST_F(SymptomTest, TheOtherSidesFrame) {
  const auto in_parents_frame = [](const State&, JointWrenches& w) {
    child(w).force = -w.reaction[index(Side::parent)].in_C.force;
  };
  EXPECT_EQ(diagnosis(force_, in_parents_frame), "other frame: relative gives components in the parent's joint frame");
}

TEST_F(SymptomTest, TheOtherSidesWrench) {
  const auto on_parent = [](const State&, JointWrenches& w) { child(w) = w.reaction[index(Side::parent)].in_C; };
  EXPECT_EQ(diagnosis(force_, on_parent), "other side: relative gives the wrench on the parent");
}

TEST_F(SymptomTest, AFrameTurnedOnce) {
  const Mat3 Q = rotation_about(Vec3(1, 2, 2) / 3.0, 0.5);
  EXPECT_EQ(diagnosis(force_, [Q](const State&, JointWrenches& w) { child(w).force = Q * child(w).force; }),
            "other frame: the same vectors, turned by 28.65 deg, in all 61 samples");
}

TEST_F(SymptomTest, AFrameThatTurnsAlong) {
  const auto body_axes = [](const State& state, JointWrenches& w) {
    child(w).force = rotation_about(Vec3(2, -1, 2) / 3.0, 5.0 * state.t) * child(w).force;
  };
  EXPECT_THAT(diagnosis(force_, body_axes), HasSubstr("same size, other direction in all 61 samples"));
}

TEST_F(SymptomTest, AnotherPoint) {
  const Vec3 lever(0.1, -0.2, 0.05);
  EXPECT_EQ(
      diagnosis(torque_, [lever](const State&, JointWrenches& w) { child(w).torque += lever.cross(child(w).force); }),
      "other point: the torques differ by lever x force, lever = (0.1, -0.2, 0.05) m, in all 61 samples");
}

TEST_F(SymptomTest, NoPatternButGrowth) {
  const auto drifts = [](const State& state, JointWrenches& w) {
    child(w).force += 1e-5 * state.t * state.t * Vec3(1.0, std::sin(40.0 * state.t), 2.0);
  };
  EXPECT_THAT(diagnosis(force_, drifts), HasSubstr("the difference grows along the samples"));
}

TEST_F(SymptomTest, NoPattern) {
  const auto noise = [](const State& state, JointWrenches& w) {
    child(w).force += Vec3(std::sin(900.0 * state.t + 1.0), std::cos(700.0 * state.t), std::sin(300.0 * state.t + 2.0));
  };
  EXPECT_EQ(diagnosis(force_, noise), "no known pattern: not sign, factor, frame or point");
}

}  // namespace
}  // namespace concord::compare
