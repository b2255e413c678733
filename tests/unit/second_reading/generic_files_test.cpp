#include <gmock/gmock.h>

#include "common/reading/model_file.h"
#include "tests/second_reading/second_reading.h"
#include "tests/unit/second_reading/stated_machine.h"
#include "tests/unit/temporary_folder.h"

namespace concord::second_reading {
namespace {

using compare::TemporaryFolder;

using ::testing::IsEmpty;

void expect_the_same(const SecondReading& found, const std::string& of) {
  for (const StatedValue& value : found.differing) {
    ADD_FAILURE() << of << ": " << value.where << ": " << value.key << " differs by " << value.residual << " of "
                  << value.scale << " " << value.text;
  }
  EXPECT_THAT(found.not_held, IsEmpty()) << of;
}

const std::string kBody = R"(
format = 1
[parameters]
x = 3
[[body]]
name = "b"
mass = 2
inertia = [1, 1, 1]
center_of_mass = [0, "NUMBER", 0]
[[joint]]
name = "j"
type = "free"
parent = { body = "ground", FRAME }
child = "b"
)";

void expect_the_same_of_text(const std::string& text, const std::string& of) {
  expect_the_same(read_again_text(parse_model(text, "text.toml"), text, "text.toml"), of);
}

TEST(SecondReadingOfText, HasEveryFrame) {
  for (const char* frame :
       {"x = [1, 2, 3], y = [-2, 1, 0]", "x = [1, 2, 3], z = [3, 0, -1]", "y = [0, 0, 2], z = [-4, 5, 0]",
        "x = [0, -1, 0], y = [1, 0, 0]", "axis = [1, -2, 3], angle = -4.5", "axis = [0, 0, 1e-9], angle = '400 deg'",
        "sequence = 'zxz', angles = [0.3, '-70 deg', 4]", "sequence = 'yxy', angles = [1, 2, 3]",
        "rotation_vector = [0, 0, 0]", "rotation_vector = [10, -20, 30]", "rotation_vector = [1e6, 2e6, 3e6]",
        "euler_parameters = [0, 0, 3, 4]", "euler_parameters = [-1e-3, 2e-3, 0, 1e-3]", "point = [1, 2, 3]",
        "x = [1, 0, 0], y = [5e-10, 1, 0]"}) {
    expect_the_same_of_text(with(with(kBody, "FRAME", frame), "NUMBER", "0"), frame);
  }
}

TEST(SecondReadingOfText, HasEveryExpression) {
  for (const char* number :
       {"1/2 deg", "2^2 deg", "2 deg^2", "20*deg", "20deg", "-1e3deg", "(1+2) deg", "x deg", "sin(0.5) deg", "-2^2",
        "2^3^2", "1/x deg", "sin(180 deg)", "cos(7*90 deg) - sin(29 deg)", "2--2", "min(1, x, 2) + max(4, 5 deg)",
        "atan2(1, -2) + ln(2) + exp(1) + abs(-1) + sqrt(x)", "asin(.1) + acos(.2) + atan(5) + tan(1) + pi"}) {
    expect_the_same_of_text(with(with(kBody, "FRAME", "x = [1, 0, 0], y = [0, 1, 0]"), "NUMBER", number), number);
  }
}

TEST(SecondReadingOfText, HasLongChainsOfParameters) {
  std::string chain = "x = 3\n";
  for (int k = 0; k < 20000; ++k) chain += "a" + std::to_string(k) + " = 'a" + std::to_string(k + 1) + "'\n";
  const std::string text = with(with(kBody, "FRAME", "point = [1, 2, 3]"), "x = 3\n", chain + "a20000 = 4\n");
  expect_the_same_of_text(with(text, "NUMBER", "a0"), "a chain");
}

TEST(SecondReadingOfText, TellsWhatItDoesNotKnow) {
  const std::string text = with(with(kBody, "FRAME", "point = [1, 2, 3]"), "NUMBER", "x");
  const Model model = parse_model(text, "text.toml");
  const auto not_held = [&](const std::string& passage, const std::string& other) {
    return read_again_text(model, with(text, passage, other), "text.toml").not_held;
  };
  EXPECT_THAT(not_held("mass = 2", "mass = 2\ncolour = 3"), ::testing::ElementsAre("body b: colour"));
  EXPECT_THAT(not_held("point =", "twist = 4, point ="), ::testing::ElementsAre("joint j: parent.twist"));
  EXPECT_THAT(not_held("format = 1", "format = 1\nsky = 4"), ::testing::ElementsAre("model: sky"));
  EXPECT_THAT(not_held("x = 3", "y = 3"), ::testing::Contains("body b: no parameter x"));
}

/// A part that includes a part: names and parameters of three files.
const std::string kInner = R"(
format = 1
gravity = [0, 0, -7]
[parameters]
size = "scale*own"
own = 2
[[body]]
name = "wheel"
mass = "size"
inertia = ["size", "load", "size"]
[[road]]
name = "road"
profile = "flat"
height = "own"
[[tire]]
name = "tire"
body = "wheel"
road = "road"
radius = "size"
stiffness = 1e5
slip_stiffness = 3e4
cornering_stiffness = 2e4
friction = 0.9
[[joint]]
name = "hub"
type = "revolute"
parent = "arm"
child = "wheel"
[[need]]
joint = "hub"
same_run = 9
[run]
until = 7
)";

