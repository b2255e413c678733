#include "common/start_words.h"

#include <gtest/gtest.h>

#include "common/reading/model_file.h"
#include "common/rotation.h"

namespace concord {
namespace {

JointGap gap(const Vec3& apart, const Vec3& turned) { return {apart, turned, rotation_about(Axis::x, EIGEN_PI / 2)}; }

TEST(StartWords, SayAGapInTheJointsAxesAndInTheWorld) {
  EXPECT_EQ(words_of(gap(Vec3(0.0, 0.0, 0.1), Vec3::Zero()), 1.0),
            "0.1 m along z of its frame on the parent (in the world along (0, -1, 0))");
  EXPECT_EQ(words_of(gap(Vec3(0.0, -0.02, 0.0), Vec3(3e-9, 0.0, 1e-9)), 1.0),
            "0.02 m along -y of its frame on the parent (in the world along (0, 0, -1))")
      << "round-off";
  EXPECT_EQ(words_of(gap(Vec3(0.0, 1e-14, 0.0), Vec3(0.25, 0.0, 0.0)), 1.0),
            "0.25 rad about x of its frame on the parent (in the world about (1, 0, 0))");
  EXPECT_EQ(words_of(gap(Vec3(0.03, 0.04, 0.0), Vec3(0.0, 0.0, -0.5)), 1.0),
            "0.05 m along (0.6, 0.8, 0) and 0.5 rad about -z of its frame on the parent (in the world along (0.6, 0, "
            "0.8) and about (0, 1, 0))");
}

/// What is small is a question of the machine's length, and of no unit.
TEST(StartWords, LeaveOutWhatIsRoundOffOfTheOtherPart) {
  const std::string words = words_of(gap(Vec3(1e-8, 0.0, 0.0), Vec3(0.0, 1e-2, 0.0)), 1e-6);
  EXPECT_EQ(words.find("1e-08 m along x and 0.01 rad about y"), 0U) << words;
  EXPECT_EQ(words_of(gap(Vec3(1e-8, 0.0, 0.0), Vec3(0.0, 1e-2, 0.0)), 10.0).find("0.01 rad about y"), 0U);
}

TEST(StartWords, NameCoordinatesJointByJoint) {
  const Model model = parse_model(R"(format = 1
[[body]]
name = "a"
mass = 1
inertia = [1, 1, 1]
[[body]]
name = "b"
mass = 1
inertia = [1, 1, 1]
[[joint]]
name = "U"
type = "universal"
parent = "ground"
child = "a"
[[joint]]
name = "C"
type = "cylindrical"
parent = "a"
child = "b"
drive.turn_z = { law = "constant_speed", speed = 1 }
)",
                                  "two.toml");
  const std::vector<StartWord> all = start_words(model);
  ASSERT_EQ(all.size(), 4U);
  EXPECT_EQ(names_of(model, {all[2], all[1], all[0]}), "turn_x and turn_y of joint 'U', slide_z of joint 'C'");
  EXPECT_EQ(names_of(model, {all[2]}), "slide_z of joint 'C'");
}

}  // namespace
}  // namespace concord
