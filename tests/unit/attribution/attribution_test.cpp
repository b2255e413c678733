#include "compare/attribution/attribution.h"

#include <gtest/gtest.h>

#include "compare/audit/places.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

void leave_springs_in_the_reaction(const State&, Evaluation& evaluation) {
  evaluation.joints[0].reaction = evaluation.joints[0].total;
}

void swap_axes(const State&, Evaluation& evaluation) {
  for (SideWrench& side : evaluation.joints[0].total) std::swap(side.in_C.force(0), side.in_C.force(1));
}

/// Two pendulum solvers, of which the second one has a fault, asked along a run.
class AttributionTest : public ::testing::Test {
 protected:
  /// What is to blame, if the first solver is right about `model_` and the second one solves `other`.
  std::optional<Attribution> blame(const Model& other) {
    FakePendulum right(model_, "right");
    FakePendulum wrong(other, "wrong");
    wrong.spoil = spoil_;
    RunOptions run;
    run.until = 2.0;
    run.samples = 60;
    const Trajectory trajectory = right.integrate(run, {});
    std::array<Auditor, 2> auditors{Auditor(model_), Auditor(model_)};
    std::vector<std::array<Evaluation, 2>> evaluations;
    for (const Sample& sample : trajectory.samples) {
      evaluations.push_back({right.evaluate(sample.state), wrong.evaluate(sample.state)});
      for (int who = 0; who < 2; ++who) auditors[who].add(sample.state, evaluations.back()[who]);
    }
    Evidence evidence{model_, {auditors[0].report(), auditors[1].report()}, {}, {}};
    for (std::size_t k = 0; k < evaluations.size(); ++k) {
      evidence.states.push_back({&trajectory.samples[k].state, {&evaluations[k][0], &evaluations[k][1]}});
    }
    return find_cause(evidence);
  }
  std::optional<Attribution> blame() { return blame(model_); }

  enum class Spoiled { both, one };

  /// The same of one state alone. Where both solvers have the fault of `spoil_`, their answers agree; where the second
  /// one has it, they differ, and no states tell whether the bodies move alike.
  std::optional<Attribution> blame_of_one_state(const Model& solved, Spoiled spoiled) {
    FakePendulum one(solved, "one");
    FakePendulum other(solved, "other");
    other.spoil = spoil_;
    if (spoiled == Spoiled::both) one.spoil = spoil_;
    std::array<Auditor, 2> auditors{Auditor(model_), Auditor(model_)};
    const State state = one.assemble();
    const std::array<Evaluation, 2> evaluations{one.evaluate(state), other.evaluate(state)};
    for (int who = 0; who < 2; ++who) auditors[who].add(state, evaluations[who]);
    Evidence evidence{model_, {auditors[0].report(), auditors[1].report()}, {}, {}};
    evidence.answers_differ = spoiled == Spoiled::one;
    if (spoiled == Spoiled::both) evidence.states.push_back({&state, {&evaluations[0], &evaluations[1]}});
    return find_cause(evidence);
  }

  /// Adds a force at the hinge to the reaction, and not to the total.
  void push(const State& state, const Vec3& force, Evaluation& evaluation) const {
    for (const Side side : kSides) {
      SideWrench& one = evaluation.joints[0].reaction[index(side)];
      one.in_global.force += side == Side::child ? force : Vec3(-force);
      const Mat3 axes = place(model_.joints[0].on(side), state.bodies[side == Side::child ? 1 : 0]).A_joint;
      one.in_C.force = axes.transpose() * one.in_global.force;
    }
  }

  void expect(const std::optional<Attribution>& found, Term term, const std::string& where) {
    ASSERT_TRUE(found);
    EXPECT_EQ(found->solver, 1) << describe(*found);
    EXPECT_STREQ(name_of(found->term), name_of(term)) << describe(*found);
    EXPECT_EQ(found->where, where) << describe(*found);
  }

  /// Moves the bob's acceleration and what it takes at the hinge, so that its forces add up as before.
  void accelerate(const State& state, const Vec3& more, Evaluation& evaluation) const {
    const Body& bob = model_.bodies[1];
    const Attachment& hinge = model_.joints[0].on(Side::child);
    const Mat3 A = rotation_of(state.bodies[1].p);
    const Vec3 force = bob.mass * more;
    const Vec3 torque = (A * (bob.center_of_mass_L - hinge.point_L)).cross(force);
    evaluation.bodies[1].vdot += more;
    for (auto* wrenches : {&evaluation.joints[0].total, &evaluation.joints[0].reaction}) {
      for (const Side side : kSides) {
        const double sign = side == Side::child ? 1.0 : -1.0;
        SideWrench& one = (*wrenches)[index(side)];
        one.in_global += Wrench{sign * force, sign * torque};
        const Mat3 axes = place(model_.joints[0].on(side), state.bodies[side == Side::child ? 1 : 0]).A_joint;
        one.in_C = {axes.transpose() * one.in_global.force, axes.transpose() * one.in_global.torque};
      }
    }
  }

  Model model_ = sprung_pendulum_model();
  std::function<void(const State&, Evaluation&)> spoil_ = [](const State&, Evaluation&) {};
};

TEST_F(AttributionTest, NobodyIsBlamedWhereNothingDiffers) { EXPECT_FALSE(blame()); }