const std::string kMiddle = R"(
format = 1
name = "a name of its own"
gravity = [0, 0, "-load"]
[parameters]
scale = "2*side"
own = 11
load = 1
[[include]]
file = "inner.toml"
prefix = "inner_"
parameters = { own = "own + side" }
[[body]]
name = "arm"
mass = "own"
inertia = [1, 1, "load"]
[[joint]]
name = "arm"
type = "revolute"
parent = "chassis"
child = "arm"
[[coupling]]
name = "tie"
terms = [{ joint = "arm", coordinate = "turn_z", factor = 1 }, { joint = "inner_hub", coordinate = "turn_z", factor = 2 }]
[[need]]
element = "inner_tire"
refined = 8
)";

const std::string kOuter = R"(
format = 1
[parameters]
width = 3
[[include]]
file = "parts/middle.toml"
prefix = "left_"
parameters = { side = "width", load = 1.5 }
[[include]]
file = "parts/middle.toml"
prefix = "right_"
parameters = { side = "width + 1" }
[[body]]
name = "chassis"
mass = "width"
inertia = [1, 1, 1]
[[joint]]
name = "chassis"
type = "free"
parent = "ground"
child = "chassis"
[[line_spring]]
name = "coil"
parent = "left_inner_wheel"
child = "right_arm"
damping = 3
[[need]]
body = "right_inner_wheel"
same_state = 10
)";

TEST(SecondReadingOfIncludes, HasPrefixesAndParametersOfEachFile) {
  const TemporaryFolder folder;
  write_file(folder.path() / "parts", "inner.toml", kInner);
  write_file(folder.path() / "parts", "middle.toml", kMiddle);
  const std::filesystem::path file = write_file(folder.path(), "outer.toml", kOuter);
  expect_the_same(read_again(read_model(file), file), "includes");
  const std::map<std::string, double> given{{"width", 5.0}};
  const Model wide = read_model(file, given);
  expect_the_same(read_again(wide, file, given), "includes with another width");
  // The mass of the chassis; of each side mass and inertia of a wheel, its radius and the height of its road.
  EXPECT_EQ(read_again(wide, file).differing.size(), 9U);
}

const std::string kFlexible = R"(
format = 1
[[body]]
name = "panel"
modes_file = "panel.toml"
[[joint]]
name = "j"
type = "revolute"
parent = "ground"
child = { body = "panel", node = "tip" }
)";

TEST(SecondReadingOfModesFiles, HasEveryWayToStateThem) {
  const TemporaryFolder folder;
  const std::filesystem::path file = write_file(folder.path(), "model.toml", kFlexible);
  const std::string ratios = "damping_ratios = [0.02, 0.05]";
  for (const auto& [passage, other] : std::vector<std::pair<std::string, std::string>>{
           {ratios, ratios},
           {ratios, ""},
           {ratios, "damping = [0.3, '1/7']"},
           {ratios, "damping = [[3, 1.5], [1.5, 2]]"},
           {ratios, "damping_ratios = [0, 0.05]"},
           {"stiffness = [[400, 30], [30, 900]]", "stiffness = [400, 900]"},
           {"stiffness = [[400, 30], [30, 900]]", "stiffness = [0, 900]"},
           {"stiffness = [[400, 30], [30, 900]]", "stiffness = [[4, 6], [6, 9]]"},
           {"stiffness = [[400, 30], [30, 900]]", "stiffness = [[400, 30], [30.00000000001, 900]]"}}) {
    write_file(folder.path(), "panel.toml", with(kStatedPanel, passage, other));
    expect_the_same(read_again(read_model(file), file), other);
  }
}

TEST(SecondReadingOfModesFiles, HasIntegralsAndSpoiledOnes) {
  const std::filesystem::path file = std::filesystem::path(CONCORD_DATA) / "text.toml";
  const std::string text = with(with(kFlexible, "panel.toml", "modes/coupler_integrals.toml"), "tip", "last");
  Model model = parse_model(text, file);
  expect_the_same(read_again_text(model, text, file), "integrals");
  const std::string points = with(text, "coupler_integrals", "coupler_points");
  expect_the_same(read_again_text(parse_model(points, file), points, file), "mass points");
  model.bodies[1].modal->G(1, 5) += 1e-9;
  const SecondReading found = read_again_text(model, text, file);
  ASSERT_EQ(found.differing.size(), 1U);
  EXPECT_EQ(found.differing[0].key, "inertia_integrals");
}

}  // namespace
}  // namespace concord::second_reading
