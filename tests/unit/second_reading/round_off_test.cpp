#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "common/reading/model_file.h"
#include "tests/second_reading/second_reading.h"
#include "tests/unit/temporary_folder.h"

/// What two readings may differ by is no misreading.
namespace concord::second_reading {
namespace {

using compare::TemporaryFolder;

constexpr const char* kBob = R"toml(
[[body]]
name = "bob"
mass = 2
inertia = [0.2, 0.3, 0.4]
[[joint]]
name = "A"
type = "revolute"
parent = { body = "ground" }
child = "bob"
)toml";

void expect_alike(const std::string& text) {
  const Model model = parse_model(text, "machine.toml");
  const SecondReading reading = read_again_text(model, text, "machine.toml");
  for (const StatedValue& one : reading.differing)
    ADD_FAILURE() << one.where << ", " << one.key << ": " << one.residual;
  for (const std::string& one : reading.not_held) ADD_FAILURE() << one;
}

TEST(RereadRoundOff, ANumberThatIsZeroButForTheRoundOffOfItsTermsIsRead) {
  expect_alike(std::string("format = 1\n[parameters]\nL = 0.3\nM = \"L - 0.1 - 0.2\"\n") + kBob +
               "[[load]]\nname = \"push\"\nbody = \"bob\"\npoint = [\"L - 0.1 - 0.2\", 0, \"M\"]\nforce = [1, 0, 0]\n");
  expect_alike(std::string("format = 1\n[parameters]\nm = 0.123\n") + kBob +
               "[[load]]\nname = \"push\"\nbody = \"bob\"\nforce = [\"m + 1e9 - 1e9\", 0, 0]\n");
}

TEST(RereadRoundOff, ABushingMatrixThatWasTurnedInFloatingPointIsRead) {
  expect_alike(std::string("format = 1\n") + kBob + R"toml(
[[bushing]]
name = "mount"
parent = "ground"
child = "bob"
stiffness = [
  [2e6, 5e5, 7e5, 0, 0, 0], [5e5, 2.3e6, 1.8e4, 0, 0, 0], [7e5, 1.8e4, 1.5e6, 0, 0, 0],
  [7.3e-12, -3.2e-12, -7.3e-12, 213, 59, 70], [-7.3e-12, 1.3e-11, 1.5e-11, 59, 230, 1.8], [0, 0, -7.3e-12, 70, 1.8, 156],
]
)toml");
}

TEST(RereadRoundOff, DampingRatiosOfModesWithoutFrequencyAreRead) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path());
  std::ofstream(folder.path() / "modes.toml") << R"toml(format = 1
modes = 2
stiffness = [[0, 0], [0, 9]]
damping_ratios = [0.01, 0.02]
[[mass_point]]
mass = 1
point = [1, 0, 0]
Psi_t = [[0, 0], [1, 0], [0, 1]]
[[mass_point]]
mass = 1
point = [-1, 0, 0.5]
Psi_t = [[0, 0], [1, 0], [0, 1]]
[[mass_point]]
mass = 1
point = [0, 1, 0]
Psi_t = [[0, 0], [-2, 0], [0, -2]]
[[node]]
name = "end"
point = [1, 0, 0]
Psi_t = [[0, 0], [1, 0], [0, 1]]
Psi_r = [[0, 0], [0, 0], [0, 0]]
)toml";
  const std::filesystem::path file = folder.path() / "machine.toml";
  std::ofstream(file) << R"toml(format = 1
[[body]]
name = "ringing"
modes_file = "modes.toml"
[[joint]]
name = "clamp"
type = "weld"
parent = "ground"
child = { body = "ringing", node = "end" }
)toml";
  Model model = read_model(file);
  EXPECT_TRUE(read_again(model, file).differing.empty());
  model.bodies.back().modal.value().damping *= 1.01;
  EXPECT_FALSE(read_again(model, file).differing.empty());  // the mode with a frequency is held all the same
}

TEST(RereadNames, OfOtherFilesAreThoseOfTheirKind) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path());
  const std::filesystem::path file = folder.path() / "machine.toml";
  std::ofstream(file) << "format = 1\n"
                      << kBob << R"toml(
[[load]]
name = "push"
body = "bob"
force = [1, 0, 0]
[[include]]
file = "arm.toml"
prefix = "left_"
)toml";
  std::ofstream(folder.path() / "arm.toml") << R"toml(format = 1
[[body]]
name = "arm"
mass = 2
inertia = [1, 1, 1]
[[joint]]
name = "hinge"
type = "revolute"
parent = "bob"
child = "arm"
start.turn_z = { keep = 0.1, keep_speed = 0 }
[[load]]
name = "A"
body = "arm"
force = [1, 0, 0]
[[coupling]]
name = "gear"
terms = [{ joint = "hinge", coordinate = "turn_z", factor = 1 }, { joint = "A", coordinate = "turn_z", factor = 2 }]
[[need]]
element = "push"
same_run = 3
because = "it is the including file's"
[[need]]
element = "A"
same_run = 3
because = "it is this file's"
)toml";
  const Model model = read_model(file);
  ASSERT_EQ(model.needs.size(), 2U);
  EXPECT_EQ(model.needs[0].element, "push");
  EXPECT_EQ(model.needs[1].element, "left_A");
  const SecondReading reading = read_again(model, file);
  for (const StatedValue& one : reading.differing) ADD_FAILURE() << one.where << ", " << one.key << ": " << one.text;
}

}  // namespace
}  // namespace concord::second_reading
