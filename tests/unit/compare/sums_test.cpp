#include "compare/sums.h"

#include <gtest/gtest.h>

#include "fake_pendulum.h"

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

  Model model_ = pendulum_model();
  State state_;
  Wrench whole_;
};

TEST_F(SumsTest, TheSumIsTheSameHoweverTheHingesShareIt) {
  const SharedState shared{state_, {shared_out({3.0, -2.0, 7.0}), shared_out({-40.0, 11.0, 5.0})}};
  const std::vector<PairSum> sums = compare_pair_sums(model_, {shared});
  ASSERT_EQ(sums.size(), 1U);
  EXPECT_EQ(sums[0].what, "A + B on bob, at the point of A");
  EXPECT_GT(sums[0].digits, 14.0);
  EXPECT_LT((sums[0].at_start[0].force - whole_.force).norm(), 1e-13);
  EXPECT_LT((sums[0].at_start[1].torque - whole_.torque).norm(), 1e-13);
}

TEST_F(SumsTest, AWrongSumIsSeen) {
  Evaluation wrong = shared_out({-40.0, 11.0, 5.0});
  wrong.joints[1].total[index(Side::parent)].in_global.force(0) += 1e-3;
  const std::vector<PairSum> sums = compare_pair_sums(model_, {{state_, {shared_out({3.0, -2.0, 7.0}), wrong}}});
  EXPECT_LT(sums.at(0).digits, 5.0);
}

TEST_F(SumsTest, SingleJointsHaveNoSum) {
  const Model single = pendulum_model();
  EXPECT_TRUE(compare_pair_sums(single, {}).empty());
}

}  // namespace
}  // namespace concord::compare
