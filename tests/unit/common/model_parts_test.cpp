#include "common/reading/model_parts.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "common/reading/model_file.h"

namespace concord {
namespace {

namespace fs = std::filesystem;

/// A folder of files for one test.
class IncludedFiles : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / (std::string("concord_") + test->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "parts");
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }

  using Parameters = std::map<std::string, double>;

  [[nodiscard]] Model read(const std::string& name, const Parameters& parameters = {}) const {
    return read_model(folder_ / name, parameters);
  }

  /// What the reader says of the model, without the path of the folder.
  [[nodiscard]] std::string complaints(const std::string& name, const Parameters& parameters = {}) const {
    try {
      read_model(folder_ / name, parameters);
    } catch (const InputError& error) {
      std::string text = error.what();
      const std::string path = (folder_ / "").generic_string();
      for (auto at = text.find(path); at != std::string::npos; at = text.find(path)) text.erase(at, path.size());
      return text;
    }
    return "nothing";
  }

 private:
  fs::path folder_;
};

const std::string kCar = R"(format = 1
gravity = [0, 0, "-g"]

[parameters]
g = 9.81
track = 1.4

[[include]]
file = "parts/corner.toml"
prefix = "left_"
parameters = { side = 1, y = "track/2" }

[[include]]
file = "parts/corner.toml"
prefix = "right_"
parameters = { side = -1, y = "-track/2" }

[[body]]
name = "chassis"
mass = 1000
inertia = [200, 1000, 1100]

[[joint]]
name = "road"
type = "free"
parent = "ground"
child = "chassis"

[[need]]
joint = "left_hub"
same_run = 3
because = "tested"
)";

const std::string kCorner = R"(format = 1

[parameters]
mass = "2*base"
base = 10
side = 7

[[body]]
name = "wheel"
mass = "mass"
inertia = [1, 1.5, 1]
center_of_mass = [0, "side*0.01", 0]

[[body]]
name = "arm"
mass = 3
inertia = [0.1, 0.1, 0.1]

[[joint]]
name = "pivot"
type = "revolute"
parent = { body = "chassis", point = [0, "y - side*0.3", 0] }
child = "arm"

[[joint]]
name = "hub"
type = "revolute"
parent = "arm"
child = "wheel"

[[coupling]]
name = "belt"
terms = [{ joint = "pivot", coordinate = "turn_z", factor = 1 }, { joint = "hub", coordinate = "turn_z", factor = 2 }]

[[road]]
name = "track"
profile = "flat"

[[tire]]
name = "tire"
body = "wheel"
road = "track"
radius = 0.3
stiffness = 1e5
slip_stiffness = 1e4
cornering_stiffness = 1e4
friction = 1

[[need]]
joint = "pivot"
same_state = 9
)";

TEST_F(IncludedFiles, ComeOnceForEachIncludeUnderTheirPrefix) {
  write("car.toml", kCar);
  write("parts/corner.toml", kCorner);
  const Model model = read("car.toml");
  EXPECT_EQ(model.name, "car");
  EXPECT_EQ(model.gravity, Vec3(0.0, 0.0, -9.81));
  std::vector<std::string> bodies;
  for (const Body& body : model.bodies) bodies.push_back(body.name);
  EXPECT_EQ(bodies,
            (std::vector<std::string>{"ground", "chassis", "left_wheel", "left_arm", "right_wheel", "right_arm"}));
  std::vector<std::string> joints;
  for (const Joint& joint : model.joints) joints.push_back(joint.name);
  EXPECT_EQ(joints, (std::vector<std::string>{"road", "left_pivot", "left_hub", "right_pivot", "right_hub"}));
  EXPECT_TRUE(model.bodies[4].where.file.ends_with("parts/corner.toml"));
  EXPECT_EQ(model.bodies[4].where.line, 8);
}

