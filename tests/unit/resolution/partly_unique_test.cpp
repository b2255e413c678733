#include "compare/resolution/partly_unique.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "compare/quantities/needs.h"
#include "compare/verdict/redundant.h"
#include "tests/unit/two_balls.h"

namespace concord::compare {
namespace {

/// A pendulum on two balls, in four states of its run, by solvers that share its thrust in ways of their own.
class PartlyUniqueTest : public ::testing::Test {
 protected:
  PartlyUniqueTest() {
    const Model pendulum = pendulum_model();
    FakePendulum hinge(pendulum, "pendulum");
    const Trajectory run = hinge.integrate({0.3, 1e-11, 3, ""}, [](double) {});
    RankReport report;
    report.constraints = 6;
    report.rank = 5;
    report.degrees_of_freedom = 1;
    report.joints.resize(2);
    for (JointUniqueness& joint : report.joints) {
      for (auto& side : joint.unique) side[0] = side[1] = side[2] = false;
    }
    for (int k = 0; k < 4; ++k) {
      SharedState& one = weighed_.states.emplace_back();
      one.state = on_two_balls(run.samples[static_cast<std::size_t>(k)].state);
      one.row = k;
      for (const Who who : kBothSolvers) one.evaluations[index(who)] = answer(one.state, who);
      weighed_.reports.push_back({report, report});
      weighed_.singular.emplace_back();
    }
  }

  /// Across the axis 3 N (and as many as the number of the state) on the near ball, 7 N on the far one; along it what
  /// the solver likes.
  [[nodiscard]] Evaluation answer(const State& state, Who who) const {
    Evaluation evaluation;
    evaluation.bodies.resize(2);
    for (auto& one : evaluation.bodies) one.addot = VecX(0);
    evaluation.joints.resize(2);
    const Vec3 across = axis_of_balls().unitOrthogonal();
    const std::array<double, 2> thrust = who == Who::cartesian ? std::array{40.0, -30.0} : std::array{-11.0, 21.0};
    for (int k = 0; k < 2; ++k) {
      JointWrenches& joint = evaluation.joints[static_cast<std::size_t>(k)];
      joint.tau = VecX::Zero(3);
      joint.shares.fill(VecX::Zero(3));
      const Vec3 on_child =
          (k == 0 ? 3.0 + 10.0 * state.t : 7.0) * across + thrust[static_cast<std::size_t>(k)] * axis_of_balls();
      for (const Side side : kSides) {
        const Vec3 force = side == Side::child ? on_child : Vec3(-on_child);
        SideWrench& wrench = joint.reaction[static_cast<std::size_t>(index(side))];
        wrench.in_global.force = force;
        wrench.in_C.force = joint_frame_on(model_, state, k, side).transpose() * force;
        joint.total[static_cast<std::size_t>(index(side))] = wrench;
      }
    }
    return evaluation;
  }

  std::vector<PartlyUnique> parts() {
    weighed_.mask = judged_states(layout_, weighed_.reports);
    leave_out_isolated(layout_, weighed_.states, weighed_.reports, weighed_.mask);
    weighed_.open = open_reactions(model_, weighed_.states, weighed_.reports);
    weighed_.series = align(layout_, weighed_.states);
    const auto rows = static_cast<Eigen::Index>(layout_.quantities().size());
    weighed_.resolution.both = MatX::Constant(rows, 4, 1e-14);
    return partly_unique(layout_, weighed_, measure(layout_, weighed_.series));
  }

