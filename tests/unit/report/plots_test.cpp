#include "compare/report/plots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>

#include "common/joints/catalogue.h"
#include "tests/unit/temporary_folder.h"

namespace concord::compare {
namespace {

namespace fs = std::filesystem;

/// A joint whose forces swing; the second run is off by what `error` says.
struct TwoRuns {
  Model model;
  Trajectory first;
  Trajectory second;

  explicit TwoRuns(double error) {
    model.name = "slider_crank";
    model.bodies.resize(2);
    model.bodies[1].name = "crank";
    model.joints.resize(2);
    model.joints[0].name = "A";
    model.joints[1].name = "joint's B";
    for (Joint& joint : model.joints) {
      joint.type = joints::find("revolute");
      joint.sides[1].body = 1;
    }
    for (int k = 0; k <= 200; ++k) {
      first.samples.push_back(sample(0.015 * k, 0.0));
      second.samples.push_back(sample(0.015 * k, error));
    }
  }

  static Sample sample(double t, double error) {
    Sample sample;
    sample.state.t = t;
    sample.evaluation.joints.resize(2);
    for (JointWrenches& joint : sample.evaluation.joints) {
      Wrench& reaction = joint.reaction[1].in_C;
      reaction.force = Vec3(120.0 * std::sin(7.0 * t), 35.0 + 60.0 * std::cos(9.0 * t), 1e-13 * std::sin(50.0 * t));
      reaction.torque = Vec3(0.4 * std::sin(3.0 * t), 0.02 * t, 0.0);
      reaction.force.x() += error * std::sin(20.0 * t);
    }
    return sample;
  }
};

TEST(ReactionPage, ShowsBothSolversAndTheirDifferenceForEveryComponent) {
  const TwoRuns runs(1e-9);
  const Page page = reaction_page(runs.model, 0, {"cartesian", "relative"}, runs.first, runs.second);
  EXPECT_EQ(page.title, "slider_crank: reaction of joint A (revolute) on crank, in its joint frame");
  ASSERT_EQ(page.panels.size(), 12U);
  EXPECT_EQ(page.panels[1].y_label, "F_y [N]");
  EXPECT_EQ(page.panels[4].y_label, "difference of F_y [N]");
  EXPECT_EQ(page.panels[8].y_label, "T_z [N m]");
  EXPECT_EQ(page.panels[11].y_label, "difference of T_z [N m]");
  ASSERT_EQ(page.panels[0].curves.size(), 2U);
  EXPECT_EQ(page.panels[0].curves[0].label, "cartesian");
  EXPECT_EQ(page.panels[0].curves[1].label, "relative");
  EXPECT_NEAR(page.panels[3].curves[0].values(5), 1e-9 * std::sin(20.0 * 0.075), 1e-13);
  EXPECT_EQ(page.panels[4].curves[0].values.norm(), 0.0);
  EXPECT_EQ(page.x(200), 3.0);
}

TEST(ReactionPage, DoesNotBlowUpRoundOff) {
  const TwoRuns runs(0.0);
  const Page page = reaction_page(runs.model, 0, {"cartesian", "relative"}, runs.first, runs.second);
  EXPECT_NEAR(page.panels[2].least_reach, 1e-6 * 120.0, 1e-8);
  // Torques matter beside the force times a length of the machine, here 1 m.
  EXPECT_NEAR(page.panels[8].least_reach, 1e-6 * 120.0, 1e-8);
}

TEST(PlotReactions, DrawsAPageForEveryJoint) {
  const TwoRuns runs(1e-9);
  const TemporaryFolder folder;
  EXPECT_EQ(plot_reactions(folder.path(), runs.model, {"cartesian", "relative"}, runs.first, runs.second),
            std::nullopt);
  const std::string svg = bytes_of(folder.path() / "slider_crank.reaction_A.svg");
  EXPECT_THAT(svg, ::testing::HasSubstr("</svg>"));
  for (const char* text :
       {"F_x [N]", "difference of T_y [N m]", "cartesian", "relative", "t [s]", "(revolute) on crank"}) {
    EXPECT_THAT(svg, ::testing::HasSubstr(text));
  }
  EXPECT_THAT(bytes_of(folder.path() / "slider_crank.reaction_joint's B.svg"), ::testing::HasSubstr("joint's B"));
  EXPECT_EQ(folder.count(), 2);
}

TEST(PlotReactions, AreTheSameBytesFromRunToRun) {
  const TwoRuns runs(1e-9);
  const TemporaryFolder folder;
  ASSERT_EQ(plot_reactions(folder.path() / "1", runs.model, {"a", "b"}, runs.first, runs.second), std::nullopt);
  ASSERT_EQ(plot_reactions(folder.path() / "2", runs.model, {"a", "b"}, runs.first, runs.second), std::nullopt);
  const char* name = "slider_crank.reaction_A.svg";
  EXPECT_EQ(bytes_of(folder.path() / "1" / name), bytes_of(folder.path() / "2" / name));
}

TEST(DrawPage, SaysPlainlyThatGnuplotIsMissing) {
  const TwoRuns runs(0.0);
  const TemporaryFolder folder;
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nowhere", 1);
  const auto reason = plot_reactions(folder.path(), runs.model, {"a", "b"}, runs.first, runs.second);
  setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(reason, "no plots: gnuplot is not installed (Debian package gnuplot-nox)");
  EXPECT_EQ(folder.count(), 0);
}

TEST(DrawPage, SaysThatGnuplotFailed) {
  const TemporaryFolder folder;
  fs::create_directories(folder.path() / "bin");
  const fs::path fake = folder.path() / "bin" / "gnuplot";
  std::ofstream(fake) << "#!/bin/sh\nexit 3\n";
  fs::permissions(fake, fs::perms::owner_all);
  const std::string path = std::getenv("PATH");
  setenv("PATH", (fake.parent_path().string() + ":" + path).c_str(), 1);
  const TwoRuns runs(0.0);
  const auto reason =
      draw_page(folder.path() / "a.svg", reaction_page(runs.model, 0, {"a", "b"}, runs.first, runs.second));
  setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(reason, "no plot " + (folder.path() / "a.svg").string() + ": gnuplot failed");
}

}  // namespace
}  // namespace concord::compare