TEST_F(IncludedFiles, ReferToTheirOwnAndElseToTheModel) {
  write("car.toml", kCar);
  write("parts/corner.toml", kCorner);
  const Model model = read("car.toml");
  const Joint& pivot = model.joints[3];
  EXPECT_EQ(pivot.on(Side::parent).body, 1) << "the chassis of the model";
  EXPECT_EQ(pivot.on(Side::child).body, 5) << "its own arm";
  ASSERT_EQ(model.couplings.size(), 2U);
  EXPECT_EQ(model.couplings[1].name, "right_belt");
  EXPECT_EQ(model.couplings[1].terms[0].joint, 3);
  EXPECT_EQ(model.couplings[1].terms[1].joint, 4);
  ASSERT_EQ(model.elements.size(), 2U);
  EXPECT_EQ(model.elements[1].name, "right_tire");
  const auto& tire = std::get<Tire>(model.elements[1].what);
  EXPECT_EQ(tire.wheel.body, 4);
  EXPECT_EQ(tire.road->name, "right_track");
  ASSERT_EQ(model.needs.size(), 3U);
  EXPECT_EQ(model.needs[0].joint, "left_hub");
  EXPECT_EQ(model.needs[1].joint, "left_pivot");
  EXPECT_EQ(model.needs[2].joint, "right_pivot");
}

TEST_F(IncludedFiles, TakeParametersFromTheIncludeBeforeTheirOwn) {
  write("car.toml", kCar);
  write("parts/corner.toml", kCorner);
  const Model model = read("car.toml");
  EXPECT_EQ(model.bodies[2].mass, 20.0) << "its own, where the include says nothing";
  EXPECT_EQ(model.bodies[2].center_of_mass_L.y(), 0.01);
  EXPECT_EQ(model.bodies[4].center_of_mass_L.y(), -0.01);
  EXPECT_DOUBLE_EQ(model.joints[1].on(Side::parent).point_L.y(), 0.4);
  EXPECT_DOUBLE_EQ(model.joints[3].on(Side::parent).point_L.y(), -0.4);
}

TEST_F(IncludedFiles, SeeParametersOfTheIncludingFileThatTheyDoNotDefine) {
  write("car.toml", kCar);
  std::string corner = kCorner;
  corner.replace(corner.find("base = 10\n"), 10, "base = \"track*10\"\ng = 5\n");
  corner.replace(corner.find("mass = 3"), 8, "mass = \"g\"");
  write("parts/corner.toml", corner);
  const Model model = read("car.toml");
  EXPECT_DOUBLE_EQ(model.bodies[2].mass, 28.0);
  EXPECT_EQ(model.bodies[3].mass, 5.0) << "its own comes first";
  EXPECT_EQ(model.gravity.z(), -9.81);
}

TEST_F(IncludedFiles, CanBeAWholeModelOfWhichAFewParametersChange) {
  write("car.toml", kCar + "[run]\nuntil = 7\n");
  write("parts/corner.toml", kCorner);
  write("moon.toml", "format = 1\n[[include]]\nfile = \"car.toml\"\nparameters = { g = 1.62 }\n");
  write("space.toml", "format = 1\ngravity = [0, 0, 0]\n[[include]]\nfile = \"car.toml\"\nprefix = \"a_\"\n");
  const Model moon = read("moon.toml");
  EXPECT_EQ(moon.name, "moon");
  EXPECT_EQ(moon.gravity, Vec3(0.0, 0.0, -1.62));
  EXPECT_EQ(moon.run.until, 7.0);
  EXPECT_EQ(moon.bodies.size(), 6U);
  EXPECT_EQ(moon.joints[3].name, "right_pivot");
  const Model space = read("space.toml");
  EXPECT_EQ(space.gravity, Vec3(Vec3::Zero())) << "what the model says itself comes first";
  EXPECT_EQ(space.bodies[5].name, "a_right_arm") << "prefixes of nested files add up";
  EXPECT_EQ(space.joints[3].on(Side::parent).body, 1);
  EXPECT_EQ(space.needs[0].joint, "a_left_hub");
}