  Model model_ = two_balls_model();
  QuantityLayout layout_{model_};
  WeighedStates weighed_;
};

TEST_F(PartlyUniqueTest, WhatTwoBallsCarryAcrossTheirLineIsUnique) {
  const std::vector<PartlyUnique> found = parts();
  ASSERT_EQ(found.size(), 4U);
  for (const PartlyUnique& part : found) {
    EXPECT_EQ(part.of.component, 0);
    EXPECT_EQ(part.samples, 4);
    EXPECT_GT(part.digits, 14.0) << "the thrusts differ by 51 N";
    EXPECT_TRUE(part.holds(12.0));
    EXPECT_TRUE(part.is_fixed);
    EXPECT_NEAR(part.peak, part.of.owner == 0 ? 6.0 : 7.0, 1e-12);
    EXPECT_NEAR(part.t_peak, part.of.owner == 0 ? 0.3 : 0.0, 1e-12);
    ASSERT_EQ(part.left_out.cols(), 1);
    const State& start = weighed_.states[0].state;
    const Mat3 A = part.of.side == Side::child ? rotation_of(start.bodies[1].p) : Mat3(Mat3::Identity());
    EXPECT_NEAR((A * part.left_out).col(0).cross(axis_of_balls()).norm(), 0.0, 1e-12) << "in the axes of the body";
  }
}

TEST_F(PartlyUniqueTest, ADifferenceAcrossTheLineIsSeenOnItsJointAndSide) {
  Vec3& force = weighed_.states[2].evaluations[1].joints[1].reaction[index(Side::child)].in_C.force;
  const Vec3 axis = joint_frame_on(model_, weighed_.states[2].state, 1, Side::child).transpose() * axis_of_balls();
  force += 1e-6 * axis.unitOrthogonal();
  for (const PartlyUnique& part : parts()) {
    const bool is_there = part.of.owner == 1 && part.of.side == Side::child;
    EXPECT_EQ(part.holds(12.0), !is_there);
    if (is_there) EXPECT_NEAR(part.digits, 7.5, 0.1) << "of 31 N";
  }
}

TEST_F(PartlyUniqueTest, ADifferenceIsAFindingThatNamesTheJointAndWhatIsLeftOut) {
  Verdict verdict;
  verdict.need = default_needs(model_);
  parts();
  judge_redundant(layout_, weighed_, measure(layout_, weighed_.series), verdict);
  EXPECT_TRUE(verdict.findings.empty());
  EXPECT_EQ(verdict.partly_unique.size(), 4U);
  weighed_.states[2].evaluations[1].joints[1].reaction[index(Side::parent)].in_C.force *= 1.01;
  parts();
  judge_redundant(layout_, weighed_, measure(layout_, weighed_.series), verdict);
  ASSERT_EQ(verdict.findings.size(), 1U);
  const Vec3 axis = axis_of_balls();
  EXPECT_EQ(verdict.findings[0].what,
            fmt::format("joint far on ground, F but for its part along ({:.6g}, {:.6g}, {:.6g}) of ground: 2.6 digits "
                        "(need 12)",
                        axis(0), axis(1), axis(2)));
}

TEST_F(PartlyUniqueTest, WhatTheSolversDoNotBothCallOpenIsNotTaken) {
  weighed_.reports[1][0].joints[0].unique[index(Side::child)][1] = true;
  for (const PartlyUnique& part : parts()) EXPECT_EQ(part.samples, 3);
  for (auto& reports : weighed_.reports) reports[1].rank = 6;
  EXPECT_TRUE(parts().empty()) << "the audit finds another number of redundant constraints";
}

TEST_F(PartlyUniqueTest, SingularStatesDoNotCount) {
  weighed_.singular[0] = weighed_.singular[3] = "singular";
  const std::vector<PartlyUnique> found = parts();
  ASSERT_EQ(found.size(), 4U);
  EXPECT_EQ(found[0].samples, 2);
  EXPECT_NEAR(found[0].peak, 5.0, 1e-12);
}

TEST_F(PartlyUniqueTest, BearingsOfOneAxleAreNoPlanarLoop) {
  parts();
  EXPECT_FALSE(planar_loops(model_, weighed_));
}

TEST_F(PartlyUniqueTest, TheDirectionLeftOutIsToldInTheAxesOfItsBody) {
  const std::vector<PartlyUnique> found = parts();
  const Vec3 axis = axis_of_balls();
  EXPECT_EQ(describe(model_, found.at(0)),
            fmt::format("joint near on ground, F but for its part along ({:.6g}, {:.6g}, {:.6g}) of ground", axis(0),
                        axis(1), axis(2)));
}

TEST_F(PartlyUniqueTest, OfTwoDirectionsLeftOutTheThirdOneIsTold) {
  PartlyUnique part;
  part.of = {Kind::reaction, 0, Side::child, 3};
  part.left_out = rotation_about(Vec3(2, -1, 2) / 3.0, 1.3).rightCols<2>();
  part.is_fixed = false;
  part.t = 0.25;
  const Vec3 left = rotation_about(Vec3(2, -1, 2) / 3.0, 1.3).col(0);
  EXPECT_EQ(describe(model_, part),
            fmt::format("joint near on bob, T only along ({:.6g}, {:.6g}, {:.6g}) of bob at t = "
                        "0.25 s",
                        left(0), left(1), left(2)));
}

}  // namespace
}  // namespace concord::compare