TEST_F(AttributionTest, AWrongMassIsInertia) {
  Model heavy = model_;
  heavy.bodies[1].inertia_L *= 1.01;
  expect(blame(heavy), Term::inertia, "body bob");
}

TEST_F(AttributionTest, AWrongStiffnessIsAppliedAtItsElement) {
  Model stiff = model_;
  std::get<LineSpring>(stiff.elements[0].what).law.stiffness *= 1.001;
  expect(blame(stiff), Term::applied, "force element strut");
}

TEST_F(AttributionTest, AWrongSpringOnAJointIsAppliedThere) {
  Model stiff = model_;
  stiff.joints[0].springs[0].law.stiffness *= 1.001;
  expect(blame(stiff), Term::applied, "joint A");
}

/// The centripetal acceleration of the hinge's lever, of which a part is lost.
TEST_F(AttributionTest, AMissingTermOfSpeedsIsABias) {
  spoil_ = [this](const State& state, Evaluation& evaluation) {
    const Vec3 omega = state.bodies[1].omega;
    const Vec3 lever = place(model_.joints[0].on(Side::child), state.bodies[1]).lever;
    accelerate(state, -0.3 * omega.cross(omega.cross(lever)), evaluation);
  };
  expect(blame(), Term::bias, "joint A");
}

TEST_F(AttributionTest, AMissingTermOfAccelerationsIsAJacobian) {
  spoil_ = [this](const State& state, Evaluation& evaluation) {
    const Vec3 lever = place(model_.joints[0].on(Side::child), state.bodies[1]).lever;
    accelerate(state, -0.3 * evaluation.bodies[1].omegadot.cross(lever), evaluation);
  };
  expect(blame(), Term::jacobian, "joint A");
}

TEST_F(AttributionTest, WhatASpringDoesLeftInTheReactionIsASubtraction) {
  spoil_ = leave_springs_in_the_reaction;
  expect(blame(), Term::subtraction, "joint A");
}

TEST_F(AttributionTest, OtherAxesAreAFrame) {
  spoil_ = swap_axes;
  expect(blame(), Term::frame, "joint A");
}

TEST_F(AttributionTest, EachBodyWithTheOthersWrenchIsASide) {
  spoil_ = [](const State&, Evaluation& evaluation) {
    std::swap(evaluation.joints[0].total[0], evaluation.joints[0].total[1]);
    std::swap(evaluation.joints[0].reaction[0], evaluation.joints[0].reaction[1]);
  };
  expect(blame(), Term::side, "joint A");
}

TEST_F(AttributionTest, TorquesAboutAnotherPointAreAPoint) {
  spoil_ = [](const State& state, Evaluation& evaluation) {
    for (auto* wrenches : {&evaluation.joints[0].total, &evaluation.joints[0].reaction}) {
      SideWrench& on_child = (*wrenches)[1];
      const Vec3 more = Vec3(0.1, -0.2, 0.3).cross(on_child.in_global.force);
      on_child.in_global.torque += more;
      const Mat3 axes = rotation_of(state.bodies[1].p);
      on_child.in_C.torque += axes.transpose() * more;
    }
  };
  const auto found = blame();
  ASSERT_TRUE(found);
  EXPECT_STREQ(name_of(found->term), name_of(Term::point)) << describe(*found);
}

TEST_F(AttributionTest, AFaultThatBothShareIsBoths) {
  const Model stated = model_;
  std::get<LineSpring>(model_.elements[0].what).law.stiffness *= 1.01;
  const auto found = blame_of_one_state(stated, Spoiled::both);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->solver, 2);
  EXPECT_EQ(found->where, "force element strut");
}

TEST_F(AttributionTest, AReactionThatWorksInBothSolversIsOfTheJointsPage) {
  spoil_ = leave_springs_in_the_reaction;
  const auto found = blame_of_one_state(model_, Spoiled::both);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->solver, 2);
  EXPECT_STREQ(name_of(found->term), name_of(Term::jacobian)) << describe(*found);
  EXPECT_EQ(found->where, "joint A");
}

TEST_F(AttributionTest, ATotalThatIsNotTheSumOfItsSharesIsASubtraction) {
  spoil_ = [this](const State& state, Evaluation& evaluation) { push(state, Vec3(0.3, -0.2, 0.5), evaluation); };
  const auto found = blame_of_one_state(model_, Spoiled::one);
  ASSERT_TRUE(found);
  expect(found, Term::subtraction, "joint A");
  EXPECT_NE(found->because.find("\"drivers\""), std::string::npos) << found->because;
}

TEST_F(AttributionTest, OtherAxesAreAFrameWhereNoStatesAreCompared) {
  spoil_ = swap_axes;
  expect(blame_of_one_state(model_, Spoiled::one), Term::frame, "joint A");
}

TEST_F(AttributionTest, NobodyIsBlamedForADigitLessWhereTheRuleHolds) {
  spoil_ = [this](const State& state, Evaluation& evaluation) { push(state, Vec3(3e-11, -2e-11, 5e-11), evaluation); };
  EXPECT_FALSE(blame_of_one_state(model_, Spoiled::one));
}

}  // namespace
}  // namespace concord::compare
