#include "common/reading/magnitude.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <limits>

#include "common/reading/model_file.h"

namespace concord {
namespace {

using testing::HasSubstr;

TEST(Magnitude, IsUsableWhereProductsOfTwoAreNumbers) {
  for (const double size : {0.0, 1e-150, 2.0, 1e150}) {
    EXPECT_TRUE(has_usable_size(size)) << size;
    EXPECT_TRUE(has_usable_size(-size)) << size;
  }
  for (const double size : {0.99e-150, 5e-324, 1.01e150, std::numeric_limits<double>::infinity(),
                            std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_FALSE(has_usable_size(size)) << size;
    EXPECT_FALSE(has_usable_size(-size)) << size;
  }
}

TEST(Magnitude, OfLawsOfTimeCountsTwoDerivatives) {
  EXPECT_TRUE(stays_usable(Harmonic{.amplitude = 1e100, .frequency = 9e24}, 1.0));
  EXPECT_FALSE(stays_usable(Harmonic{.amplitude = 1e100, .frequency = 1.1e25}, 1.0));
  EXPECT_FALSE(stays_usable(Harmonic{.offset = 2e150, .amplitude = 1, .frequency = 1}, 1.0));
  EXPECT_TRUE(stays_usable(SmoothStep{.t0 = 0, .t1 = 1e-60, .from = 0, .to = 1e29}, 1.0));
  EXPECT_FALSE(stays_usable(SmoothStep{.t0 = 0, .t1 = 1e-60, .from = 0, .to = 1e30}, 1.0));
  EXPECT_TRUE(stays_usable(Polynomial{{1, 2, 3e149}}, 0.0));
  EXPECT_FALSE(stays_usable(Polynomial{{1, 2, 6e149}}, 0.0));
  EXPECT_TRUE(stays_usable(Polynomial{{0, 0, 0, 1e100}}, 1e16));
  EXPECT_FALSE(stays_usable(Polynomial{{0, 0, 0, 1e100}}, 1e17));
  EXPECT_FALSE(stays_usable(ConstantSpeed{.start = 0, .speed = 1e100}, 1e51));
  EXPECT_FALSE(stays_usable(SplineTable({0, 1e-80, 2e-80, 2}, {0, 1, 0, 1}), 1.0));
  EXPECT_TRUE(stays_usable(SplineTable({0, 1e-60, 1, 2}, {0, 1, 0, 1}), 1.0));
}

/// What is said of a rod on a hinge with one thing more.
std::string said_with(const std::string& body, const std::string& joint, const std::string& more) {
  const std::string text = fmt::format(R"(format = 1
gravity = [0, 0, -3]
[[body]]
name = "rod"
{}
[[joint]]
name = "hinge"
type = "revolute"
parent = {{ body = "ground", point = [0, 2e10, 0] }}
child = "rod"
{}
{})",
                                       body, joint, more);
  try {
    (void)parse_model(text, "m.toml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing";
}

TEST(Magnitude, OfProductsIsToldWhereTheirOwnerStands) {
  const std::string sound = "mass = 4\ninertia = [0.2, 0.3, 0.4]";
  EXPECT_EQ(said_with(sound, "", ""), "nothing");
  EXPECT_THAT(said_with("mass = 1e130\ninertia = [1, 1, 1]", "", ""),
              HasSubstr("m.toml:3:1: error: body 'rod': mass times the square of the machine's length is of the size "
                        "1e+151, beyond 1e+150"));
  EXPECT_THAT(said_with("mass = 1e-149\ncenter_of_mass = [1e-40, 0, 0]\ninertia = [0, 0, 0]", "", ""),
              Not(HasSubstr("below")));  // the hinge is far from the origin
  EXPECT_THAT(said_with(sound, "start.turn_z = { keep = 0, keep_speed = 1e70 }", ""),
              HasSubstr("body 'rod': mass times the square of the machine's speed is of the size 1e+161"));
  EXPECT_THAT(said_with(sound, "spring.turn_z = { stiffness = 1e100 }\nstart.turn_z = { keep = 1e30 }", ""),
              HasSubstr("m.toml:7:1: error: joint 'hinge': stiffness times the square of its stretch is of the size "
                        "1e+160"));
  EXPECT_THAT(said_with(sound, "", "[[load]]\nname = \"push\"\nbody = \"rod\"\nforce = [0, 1e145, 0]\n"),
              HasSubstr("m.toml:13:1: error: force element 'push': the force's moment is of the size 1e+155"));
  EXPECT_THAT(said_with(sound, "drive.turn_z = { law = \"polynomial\", coefficients = [0, 0, 1e60, 1e60] }",
                        "[run]\nuntil = 1e40\n"),
              HasSubstr("joint 'hinge': a driver's law, or one of its derivatives, is"));
}

TEST(Magnitude, OfSmallMachinesIsToldToo) {
  const std::string text = R"(format = 1
[[body]]
name = "mote"
mass = 1e-90
center_of_mass = [1e-35, 0, 0]
inertia = [0, 0, 0]
[[joint]]
name = "pin"
type = "spherical"
parent = "ground"
child = "mote"
)";
  try {
    (void)parse_model(text, "m.toml");
    FAIL() << "read";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "m.toml:2:1: error: body 'mote': mass times the square of the machine's length is of the size 1e-160, "
                 "below 1e-150: choose units in which it is nearer to one");
  }
}

}  // namespace
}  // namespace concord
