#include "compare/oracle/plan.h"

#include <gtest/gtest.h>

#include "common/joints/catalogue.h"

namespace concord::compare::oracle {

namespace {

/// Bodies 1, 2, ... and joints from parent to child.
Model machine_with(int bodies, const std::vector<std::pair<int, int>>& joints) {
  Model model;
  model.bodies.resize(static_cast<std::size_t>(bodies) + 1);
  for (const auto& [parent, child] : joints) {
    Joint joint;
    joint.type = joints::find("revolute");
    joint.sides[0].body = parent;
    joint.sides[1].body = child;
    model.joints.push_back(joint);
  }
  return model;
}

/// Each step as joint, body and whether it adds the body itself.
std::vector<std::array<int, 3>> steps_of(const Model& model) {
  std::vector<std::array<int, 3>> steps;
  for (const Step& step : plan_of(model)) steps.push_back({step.joint, step.body, step.is_main ? 1 : 0});
  return steps;
}

using Steps = std::vector<std::array<int, 3>>;

TEST(Plan, FollowsAChainWhateverTheOrderOfItsJoints) {
  EXPECT_EQ(steps_of(machine_with(2, {{1, 2}, {0, 1}})), (Steps{{1, 1, 1}, {0, 2, 1}}));
}

TEST(Plan, SplitsTheChildThatClosesALoop) {
  const Model model = machine_with(2, {{0, 1}, {1, 2}, {0, 2}});
  const std::vector<Step> plan = plan_of(model);
  EXPECT_EQ(steps_of(model), (Steps{{0, 1, 1}, {1, 2, 1}, {2, 2, 0}}));
  EXPECT_EQ(parts_of(model, plan), (std::vector<int>{0, 1, 2}));
}

TEST(Plan, LetsABodyGoFreeThatNoJointCarries) {
  // Joint 0 runs from body 2 to body 1, and joint 1 from body 1 to ground: body 2 is the one to start from.
  const Model model = machine_with(2, {{2, 1}, {1, 0}});
  EXPECT_EQ(steps_of(model), (Steps{{-1, 2, 1}, {0, 1, 1}, {1, 0, 0}}));
  EXPECT_EQ(parts_of(model, plan_of(model)), (std::vector<int>{1, 1, 1}));
}

TEST(Plan, StartsSomewhereInARingThatNothingCarries) {
  // A ring of bodies that hangs on ground as its child: every body is the child of another.
  const Model model = machine_with(2, {{1, 2}, {2, 1}, {1, 0}});
  EXPECT_EQ(steps_of(model), (Steps{{-1, 1, 1}, {0, 2, 1}, {1, 1, 0}, {2, 0, 0}}));
}

}  // namespace

}  // namespace concord::compare::oracle