TEST_F(IncludedFiles, AreFoundBesideTheFileThatIncludesThem) {
  write("m.toml", "format = 1\n[[include]]\nfile = \"parts/a.toml\"\n");
  write("parts/a.toml", "format = 1\n[[include]]\nfile = \"b.toml\"\n");
  write("parts/b.toml", R"(format = 1
[[body]]
name = "b"
mass = 1
inertia = [1, 1, 1]
[[joint]]
name = "j"
type = "free"
parent = "ground"
child = "b"
)");
  EXPECT_EQ(read("m.toml").bodies.back().name, "b");
}

TEST_F(IncludedFiles, TellWhereTheirFaultsAreAndFromWhereTheyWereIncluded) {
  write("car.toml", kCar);
  std::string corner = kCorner;
  corner.replace(corner.find("mass = 3"), 8, "mass = -3");
  corner.replace(corner.find("\"chassis\""), 9, "\"chasis\"");
  corner.replace(corner.find("body = \"wheel\""), 14, "body = \"whel\"");
  write("parts/corner.toml", corner);
  EXPECT_EQ(complaints("car.toml"),
            "parts/corner.toml:16:8: error: body 'arm': 'mass' must be positive, found -3\n"
            "  included from car.toml:8:1\n"
            "parts/corner.toml:22:19: error: joint 'pivot', parent: unknown body 'chasis': did you mean 'chassis'?\n"
            "  included from car.toml:8:1\n"
            "parts/corner.toml:41:8: error: tire 'tire': unknown body 'whel': did you mean 'wheel'?\n"
            "  included from car.toml:8:1");
}

TEST_F(IncludedFiles, TellTheWayThroughAllFiles) {
  write("m.toml", "format = 1\n\n[[include]]\nfile = \"parts/a.toml\"\n");
  write("parts/a.toml", "format = 1\n[[include]]\nfile = \"b.toml\"\n");
  write("parts/b.toml", "format = 2\n");
  EXPECT_EQ(complaints("m.toml"),
            "m.toml:1:1: error: there is no body: write at least one [[body]]\n"
            "parts/b.toml:1:10: error: 'format' must be 1, found 2\n"
            "  included from parts/a.toml:2:1\n"
            "  included from m.toml:3:1");
}

TEST_F(IncludedFiles, RefuseBrokenGrammarWithTheRestOfTheModel) {
  write("car.toml", kCar + "color = 1\n");
  write("parts/corner.toml", "format = 1\nmass 3\n");
  EXPECT_EQ(complaints("car.toml"),
            "car.toml:30:9: error: need: unknown joint 'left_hub': known joints: road\n"
            "car.toml:33:1: error: need: unknown key 'color': known keys: joint, element, body, component, same_state, "
            "same_run, "
            "refined, because\n"
            "parts/corner.toml:2:6: error: not TOML: Error while parsing key-value pair: expected '=', saw '3'\n"
            "  included from car.toml:8:1");
}

TEST_F(IncludedFiles, RefuseCircles) {
  write("car.toml", kCar);
  write("parts/corner.toml", kCorner + "[[include]]\nfile = \"../parts/../car.toml\"\n");
  EXPECT_EQ(
      complaints("car.toml"),
      "parts/corner.toml:53:8: error: include: goes round in a circle: car.toml -> parts/corner.toml -> car.toml\n"
      "  included from car.toml:8:1");
}

TEST_F(IncludedFiles, RefuseNamesThatAreTakenElsewhere) {
  std::string car = kCar;
  car.replace(car.find("prefix = \"right_\""), 17, "prefix = \"left_\"");
  write("car.toml", car);
  write("parts/corner.toml", kCorner);
  const std::string expected =
      "parts/corner.toml:8:1: error: body 'left_wheel': the file is included twice: give each [[include]] a prefix of "
      "its own\n"
      "  included from car.toml:13:1\n"
      "parts/corner.toml:14:1: error: body 'left_arm': the file is included twice: give each [[include]] a prefix of "
      "its own\n"
      "  included from car.toml:13:1\n";
  EXPECT_EQ(complaints("car.toml").substr(0, expected.size()), expected);
  write("car.toml", kCar + "[[body]]\nname = \"left_arm\"\nmass = 1\ninertia = [1, 1, 1]\n");
  EXPECT_EQ(complaints("car.toml"),
            "parts/corner.toml:14:1: error: body 'left_arm': car.toml:33 has the same name: choose another\n"
            "  included from car.toml:8:1");
}

