#include "relative/start/start_search.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/reading/model_file.h"
#include "relative/solver.h"

namespace concord::relative {
namespace {

constexpr double kCrank = 0.4;
constexpr double kRod = 0.9;
constexpr double kCrankAngle = 1.1;

/// A crank of 0.4 m kept at 1.1 rad, a rod of 0.9 m and a slider on the crank's x axis; `slide` is said of its slide,
/// `drive` of the crank.
Model crank_and_slider(const std::string& slide, const std::string& crank) {
  return parse_model(fmt::format(R"toml(format = 1
gravity = [0.2, -9.81, 0.4]
[[body]]
name = "crank"
mass = 1.1
inertia = [0.01, 0.02, 0.025]
center_of_mass = [0.2, 0, 0]
[[body]]
name = "rod"
mass = 0.7
inertia = [0.01, 0.05, 0.055]
center_of_mass = [0.45, 0, 0]
[[body]]
name = "slider"
mass = 1.6
inertia = [0.01, 0.011, 0.012]
[[joint]]
name = "A"
type = "revolute"
parent = "ground"
child = "crank"
{}
[[joint]]
name = "B"
type = "revolute"
parent = {{ body = "crank", point = [0.4, 0, 0] }}
child = "rod"
[[joint]]
name = "C"
type = "revolute"
parent = {{ body = "rod", point = [0.9, 0, 0] }}
child = "slider"
[[joint]]
name = "D"
type = "translational"
parent = {{ body = "ground", x = [0, 1, 0], z = [1, 0, 0] }}
child = {{ body = "slider", x = [0, 1, 0], z = [1, 0, 0] }}
{}
[run]
until = 0.1
)toml",
                                 crank, slide),
                     "slider_crank.toml");
}

Model kept_at_angle(const std::string& slide) {
  return crank_and_slider(slide, fmt::format("start.turn_z = {{ keep = {}, keep_speed = 1.5 }}", kCrankAngle));
}

double place_of_slider(const State& state) { return state.q[3](0); }

std::string refusal_of_start(const Model& model) {
  try {
    (void)make_solver(model)->assemble();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no complaint";
}

/// From r cos a - sqrt(l^2 - r^2 sin^2 a) to r cos a + ...; rod and crank are in line where Newton's method begins.
TEST(StartSearch, FindsTheBranchThatTheGuessIsNearTo) {
  const double middle = kCrank * std::cos(kCrankAngle);
  const double half = std::sqrt(kRod * kRod - std::pow(kCrank * std::sin(kCrankAngle), 2));
  for (const double guess : {middle - half - 0.02, middle - half + 0.1, -0.3}) {
    const Model model = kept_at_angle(fmt::format("start.slide_z = {{ guess = {} }}", guess));
    const auto solver = make_solver(model);
    const State state = solver->assemble();
    EXPECT_NEAR(place_of_slider(state), middle - half, 1e-12) << guess;
    EXPECT_EQ(state.q[0](0), kCrankAngle) << guess;
    EXPECT_NO_THROW((void)solver->evaluate(state)) << guess;
    EXPECT_EQ(solver->has_searched_for_its_start(), guess > middle - half) << guess;
    if (!solver->has_searched_for_its_start()) continue;
    for (const int turned : {1, 2}) EXPECT_LE(std::abs(state.q[turned](0)), EIGEN_PI) << guess;
  }
}

TEST(StartSearch, LeavesAloneWhatTheGuessesClose) {
  const Model model = kept_at_angle("start.slide_z = { guess = 1.02 }");
  const auto solver = make_solver(model);
  EXPECT_GT(place_of_slider(solver->assemble()), 0.9);
  EXPECT_FALSE(solver->has_searched_for_its_start());
}

TEST(StartSearch, StillRefusesWhatContradictsItself) {
  const Model model =
      crank_and_slider("start.slide_z = { keep = 2.5, keep_speed = 0 }", "start.turn_z = { guess = 0.3 }");
  EXPECT_EQ(
      refusal_of_start(model),
      "slider_crank.toml:33:1: error: start: the kept joint coordinates (1 of joint 'D') contradict each other, or "
      "the guesses are too far off: the loops do not close with them; where the other joints are closed, joint 'C', "
      "at which the loop is cut, is left open by 1.2 m along x of its frame on the parent (in the world along (1, 0, "
      "0))");
}

/// A parallelogram written flat: four speeds, and closure rows of lower rank than anywhere else.
TEST(StartSearch, SaysThatADrivenMachineMayStartInASingularPose) {
  Model model = crank_and_slider("", "drive.turn_z = { law = \"constant_speed\", speed = 2.0, start = 0 }");
  model.joints[3].type = model.joints[2].type;
  model.joints[3].start = model.joints[2].start;
  model.joints[3].sides = model.joints[2].sides;
  model.joints[3].sides[0].body = kGround;
  model.joints[3].sides[0].point_L = Vec3(kRod, 0.0, 0.0);
  model.joints[3].sides[1].body = 3;
  model.joints[3].sides[1].point_L = Vec3(-kCrank, 0.0, 0.0);
  const std::string refusal = refusal_of_start(model);
  EXPECT_NE(refusal.find("a start in a singular pose, such as a linkage lying flat or stretched"), std::string::npos)
      << refusal;
}

}  // namespace
}  // namespace concord::relative
