#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cartesian/solver.h"
#include "common/reading/model_file.h"
#include "relative/solver.h"

/// What both solvers say, each by its own equations, of a start that they refuse.
namespace concord {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;

using Vec2 = Eigen::Vector2d;

std::string refusal(std::unique_ptr<Solver> solver) {
  try {
    (void)solver->assemble();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was refused";
}

std::array<std::string, 2> refusals(const std::string& text) {
  const Model model = parse_model(text, "four_bar.toml");
  return {refusal(cartesian::make_solver(model)), refusal(relative::make_solver(model))};
}

/// Three links on pins along (0.6, 0, 0.8), in the plane of (0.8, 0, -0.6) and y; `pin`: axes of D's frame on ground;
/// `beside`: how far D stands beside the plane; `start` of the first joint; `last` is said of D.
std::string four_bar(double beside, const std::string& pin, const std::string& start, const std::string& last = "") {
  std::string text = "format = 1\ngravity = [1, -9, 2]\n";
  for (const char* name : {"crank", "coupler", "rocker"}) {
    text += fmt::format(
        "[[body]]\nname = \"{}\"\nmass = 1.3\ncenter_of_mass = [0.4, 0.1, -0.2]\ninertia = [0.1, 0.12, 0.15]\n", name);
  }
  const auto joint = [&](const char* name, const char* parent, const char* child, double along, double off,
                         const std::string& on_parent, const std::string& more) {
    text += fmt::format(
        "[[joint]]\nname = \"{}\"\ntype = \"revolute\"\nparent = {{ body = \"{}\", point = [{}, 0, {}], {} }}\n"
        "child = {{ body = \"{}\", z = [0.6, 0, 0.8], x = [0, 1, 0] }}\n{}\n",
        name, parent, 0.8 * along + 0.6 * off, -0.6 * along + 0.8 * off, on_parent, child, more);
  };
  const std::string straight = "z = [0.6, 0, 0.8], x = [0, 1, 0]";
  joint("A", "ground", "crank", 0.0, 0.0, straight, start);
  joint("B", "crank", "coupler", 0.5, 0.0, straight, "start.turn_z = { guess = -0.9 }");
  joint("C", "coupler", "rocker", 1.1, 0.0, straight, "start.turn_z = { guess = 2.6 }");
  text += fmt::format(
      "[[joint]]\nname = \"D\"\ntype = \"revolute\"\nparent = {{ body = \"ground\", point = [{}, 0, {}], {} }}\n"
      "child = {{ body = \"rocker\", point = [0.64, 0, -0.48], z = [0.6, 0, 0.8], x = [0, 1, 0] }}\n{}\n",
      0.8 * 0.9 + 0.6 * beside, -0.6 * 0.9 + 0.8 * beside, pin.empty() ? straight : pin, last);
  return text;
}

std::string cut_at(const std::string& joint, std::string text) {
  const std::string name = "name = \"" + joint + "\"\n";
  return text.replace(text.find(name), name.size(), name + "cut = true\n");
}

const std::string kKept = "start.turn_z = { keep = 0.7, keep_speed = 1 }";

TEST(RefusedStarts, NameTheJointTheDirectionAndTheGapOfALoopThatCannotClose) {
  const auto [by_cartesian, by_relative] = refusals(four_bar(0.05, "", kKept));
  EXPECT_THAT(by_cartesian,
              HasSubstr("the guesses do not lead to a pose that closes, whatever is kept: joints A, B, C, D do not "
                        "close: where the others are closed, joint 'D' is left open by 0.05 m along -z of its frame on "
                        "the parent (in the world along (-0.6, 0, -0.8)), and other starts round about do no better; "
                        "correct the points and axes of these joints, or give better guesses"));
  // The relative solver cuts the loop at C, and sees the gap from the other side.
  EXPECT_THAT(by_relative,
              HasSubstr("cannot be closed near the start values, whatever is kept; where the other joints are closed, "
                        "joint 'C', at which the loop is cut, is left open by 0.05 m along z of its frame on the "
                        "parent (in the world along (0.6, 0, 0.8)): correct the points and axes of the loop's "
                        "joints, or give better guesses"));
}

/// The joint that the model names as cut is the place of the gap.
TEST(RefusedStarts, TakeTheCutJointOfTheModelAsThePlaceOfTheGap) {
  for (const std::string& said : refusals(cut_at("B", four_bar(0.05, "", kKept)))) {
    EXPECT_THAT(said, AllOf(HasSubstr("joint 'B'"), HasSubstr("is left open by 0.05 m along z of its frame")));
    EXPECT_THAT(said, HasSubstr("(in the world along (0.6, 0, 0.8))"));
  }
}

/// The pin of D is turned by 0.02 rad about the world's y, the x of its frame.
TEST(RefusedStarts, TellByHowMuchAxesAreOff) {
  const std::string pin = fmt::format("z = [{}, 0, {}], x = [0, 1, 0]", 0.6 * std::cos(0.02) + 0.8 * std::sin(0.02),
                                      0.8 * std::cos(0.02) - 0.6 * std::sin(0.02));
  for (const std::string& said : refusals(cut_at("D", four_bar(0.0, pin, kKept)))) {
    EXPECT_THAT(said, HasSubstr("0.02 rad about -x of its frame on the parent (in the world about (0, -1, 0))"));
  }
}

/// The rocker is kept so that crank and coupler, 1.6 m in one line, do not reach its end.
TEST(RefusedStarts, TellHowFarKeptValuesContradictEachOther) {
  const double gap = std::hypot(0.9 - 0.8 * std::cos(3.0), -0.8 * std::sin(3.0)) - 1.6;
  for (const std::string& said :
       refusals(four_bar(0.0, "", "start.turn_z = { guess = 0.3 }", "start.turn_z = { keep = 3.0, keep_speed = 0 }"))) {
    EXPECT_THAT(said, HasSubstr("contradict each other"));
    EXPECT_THAT(said, HasSubstr(fmt::format("is left open by {:.4g} m along", gap)));
  }
}

TEST(RefusedStarts, TellWhatIsFoundWhereTooMuchIsKept) {
  const Vec2 B(0.5 * std::cos(0.7), 0.5 * std::sin(0.7));
  const Vec2 way = Vec2(0.9, 0.0) - B;
  const double d = way.norm();
  const double along = (1.21 - 0.64 + d * d) / (2.0 * d);
  const Vec2 C = B + along / d * way + std::sqrt(1.21 - along * along) / d * Vec2(-way.y(), way.x());
  const double turn = std::atan2(-C.y(), 0.9 - C.x());
  const auto said_of = [&](double kept) {
    return refusals(four_bar(0.0, "", kKept, fmt::format("start.turn_z = {{ keep = {:.17g} }}", kept)));
  };
  for (const std::string& said : said_of(turn)) EXPECT_EQ(said, "nothing was refused");
  for (const std::string& said : said_of(turn + 1e-4)) {
    EXPECT_THAT(said, HasSubstr(fmt::format("with turn_z of joint 'A' as kept, turn_z of joint 'D' is {:.9g}, where "
                                            "{:.9g} is kept to {:.2g}",
                                            turn, turn + 1e-4, 1e-9 * std::max(1.0, std::abs(turn)))));
  }
}

TEST(RefusedStarts, NameWhatCouldBeKept) {
  const auto [by_cartesian, by_relative] = refusals(four_bar(0.0, "", "start.turn_z = { guess = 0.7 }"));
  EXPECT_THAT(by_cartesian, EndsWith("keep exactly 1 of each, for example turn_z of joint 'A'"));
  EXPECT_THAT(by_relative,
              HasSubstr("so 1 joint coordinates must be kept, for example turn_z of joint 'A', but 0 are"));
}

/// Two bodies on a universal joint and a cylindrical one: four speeds, of which one is stated.
TEST(RefusedStarts, NameTheJointsOfSeveralCoordinates) {
  const std::string text = R"(format = 1
[[body]]
name = "a"
mass = 2
inertia = [0.01, 0.02, 0.025]
[[body]]
name = "b"
mass = 2
inertia = [0.01, 0.02, 0.025]
[[joint]]
name = "U"
type = "universal"
parent = { body = "ground", x = [0, 1, 0], z = [0.6, 0, 0.8] }
child = "a"
[[joint]]
name = "S"
type = "cylindrical"
parent = { body = "a", point = [0.3, 0, 0] }
child = "b"
start.turn_z = { keep = 0.4, keep_speed = 1 }
)";
  for (const std::string& said : refusals(text)) {
    EXPECT_THAT(said, HasSubstr("for example turn_x and turn_y of joint 'U', slide_z and turn_z of joint 'S'"));
  }
}

}  // namespace
}  // namespace concord
