#include "relative/run/singularity_watch.h"

#include <gtest/gtest.h>

#include "machines.h"
#include "relative/solver.h"

namespace concord::relative {
namespace {

/// A parallelogram of hinges, ground - A - crank - B - coupler - C - rocker - D - ground, in a plane tilted in space,
/// whose coupler is longer than the ground by `excess`; it turns fast and comes by the pose in which all points stand
/// on one line, where an exact parallelogram may go on as a kite. `windows` of them share their cranks.
Model parallelogram(double excess, int windows = 1) {
  test::Numbers numbers(31);
  Model model;
  model.file = "parallelogram.toml";
  const Mat3 plane = rotation_about(Vec3(Vec3(2, -1, 1).normalized()), 0.7);
  model.bodies = {test::ground()};
  for (int i = 0; i <= 2 * windows; ++i) {
    model.bodies.push_back(test::rigid_body("bar " + std::to_string(i), numbers));
    model.bodies.back().pose_guess = Pose{numbers.vector(0.3), numbers.rotation()};
  }
  const auto hinge = [&](const std::string& name, int parent, int child, const Vec3& in_plane) {
    Joint made = test::joint(model, name, "revolute", parent, child, numbers);
    const Pose pose = model.bodies[parent].pose_guess.value_or(Pose{});
    made.sides[0].point_L = pose.A.transpose() * (plane * in_plane - pose.r);
    made.sides[0].C = pose.A.transpose() * plane;
    test::fit_child_side(model, made);
    test::release(made);
    return made;
  };
  // Bars 1, 3, 5 ... stand on ground; bar 2 k lies on bars 2 k - 1 and 2 k + 1.
  const Vec3 arm(0.31 * std::cos(1.1), 0.31 * std::sin(1.1), 0.0);
  for (int k = 0; k <= windows; ++k) {
    model.joints.push_back(hinge("ground " + std::to_string(k), 0, 2 * k + 1, Vec3(0.6 * k, 0, 0.05 * k)));
  }
  for (int k = 0; k < windows; ++k) {
    const Vec3 end = Vec3(0.6 * (k + 1), 0, 0.02) + arm + Vec3(excess, 0.3 * excess, 0.0);
    model.joints.push_back(hinge("left " + std::to_string(k), 2 * k + 1, 2 * k + 2, Vec3(0.6 * k, 0, 0.02) + arm));
    model.joints.push_back(hinge("right " + std::to_string(k), 2 * k + 3, 2 * k + 2, end));
  }
  test::keep_first_word(model.joints[0], -2.9);
  return model;
}

Trajectory run_of(const Model& model, double until) {
  RunOptions options;
  options.until = until;
  options.samples = 6;
  options.rtol = 1e-9;
  return make_solver(model)->integrate(options, {});
}

TEST(SingularityWatch, SeesAFlatPoseBetweenSteps) {
  for (const int windows : {1, 2}) {
    try {
      (void)run_of(parallelogram(0.0, windows), 1.3);
      FAIL() << "a flat parallelogram was passed";
    } catch (const SingularPose& error) {
      const std::string text = error.what();
      EXPECT_TRUE(text.starts_with("relative: at t = 0.")) << text;
      EXPECT_NE(text.find("the loop of joint"), std::string::npos) << text;
    }
  }
}

TEST(SingularityWatch, LetsAMachinePassThatStaysRegular) {
  EXPECT_EQ(run_of(parallelogram(0.0), 0.2).samples.size(), 7u);
  EXPECT_EQ(run_of(parallelogram(-0.004), 1.3).samples.size(), 7u);
  EXPECT_EQ(run_of(test::spatial_slider_crank(false), 1.5).samples.size(), 7u);
}

/// A rod from the ground to a body that falls through the axis of the rod's first turn.
TEST(SingularityWatch, SeesALinkPassTheAxisOfItsFirstTurn) {
  test::Numbers numbers(52);
  Model model;
  model.file = "rod.toml";
  model.bodies = {test::ground(), test::rigid_body("bob", numbers)};
  model.joints = {test::joint(model, "rod", "distance", 0, 1, numbers)};
  model.gravity.setZero();
  model.joints[0].sides[1].point_L = model.bodies[1].center_of_mass_L;  // the rod moves in one plane
  std::vector<WordStart>& words = model.joints[0].start;
  words[0].q(0) = 0.2;
  words[0].u(0) = 0.0;
  words[1].q(0) = 1.2;
  words[1].u(0) = 2.0;
  words[2].u.setZero();
  EXPECT_THROW((void)run_of(model, 1.0), SingularPose);
}

}  // namespace
}  // namespace concord::relative
