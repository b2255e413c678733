#include "common/growth_watch.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "common/error.h"
#include "common/joints/revolute.h"
#include "common/rotation.h"

namespace concord {
namespace {

/// A bent strip askew in its body, 2 m from end to end, whose second mode moves its last point by 0.5 m for each unit;
/// and a rigid body on it.
class GrowthWatchTest : public ::testing::Test {
 protected:
  GrowthWatchTest() {
    const Mat3 axes = rotation_about(Vec3(1.0, -2.0, 2.0) / 3.0, 0.7);
    const Vec3 first(0.3, -0.1, 0.2);
    ModalData modal;
    for (int k = 0; k < 3; ++k) {
      MassPoint point{0.4, first + axes * Vec3(k, 0.0, 0.0), Mat3X::Zero(3, 2)};
      point.Psi_t_L.col(0) = axes * Vec3(0.0, 0.0, 0.01 * k);
      point.Psi_t_L.col(1) = axes * Vec3(0.0, 0.25 * k, 0.0);
      modal.mass_points.push_back(point);
    }
    modal.stiffness = MatX::Identity(2, 2);
    Body strip;
    strip.name = "strip";
    strip.modal = modal;
    Body box;
    box.name = "box";
    model_.bodies = {Body{}, strip, box};
    start_ = at(0.0, 0.0);
  }

  [[nodiscard]] static State at(double t, double a) {
    State state;
    state.t = t;
    state.bodies.resize(3);
    state.bodies[1].r = Vec3(5.0, 6.0, -7.0);
    state.bodies[2].r = Vec3(-3.0, 0.0, 4.0);
    state.bodies[1].a = Vec2(0.1, a);
    return state;
  }

  /// The box at a distance from its start, in a direction of its own.
  [[nodiscard]] static State away(double t, double distance) {
    State state = at(t, 0.0);
    state.bodies[2].r += distance * Vec3(2.0, -1.0, 2.0) / 3.0;
    return state;
  }

  static std::string refusal(GrowthWatch& watch, const State& state) {
    try {
      watch.follow(state, "relative");
      return "";
    } catch (const SolverError& error) {
      return error.what();
    }
  }

  using Vec2 = Eigen::Vector2d;
  Model model_;
  State start_;
};

TEST_F(GrowthWatchTest, AModeThatDeflectsItsBodyByManySizesIsNamedWithSinceWhenAndHowMuch) {
  GrowthWatch watch(model_, start_);
  EXPECT_EQ(refusal(watch, at(0.1, -0.39)), "");  // 0.195 m of 2 m
  EXPECT_EQ(refusal(watch, at(0.2, 0.41)), "");   // more than a tenth
  EXPECT_EQ(refusal(watch, at(0.3, -2.0)), "");
  EXPECT_EQ(refusal(watch, at(0.4, 0.2)), "");
  EXPECT_EQ(refusal(watch, at(0.5, 3.0)), "");  // from here on
  EXPECT_EQ(refusal(watch, at(0.6, -39.9)), "");
  EXPECT_EQ(refusal(watch, at(0.7, 48.0)),
            "relative: at t = 0.7 s the motion of the model has grown without bound: mode a_2 deflects body 'strip' by "
            "12 times its size (2 m), and by more than a tenth of that since t = 0.5 s, where modes stand for small "
            "deflections: end the run before that, or see what should hold the body (no model has geometric "
            "stiffness)");
}

/// A small mass that one mode carries, on a machine of 40 m: its way is nothing beside that.
TEST_F(GrowthWatchTest, AModeThatMovesASmallBodyWithinItsMachineHasNotGrown) {
  Joint joint;
  joint.type = &joints::revolute;
  joint.sides[0].body = 2;
  joint.sides[1].body = 1;
  model_.joints.push_back(joint);
  joint.sides[0].point_L = Vec3(0.0, -24.0, 32.0);
  model_.joints.push_back(joint);
  GrowthWatch watch(model_, start_);
  EXPECT_EQ(refusal(watch, at(0.1, 790.0)), "");  // 395 m
  EXPECT_EQ(refusal(watch, at(0.2, 810.0)),
            "relative: at t = 0.2 s the motion of the model has grown without bound: mode a_2 deflects body 'strip' by "
            "10.1 times the machine's length (40 m), and by more than a tenth of that since t = 0.1 s, where modes "
            "stand for small deflections: end the run before that, or see what should hold the body (no model has "
            "geometric stiffness)");
}

TEST_F(GrowthWatchTest, SoIsABodyThatIsPushedTheHarderTheFartherItIs) {
  GrowthWatch watch(model_, start_);
  const double length = model_.length_scale();
  std::string said;
  for (int k = 0; k <= 10 && said.empty(); ++k) said = refusal(watch, away(k, length * std::pow(10.0, 1.5 * k)));
  EXPECT_EQ(said, fmt::format("relative: at t = 7 s the motion of the model has grown without bound: body 'box' stands "
                              "{:.3g} m from its start, 3.16e+10 lengths of the machine, after at most {:.3g} m until "
                              "t = 3 s: end the run before that, or see what pushes the body away",
                              length * std::pow(10.0, 10.5), length * std::pow(10.0, 4.5)));
}

TEST_F(GrowthWatchTest, FlightsOrbitsAndLateStartsHaveNotGrown) {
  GrowthWatch watch(model_, start_);
  for (int k = 0; k < 40; ++k) EXPECT_EQ(refusal(watch, away(k, 1e14 * k * k * k)), "");
  GrowthWatch orbit(model_, start_);
  for (int k = 0; k < 40; ++k) EXPECT_EQ(refusal(orbit, away(k, 1e14 * std::abs(std::sin(0.5 * M_PI * k)))), "");
  GrowthWatch late(model_, start_);
  for (int k = 0; k < 40; ++k) EXPECT_EQ(refusal(late, away(k, k < 30 ? 0.0 : 1e14 * (k - 29))), "");
  GrowthWatch one(model_, start_);
  EXPECT_EQ(refusal(one, away(1e9, 1e14)), "");
}

}  // namespace
}  // namespace concord