TEST_F(IncludedFiles, MayNotHangOnNothing) {
  write("car.toml", kCar);
  std::string corner = kCorner;
  corner.replace(corner.find("parent = \"arm\""), 14, "parent = \"ground\"");
  corner.replace(corner.find("\"chassis\""), 9, "\"wheel\"");
  corner.replace(corner.find("child = \"wheel\""), 15, "child = \"chassis\"");
  write("parts/corner.toml", corner);
  EXPECT_EQ(complaints("car.toml"),
            "parts/corner.toml:8:1: error: no chain of joints connects to ground: left_wheel, left_arm, right_wheel, "
            "right_arm: add a joint, of type \"free\" if nothing holds it\n"
            "  included from car.toml:8:1");
}

TEST_F(IncludedFiles, TakeLargeWholeNumbersAsParameters) {
  std::string car = kCar;
  car.replace(car.find("track = 1.4"), 0, "large = 9246817297833421\n");
  write("car.toml", car);
  write("parts/corner.toml", kCorner);
  EXPECT_EQ(complaints("car.toml"), "nothing");
}

TEST_F(IncludedFiles, RefuseParametersAtFaultWhereTheyAreSaid) {
  std::string car = kCar;
  car.replace(car.find("\"track/2\""), 9, "\"trak/2\"");
  car.replace(car.find("side = -1"), 9, "deg = -1");
  write("car.toml", car);
  write("parts/corner.toml", kCorner);
  EXPECT_EQ(complaints("car.toml"),
            "car.toml:11:30: error: include, parameters: 'y': unknown name 'trak' in 'trak/2': did you mean 'track'?\n"
            "car.toml:16:22: error: parameter 'deg': the name already means something in expressions: choose another\n"
            "  included from car.toml:13:1");
}

/// Detects a misspelled parameter, which would leave another machine without a word.
TEST_F(IncludedFiles, RefuseParametersThatTheFileDoesNotKnow) {
  std::string car = kCar;
  car.replace(car.find("side = -1"), 9, "sid = -1");
  write("car.toml", car);
  write("parts/corner.toml", kCorner);
  const std::string complaint = complaints("car.toml");
  EXPECT_NE(complaint.find("error: include, parameters: unknown name 'sid': 'corner.toml' neither defines nor uses it; "
                           "did you mean 'side'?"),
            std::string::npos)
      << complaint;
}

/// Detects values from outside that reach only some of the files, and a name that changes with them.
TEST_F(IncludedFiles, TakeParametersFromOutside) {
  write("car.toml", kCar);
  write("parts/corner.toml", kCorner);
  const Model given = read("car.toml");
  const Model light = read("car.toml", {{"g", 1.62}, {"track", 2.0}});
  EXPECT_EQ(light.name, given.name);
  EXPECT_EQ(light.gravity, Vec3(0.0, 0.0, -1.62));
  EXPECT_NE(light.joints[1].on(Side::parent).point_L, given.joints[1].on(Side::parent).point_L)
      << "of an included file";
}

/// Detects values from outside that nothing reads.
TEST_F(IncludedFiles, RefuseParametersFromOutsideThatNothingDefines) {
  write("car.toml", kCar);
  write("parts/corner.toml", kCorner);
  EXPECT_EQ(complaints("car.toml", {{"trakc", 2.0}}),
            "car.toml: error: there is no parameter 'trakc': did you mean 'track'?");
  EXPECT_EQ(complaints("car.toml", {{"g", 1e200}}),
            "car.toml: error: parameter 'g' must be zero or of a size from 1e-150 to 1e+150, found 1e+200");
}

}  // namespace
}  // namespace concord
