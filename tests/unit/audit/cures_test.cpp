#include "compare/audit/cures.h"

#include <gtest/gtest.h>

#include <memory>

#include "common/joints/distance.h"
#include "common/joints/revolute.h"
#include "common/joints/spherical.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

class CuresTest : public ::testing::Test {
 protected:
  /// A joint on the hinge's axis, 0.2 m off its point.
  void add_on_axis(const joints::JointType& type) {
    Joint beside = model_.joints[0];
    beside.name = "beside";
    beside.type = &type;
    for (Attachment& side : beside.sides) side.point_L += side.C.col(2) * 0.2;
    beside.start = {{}};
    model_.joints.push_back(beside);
    state_.q.emplace_back(VecX::Zero(type.n_q()));
    state_.u.emplace_back(VecX::Zero(type.n_u()));
  }

  std::vector<std::string> told(int most_tries = kMostTries) const {
    std::vector<std::string> all;
    for (const auto& changes : find_cures(model_, state_, most_tries).found) all.push_back(describe(model_, changes));
    return all;
  }

  Model model_ = pendulum_model();
  State state_ = FakePendulum(model_, "pendulum").assemble();
};

TEST_F(CuresTest, AHingeAloneNeedsNone) {
  const Cures cures = find_cures(model_, state_);
  EXPECT_EQ(cures.redundant, 0);
  EXPECT_TRUE(cures.found.empty());
}

/// The ball adds three constraints to a hinge that holds the body already.
TEST_F(CuresTest, OneJointOnTheAxisIsOneTooMany) {
  add_on_axis(joints::spherical);
  EXPECT_EQ(find_cures(model_, state_).redundant, 3);
  EXPECT_EQ(told(), std::vector<std::string>{"joint beside were free"});
}

/// Five redundant constraints: one hinge leaves no other.
TEST_F(CuresTest, EitherOfTwoHingesIsOneTooMany) {
  add_on_axis(joints::revolute);
  EXPECT_EQ(told(), (std::vector<std::string>{"joint A were free", "joint beside were free"}));
  model_.joints[0].drivers = {{0, Polynomial{{0.7, 3.1}}}};
  EXPECT_EQ(told(), std::vector<std::string>{"joint beside were free"}) << "a driver needs its coordinate";
}

/// A rod that meets the hinge in its point, across its axis, pushes along nothing that a sleeve would free.
TEST_F(CuresTest, AChangeThatFreesNothingOfTheSelfStressIsNoCure) {
  Joint rod = model_.joints[0];
  rod.name = "rod";
  rod.own_type = std::make_shared<joints::JointType>(joints::distance.with_parameters({0.3}));
  rod.type = rod.own_type.get();
  const Mat3 hinge = rod.sides[0].C;
  rod.sides[0].C << hinge.col(1), hinge.col(2), hinge.col(0);  // z along the rod
  rod.sides[0].point_L -= 0.3 * hinge.col(0);
  model_.joints.push_back(rod);
  EXPECT_EQ(find_cures(model_, state_).redundant, 1);
  EXPECT_EQ(told(), std::vector<std::string>{"joint rod were free"});
}

TEST_F(CuresTest, TheSearchEndsAfterSoManyTries) {
  add_on_axis(joints::revolute);
  const Cures cures = find_cures(model_, state_, 1);
  EXPECT_EQ(cures.tried, 1);
  EXPECT_FALSE(cures.is_complete);
  EXPECT_EQ(told(1), std::vector<std::string>{"joint A were free"});
}

}  // namespace
}  // namespace concord::compare
