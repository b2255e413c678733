#include "compare/quantities/sums.h"

#include <gtest/gtest.h>

#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

/// The bob hangs in two hinges on one axis; the second one names its sides the other way round.
class SumsTest : public ::testing::Test {
 protected:
  SumsTest() {
    Joint second = model_.joints[0];
    second.name = "B";
    second.sides[0].point_L += 0.4 * second.sides[0].C.col(2);
    second.sides[1].point_L += 0.4 * second.sides[1].C.col(2);
    std::swap(second.sides[0], second.sides[1]);
    model_.joints.push_back(second);
    FakePendulum solver(model_, "cartesian");
    state_ = solver.assemble();
    whole_ = solver.evaluate(state_).joints[0].total[index(Side::child)].in_global;
  }

  /// The same sum, shared between the hinges: `on_second` [N] is what the second one takes.
  Evaluation shared_out(const Vec3& on_second) {
    Evaluation evaluation;
    evaluation.joints.resize(2);
    const Vec3 arm = 0.4 * model_.joints[0].sides[0].C.col(2);
    Wrench& first = evaluation.joints[0].total[index(Side::child)].in_global;
    first = {whole_.force - on_second, whole_.torque - arm.cross(on_second)};
    evaluation.joints[1].total[index(Side::parent)].in_global = {on_second, Vec3::Zero()};
    return evaluation;
  }

  std::vector<PairSum> sums_of(const Evaluation& one, const Evaluation& other, double resolution) {
    const QuantityLayout layout(model_);
    std::vector<Measured> measured(layout.quantities().size());
    for (Measured& row : measured) row.machine = 20.0;
    const MatX resolutions = MatX::Constant(static_cast<Eigen::Index>(measured.size()), 1, resolution);
    return compare_pair_sums(layout, {{state_, {one, other}}}, measured, {&resolutions, nullptr});
  }

  Model model_ = pendulum_model();
  State state_;
  Wrench whole_;
};

TEST_F(SumsTest, TheSumIsTheSameHoweverTheHingesShareIt) {
  const std::vector<PairSum> sums = sums_of(shared_out({3.0, -2.0, 7.0}), shared_out({-40.0, 11.0, 5.0}), 1e-15);
  ASSERT_EQ(sums.size(), 1U);
  EXPECT_EQ(sums[0].what, "A + B on bob, at the point of A");
  EXPECT_GT(sums[0].digits, 14.0);
  EXPECT_LT((sums[0].at_start[0].force - whole_.force).norm(), 1e-13);
  EXPECT_LT((sums[0].at_start[1].torque - whole_.torque).norm(), 1e-13);
}

TEST_F(SumsTest, AWrongSumIsSeen) {
  Evaluation wrong = shared_out({-40.0, 11.0, 5.0});
  wrong.joints[1].total[index(Side::parent)].in_global.force(0) += 1e-3;
  const std::vector<PairSum> sums = sums_of(shared_out({3.0, -2.0, 7.0}), wrong, 1e-15);
  EXPECT_LT(sums.at(0).digits, 5.0);
  EXPECT_LT(sums.at(0).unexplained_digits, 5.0);
}

TEST_F(SumsTest, ADifferenceThatRoundOffExplainsIsToldAndNotJudged) {
  Evaluation other = shared_out({-40.0, 11.0, 5.0});
  other.joints[1].total[index(Side::parent)].in_global.force(0) += 1e-3;
  const std::vector<PairSum> sums = sums_of(shared_out({3.0, -2.0, 7.0}), other, 1e-4);
  EXPECT_LT(sums.at(0).digits, 5.0);
  EXPECT_EQ(sums.at(0).unexplained_digits, 16.0);
}

TEST_F(SumsTest, WhatIsNothingIsHeldAgainstTheMachine) {
  Evaluation nothing;
  nothing.joints.resize(2);
  Evaluation almost = nothing;
  almost.joints[0].total[index(Side::child)].in_global.force = {1e-18, -1e-18, 0.0};
  EXPECT_GT(sums_of(nothing, almost, 1e-20).at(0).unexplained_digits, 12.0);
}

/// A third hinge, to a second body that hangs on the bob in two: what it takes is open, and so is the pair's sum.
TEST_F(SumsTest, ASumThatOtherJointsLeaveOpenIsNotJudged) {
  model_.bodies.push_back(model_.bodies[1]);
  for (int n = 0; n < 2; ++n) {
    Joint more = model_.joints[0];
    more.name = n == 0 ? "C" : "D";
    more.sides[0].body = 1;
    more.sides[1].body = 2;
    model_.joints.push_back(more);
  }
  for (int n = 0; n < 2; ++n) {
    Joint more = model_.joints[0];
    more.name = n == 0 ? "E" : "F";
    more.sides[1].body = 2;
    model_.joints.push_back(more);
  }
  state_.bodies.push_back(state_.bodies[1]);
  Evaluation evaluation;
  evaluation.joints.resize(6);
  const QuantityLayout layout(model_);
  const std::vector<Measured> measured(layout.quantities().size());
  Mask judged = Mask::Constant(static_cast<Eigen::Index>(measured.size()), 1, true);
  const auto samples = [&] {
    return compare_pair_sums(layout, {{state_, {evaluation, evaluation}}}, measured, {nullptr, &judged}).at(0).samples;
  };
  EXPECT_EQ(samples(), 1);
  judged(layout.row_of({Kind::total, 2, Side::parent, 1}), 0) = false;  // C on the bob: A and B are open with it
  EXPECT_EQ(samples(), 0);
}

TEST_F(SumsTest, WhereNothingIsJudgedNoSumIs) {
  Evaluation wrong = shared_out({-40.0, 11.0, 5.0});
  wrong.joints[1].total[index(Side::parent)].in_global.force(0) += 1e-3;
  const QuantityLayout layout(model_);
  const std::vector<Measured> measured(layout.quantities().size());
  const auto n = static_cast<Eigen::Index>(measured.size());
  const MatX resolutions = MatX::Constant(n, 1, 1e-15);
  const Mask singular = Mask::Constant(n, 1, false);
  const auto sums =
      compare_pair_sums(layout, {{state_, {shared_out({3.0, -2.0, 7.0}), wrong}}}, measured, {&resolutions, &singular});
  EXPECT_EQ(sums.at(0).samples, 0);
  EXPECT_EQ(sums.at(0).unexplained_digits, 16.0);
}

TEST_F(SumsTest, SingleJointsHaveNoSum) {
  const Model single = pendulum_model();
  EXPECT_TRUE(compare_pair_sums(QuantityLayout(single), {}, {}).empty());
}

}  // namespace
}  // namespace concord::compare
