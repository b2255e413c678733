#include "compare/quantities/observe.h"

#include <gtest/gtest.h>

#include "common/joints/cylindrical.h"
#include "common/joints/free.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

TEST(ObserveTest, ListsEveryNumberInItsRow) {
  Model model = pendulum_model();
  model.joints[0].drivers.push_back({0, ConstantSpeed{0.0, 1.0}});
  FakePendulum solver(model, "cartesian");
  const State state = solver.assemble();
  Evaluation evaluation = solver.evaluate(state);
  evaluation.joints[0].tau(0) = 3.25;
  const QuantityLayout layout(model);
  const VecX values = layout.observe(state, evaluation);
  ASSERT_EQ(values.size(), 12 + 12 + 12 + 1 + 6 + 6);
  const JointWrenches& hinge = evaluation.joints[0];
  EXPECT_EQ(values(layout.row_of({Kind::reaction, 0, Side::parent, 1})), hinge.reaction[0].in_C.force(1));
  EXPECT_EQ(values(layout.row_of({Kind::reaction, 0, Side::child, 5})), hinge.reaction[1].in_C.torque(2));
  EXPECT_EQ(values(layout.row_of({Kind::reaction_global, 0, Side::child, 0})), hinge.reaction[1].in_global.force(0));
  EXPECT_EQ(values(layout.row_of({Kind::total, 0, Side::parent, 3})), hinge.total[0].in_C.torque(0));
  EXPECT_EQ(values(layout.row_of({Kind::tau, 0, Side::child, 0})), 3.25);
  EXPECT_EQ(values(layout.row_of({Kind::acceleration, 1, Side::child, 4})), evaluation.bodies[1].omegadot(1));
  EXPECT_EQ(values.size(), static_cast<Eigen::Index>(layout.quantities().size()));
}

TEST(ObserveTest, FindsEveryRowAndWhatActsInIt) {
  const Model sprung = sprung_pendulum_model();
  Model model = sprung;
  model.joints.push_back(sprung.joints[0]);
  model.joints[1].name = "B";
  model.joints[0].drivers.push_back({0, ConstantSpeed{0.0, 1.0}});
  model.couplings.push_back({"gear", {{0, 0, 0, 1.0}, {1, 0, 0, -2.0}}, 0.0, {}});
  const QuantityLayout layout(model);
  for (std::size_t row = 0; row < layout.quantities().size(); ++row) {
    EXPECT_EQ(layout.row_of(layout.quantities()[row]), static_cast<int>(row));
  }
  EXPECT_THROW(static_cast<void>(layout.row_of({Kind::share, 1, Side::child, 0, Actor::motor})), IncompleteResult);
  FakePendulum solver(sprung, "cartesian");
  const State state = solver.assemble();
  Evaluation evaluation = solver.evaluate(state);
  evaluation.joints.resize(2, evaluation.joints[0]);
  evaluation.couplings = {7.5};
  double force = 1.0;
  for (JointWrenches& joint : evaluation.joints) {
    joint.tau.setConstant(force++);
    for (VecX& share : joint.shares) share = VecX::Constant(1, force++);
  }
  const VecX values = layout.observe(state, evaluation);
  for (int k = 0; k < 2; ++k) {
    const JointWrenches& joint = evaluation.joints[static_cast<std::size_t>(k)];
    EXPECT_EQ(values(layout.row_of({Kind::tau, k, Side::child, 0})), joint.tau(0));
    EXPECT_EQ(values(layout.row_of({Kind::share, k, Side::child, 0, Actor::damper})), joint.share_of(Actor::damper)(0));
  }
  EXPECT_EQ(values(layout.row_of({Kind::coupling, 0, Side::child, 0})), 7.5);
}

TEST(ObserveTest, SumOnABodyIsTakenAboutItsOrigin) {
  const Model model = pendulum_model();
  FakePendulum solver(model, "cartesian");
  const State state = solver.assemble();
  const Evaluation evaluation = solver.evaluate(state);
  const Wrench sum = totals_on_bodies(model, state, evaluation)[1];
  const Wrench& hinge = evaluation.joints[0].total[1].in_global;
  const Vec3 arm = model.joints[0].sides[0].point_L - state.bodies[1].r;
  EXPECT_LT((sum.force - hinge.force).norm(), 1e-15);
  EXPECT_LT((sum.torque - hinge.torque - arm.cross(hinge.force)).norm(), 1e-14);
  EXPECT_GT(arm.cross(hinge.force).norm(), 0.1);
}

TEST(ObserveTest, AJointPointOnAFlexibleBodyMovesWithItsModes) {
  Model model = pendulum_model();
  FakePendulum solver(model, "cartesian");
  State state = solver.assemble();
  const Vec3 before = joint_point(model, state, model.joints[0], Side::child);
  EXPECT_LT((before - model.joints[0].sides[0].point_L).norm(), 1e-15);
  model.bodies[1].modal.emplace().stiffness = MatX::Identity(1, 1);
  model.joints[0].sides[1].Psi_t_L = Vec3(0.1, -0.2, 0.3);
  state.bodies[1].a = VecX::Constant(1, 0.5);
  const Vec3 moved = joint_point(model, state, model.joints[0], Side::child) - before;
  EXPECT_LT((moved - rotation_of(state.bodies[1].p) * Vec3(0.05, -0.1, 0.15)).norm(), 1e-15);
}

TEST(ObserveTest, MissingPartsAreNamed) {
  const Model model = pendulum_model();
  FakePendulum solver(model, "cartesian");
  const State state = solver.assemble();
  Evaluation evaluation = solver.evaluate(state);
  evaluation.joints[0].tau.resize(0);
  try {
    (void)QuantityLayout(model).observe(state, evaluation);
    FAIL();
  } catch (const IncompleteResult& error) {
    EXPECT_STREQ(error.what(), "at t = 0 s: 0 coordinate forces, expected 1");
  }
}

TEST(ObserveTest, NamesAndUnits) {
  Model model = pendulum_model();
  EXPECT_EQ(describe_owner(model, {Kind::reaction, 0, Side::child, 0}), "joint A on bob");
  model.joints[0].drivers.push_back({});
  EXPECT_EQ(describe_owner(model, {Kind::tau, 0, Side::child, 0}), "driver of joint A");
  model.joints[0].springs.resize(1);
  model.joints[0].springs[0].law.stiffness = 2.0;
  EXPECT_EQ(describe_owner(model, {Kind::tau, 0, Side::child, 0}), "coordinate force of joint A");
  EXPECT_EQ(describe_owner(model, {Kind::share, 0, Side::child, 0, Actor::spring}), "spring of joint A");
  EXPECT_EQ(describe_component({Kind::acceleration, 1, Side::child, 7}), "addot_2");
  EXPECT_EQ(unit_of(model, {Kind::tau, 0, Side::child, 0}), "N m");
  EXPECT_EQ(unit_of(model, {Kind::total, 0, Side::child, 2}), "N");
  model.joints[0].type = &joints::cylindrical;
  const bool slides_first = std::holds_alternative<joints::Slide>(joints::cylindrical.permits[0]);
  EXPECT_EQ(unit_of(model, {Kind::tau, 0, Side::child, slides_first ? 0 : 1}), "N");
}

}  // namespace
}  // namespace concord::compare
