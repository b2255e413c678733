#include "relative/start/assembly.h"

#include <gtest/gtest.h>

#include "machines.h"
#include "relative/start/states.h"

namespace concord::relative {
namespace {

std::string complaint_about(const Model& model) {
  try {
    Equations equations(model);
    (void)Assembly(equations).start();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no complaint";
}

double misfit_of(Equations& equations, const Coordinates& coordinates) {
  return Assembly(equations).misfit(coordinates);
}

class AssembledLoop : public ::testing::TestWithParam<int> {
 protected:
  AssembledLoop() : model_(test::spatial_slider_crank(true)) { model_.joints[GetParam()].named_as_cut = true; }
  Model model_;
};

TEST_P(AssembledLoop, KeepsItsStartExactlyAndClosesToRoundOff) {
  // Away from the pose in which the machine was made, so that Newton's method has work to do.
  model_.joints[0].start[0].q(0) += 0.35;
  Equations equations(model_);
  const Coordinates start = Assembly(equations).start();
  const Topology& topology = equations.topology();
  equations.move(0.0, start.q, start.u);
  EXPECT_LT(misfit_of(equations, start), 2e-15);
  const bool crank_is_cut = GetParam() == 0;
  EXPECT_NEAR(equations.motion().q()(topology.joints[0].first_q), model_.joints[0].start[0].q(0),
              crank_is_cut ? 2e-15 : 0.0);
  EXPECT_NEAR(equations.motion().u()(topology.joints[0].first_u), 2.3, crank_is_cut ? 1e-14 : 0.0);
  EXPECT_EQ(equations.motion().q().segment(topology.modes[2].first_q, 3), model_.bodies[2].a_start);
  EXPECT_EQ(equations.motion().u().segment(topology.modes[2].first_u, 3), model_.bodies[2].adot_start);
}

TEST_P(AssembledLoop, ReachesThePoseThatTheDefaultCutReaches) {
  model_.joints[0].start[0].q(0) += 0.2;
  Model ruled = model_;
  for (Joint& joint : ruled.joints) joint.named_as_cut = false;
  const auto assembled = [](const Model& model) {
    Equations equations(model);
    const Coordinates start = Assembly(equations).start();
    return States(equations).write(equations.move(0.0, start.q, start.u), {});
  };
  const State one = assembled(model_);
  const State other = assembled(ruled);
  for (std::size_t i = 1; i < model_.bodies.size(); ++i) {
    EXPECT_LT((one.bodies[i].r - other.bodies[i].r).norm(), 1e-13);
    EXPECT_LT((one.bodies[i].v - other.bodies[i].v).norm(), 1e-12);
    EXPECT_LT((one.bodies[i].omega - other.bodies[i].omega).norm(), 1e-12);
  }
}

TEST_P(AssembledLoop, ClosesAGuessNearby) {
  Equations equations(model_);
  Assembly assembly(equations);
  Coordinates pose = assembly.start();
  test::Numbers numbers(41);
  const Topology& topology = equations.topology();
  const VecX modes = pose.q.segment(topology.modes[2].first_q, 3);
  pose.q.head(topology.n_tree_q) += numbers.vector(topology.n_tree_q, 0.03);
  pose.u.head(topology.n_tree_u) += numbers.vector(topology.n_tree_u, 0.3);
  pose.q.segment(topology.modes[2].first_q, 3) = modes;
  ASSERT_TRUE(assembly.close(pose));
  EXPECT_LT(assembly.misfit(pose), 2e-15);
  EXPECT_EQ(pose.q.segment(topology.modes[2].first_q, 3), modes);
}

TEST_P(AssembledLoop, ProjectsASmallDriftAway) {
  Equations equations(model_);
  Assembly assembly(equations);
  Coordinates pose = assembly.start();
  const VecX before = pose.q;
  pose.q.array() += 1e-8;
  pose.u.array() += 1e-8;
  assembly.project(pose);
  // A dozen roundings along the loop, of about a metre, in parts of the machine's length.
  EXPECT_LT(assembly.misfit(pose), 5e-15 / std::min(1.0, equations.size().length()));
  EXPECT_LT((pose.q - before).norm(), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(CutAtEach, AssembledLoop, ::testing::Range(0, 4));

/// A lever on a hinge, tied to ground by a rod that the rule cuts: guesses a radian and more away, and a rod whose ends
/// stand apart by far more than its length.
TEST(Assembly, ClosesALinkFromFarGuesses) {
  for (const double away : {-1.6, -0.7, 0.9, 1.4}) {
    test::Numbers numbers(77);
    Model model;
    model.file = "lever.toml";
    model.bodies = {test::ground(), test::rigid_body("lever", numbers)};
    model.bodies[1].pose_guess = Pose{numbers.vector(0.3), numbers.rotation()};
    model.joints = {test::fitting_joint(model, "hinge", "revolute", 0, 1, Vec3(0.1, -0.2, 0.05), numbers),
                    test::fitting_joint(model, "rod", "distance", 0, 1, Vec3(1.1, 0.9, -0.7), numbers)};
    model.joints[0].start[0].q(0) += away;
    model.bodies[1].pose_guess.reset();
    for (WordStart& word : model.joints[1].start) word.role_q = word.role_u = StartRole::unsaid;
    model.joints[0].start[0].role_q = StartRole::guess;
    model.joints[1].drivers.clear();
    Equations equations(model);
    Assembly assembly(equations);
    Coordinates pose{0.0, equations.home(), VecX::Zero(equations.topology().n_u)};
    pose.q(equations.topology().joints[0].first_q) = model.joints[0].start[0].q(0);
    ASSERT_EQ(equations.topology().cuts, std::vector{JointIndex(1)});
    ASSERT_TRUE(assembly.close(pose)) << away;
    EXPECT_LT(misfit_of(equations, pose), 1e-14) << away;
  }
}

TEST(Assembly, ProjectionRefusesALoopThatCannotClose) {
  Model model = test::spatial_slider_crank(false);
  test::release(model.joints[0]);
  model.joints[3].drivers.push_back({0, ConstantSpeed{model.joints[3].start[0].q(0), 40.0}});
  Equations equations(model);
  Assembly assembly(equations);
  Coordinates pose = assembly.start();
  pose.t = 1.0;
  try {
    assembly.project(pose);
    FAIL() << "a gap of forty metres was closed";
  } catch (const SolverError& error) {
    EXPECT_NE(std::string(error.what()).find("the loop of joint 'B' will not close: position residual"),
              std::string::npos);
    EXPECT_NE(std::string(error.what()).find("it was closed at the start: tighten the tolerance"), std::string::npos);
  }
}

TEST(Assembly, FollowsDriversOnTreeAndCutJoints) {
  for (const int cut : {0, 1}) {
    Model model = test::spatial_slider_crank(false);
    model.joints[cut].named_as_cut = true;
    test::release(model.joints[0]);
    model.joints[0].drivers.push_back({0, Harmonic{model.joints[0].start[0].q(0), 0.3, 5.0, 0.2}});
    Equations equations(model);
    const Coordinates start = Assembly(equations).start();
    const TimeFunctionValue law = evaluate(model.joints[0].drivers[0].law, 0.0);
    EXPECT_EQ(start.q(equations.topology().joints[0].first_q), law.f);
    EXPECT_EQ(start.u(equations.topology().joints[0].first_u), law.fdot);
    EXPECT_LT(misfit_of(equations, start), 2e-15);
  }
}

TEST(Assembly, AsksForAsManyKeptValuesAsDegreesOfFreedom) {
  Model none = test::spatial_slider_crank(false);
  test::release(none.joints[0]);
  EXPECT_EQ(
      complaint_about(none),
      "slider_crank.toml:10:1: error: start: the machine has 1 degree of freedom beside its drivers and modes, so 1 "
      "joint coordinates must be kept, for example turn_z of joint 'A', but 0 are (none)");
  Model two = test::spatial_slider_crank(false);
  test::keep_first_word(two.joints[3], 0.1);
  EXPECT_EQ(complaint_about(two),
            "slider_crank.toml:10:1: error: the start keeps more than the machine has freedoms, and the values "
            "contradict each other: with turn_z of joint 'A' as kept, the speed of slide_z of joint 'D' is "
            "0.182446208, where 0.1 is kept to 1e-09: correct these values, or keep fewer");
  Model only_position = test::spatial_slider_crank(false);
  only_position.joints[0].start[0].role_u = StartRole::guess;
  EXPECT_EQ(
      complaint_about(only_position),
      "slider_crank.toml:10:1: error: start: the machine has 1 degree of freedom beside its drivers and modes, so 1 "
      "joint speeds must be kept, for example turn_z of joint 'A', but 0 are (none)");
}

TEST(Assembly, NamesJointsWhoseKeptValuesCannotBeReached) {
  Model model = test::spatial_slider_crank(false);
  test::release(model.joints[0]);
  test::keep_first_word(model.joints[3], 0.1);
  model.joints[3].start[0].q(0) = 50.0;
  const std::string complaint = complaint_about(model);
  EXPECT_EQ(
      complaint.find("slider_crank.toml:10:1: error: start: the kept joint coordinates (1 of joint 'D') "
                     "contradict each other, or the guesses are too far off: the loops do not close with them; "
                     "where the other joints are closed, joint 'B', at which the loop is cut, is left open by 50.69 "
                     "m along ("),
      0U)
      << complaint;
}

TEST(Assembly, KeepsACoordinateOfTheCutJoint) {
  Model model = test::spatial_slider_crank(false);
  model.joints[3].named_as_cut = true;
  test::release(model.joints[0]);
  test::keep_first_word(model.joints[3], 0.4);
  model.joints[3].start[0].q(0) -= 0.02;
  Equations equations(model);
  const Coordinates start = Assembly(equations).start();
  equations.move(0.0, start.q, start.u);
  EXPECT_DOUBLE_EQ(equations.motion().q()(equations.topology().joints[3].first_q), model.joints[3].start[0].q(0));
  EXPECT_NEAR(equations.motion().u()(equations.topology().joints[3].first_u), 0.4, 1e-15);
  EXPECT_LT(misfit_of(equations, start), 2e-15);
}

TEST(Assembly, NamesBodyAndAxisWithoutInertia) {
  Model model = test::spatial_slider_crank(false);
  model.joints[2].named_as_cut = true;
  const Vec3 line = model.joints[1].sides[0].C * Vec3(2.0, 6.0, -3.0) / 7.0;  // along no axis of the joint
  model.bodies[2].center_of_mass_L = model.joints[1].sides[0].point_L + 0.2 * line;
  model.bodies[2].inertia_L = 0.01 * (Mat3::Identity() - line * line.transpose());
  // The tree runs against B (parent: coupler), so that its speeds count in the coupler's own joint frame.
  EXPECT_EQ(complaint_about(model),
            "slider_crank.toml:10:1: error: body 'coupler' and all that it carries in the opened tree have no inertia "
            "about the axis (0.2857, 0.8571, -0.4286) of joint 'B' (parent's joint frame): give it inertia or name "
            "another cut joint");
}

/// Places are kept at the crank and speeds at the cut slide, whose place is no more than a guess.
TEST(Assembly, KeepsASpeedOfACutJointWhosePlaceIsFree) {
  for (const int cut : {0, 3}) {
    Model model = test::spatial_slider_crank(true);
    model.joints[cut].named_as_cut = true;
    const int kept = cut;
    const int other = 3 - cut;
    test::release(model.joints[0]);
    model.joints[other].start[0].role_q = StartRole::keep;
    model.joints[kept].start[0].role_u = StartRole::keep;
    model.joints[kept].start[0].u(0) = -0.83;
    Equations equations(model);
    const Coordinates start = Assembly(equations).start();
    EXPECT_NEAR(start.q(equations.topology().joints[other].first_q), model.joints[other].start[0].q(0), 1e-14) << cut;
    EXPECT_NEAR(start.u(equations.topology().joints[kept].first_u), -0.83, 1e-14) << cut;
    EXPECT_LT(misfit_of(equations, start), 5e-15) << cut;
  }
}

}  // namespace
}  // namespace concord::relative
