#include "common/reading/model_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <stdexcept>

#include "broken_models.h"
#include "common/rotation.h"

namespace concord {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

const Joint& joint(const Model& model, const std::string& name) {
  for (const Joint& one : model.joints) {
    if (one.name == name) return one;
  }
  throw std::out_of_range(name);
}

/// A machine of one body, the child's frame of its joint said by `frame`.
Mat3 frame_from(const std::string& frame) {
  const std::string text = R"(format = 1
[[body]]
name = "b"
mass = 1
inertia = [1, 1, 1]
[[joint]]
name = "j"
type = "free"
parent = "ground"
child = { body = "b", )" + frame +
                           " }\n";
  return parse_model(text, "m.toml").joints.front().on(Side::child).C;
}

TEST(ModelFile, ReadsRigidBodies) {
  const Model model = parse_model(R"(format = 1
gravity = [1, "2*g", -3]
name = "machine"
[parameters]
g = 4
[[body]]
name = "b"
mass = 2.5
center_of_mass = [0.1, -0.2, 0.3]
inertia = [11, 12, 13, 0.1, 0.2, "0.1*3"]
start.pose = { origin = [1, 2, 3], axis = [0, 0, 2], angle = "90 deg" }
[[joint]]
name = "j"
type = "free"
parent = "ground"
child = "b"
)",
                                  "folder/m.toml");
  EXPECT_EQ(model.name, "machine");
  EXPECT_EQ(model.file, "folder/m.toml");
  EXPECT_EQ(model.gravity, Vec3(1.0, 8.0, -3.0));
  ASSERT_EQ(model.bodies.size(), 2U);
  EXPECT_EQ(model.bodies[kGround].name, "ground");
  const Body& body = model.bodies[1];
  EXPECT_EQ(body.mass, 2.5);
  EXPECT_EQ(body.center_of_mass_L, Vec3(0.1, -0.2, 0.3));
  Mat3 inertia;
  inertia << 11.0, 0.1, 0.2, 0.1, 12.0, 0.1 * 3, 0.2, 0.1 * 3, 13.0;
  EXPECT_EQ(body.inertia_L, inertia);
  ASSERT_TRUE(body.pose_guess.has_value());
  EXPECT_EQ(body.pose_guess->r, Vec3(1.0, 2.0, 3.0));
  EXPECT_LT((body.pose_guess->A - rotation_about(Axis::z, 90.0 * kRadiansPerDegree)).norm(), 1e-15);
  EXPECT_EQ(body.where.line, 6);
}

TEST(ModelFile, EveryWayToSayAFrameMeansTheSame) {
  Mat3 C;
  C << 6.0, 2.0, 3.0, 2.0, 3.0, -6.0, -3.0, 6.0, 2.0;  // columns x, y, z of the frame
  C /= 7.0;
  const Mat3 tolerance = Mat3::Constant(1e-15);
  const auto expect_C = [&](const std::string& frame) {
    EXPECT_TRUE(((frame_from(frame) - C).cwiseAbs().array() <= tolerance.array()).all()) << frame;
  };
  expect_C("x = [6, 2, -3], z = [3, -6, 2]");
  expect_C("x = [12, 4, -6], y = [2, 3, 6]");
  expect_C("y = [2, 3, 6], z = [0.3, -0.6, 0.2]");
  const Eigen::AngleAxisd turn(C);
  const Eigen::Quaterniond p(C);
  const auto list = [](const auto& v) {
    std::string text = "[";
    for (const double x : v) text += fmt::format("{}{}", text.size() > 1 ? ", " : "", x);
    return text + "]";
  };
  expect_C(fmt::format("axis = {}, angle = {}", list(Vec3(2.0 * turn.axis())), turn.angle()));
  expect_C(fmt::format("rotation_vector = {}", list(Vec3(turn.angle() * turn.axis()))));
  expect_C(fmt::format("euler_parameters = {}", list(Vec4(3.0 * Vec4(p.w(), p.x(), p.y(), p.z())))));
  // Intrinsic z-y-x angles of C by hand.
  const double yaw = std::atan2(C(1, 0), C(0, 0));
  const double pitch = -std::asin(C(2, 0));
  const double roll = std::atan2(C(2, 1), C(2, 2));
  expect_C(fmt::format("sequence = \"zyx\", angles = [{}, {}, {}]", yaw, pitch, roll));
  EXPECT_EQ(frame_from("point = [1, 2, 3]"), Mat3(Mat3::Identity()));
  EXPECT_EQ(frame_from("rotation_vector = [0, 0, 0]"), Mat3(Mat3::Identity()));
}

TEST(ModelFile, AxesALittleOffSquareAreSquaredAndTold) {
  const auto with_x = [](const std::string& x) {
    std::string text(kSoundModel);
    const std::string own = "x = [0, 1, 0], z = [1, 0, 0]";
    text.replace(text.find(own), own.size(), "x = [" + x + ", 1, 0], z = [1, 0, 0]");
    return parse_model(text, "m.toml");
  };
  const Model squared = with_x("-9e-7");
  EXPECT_THAT(squared.notes, testing::ElementsAre("m.toml:31:52: joint 'A', parent: axes x and z are 9e-07 rad off "
                                                  "square: x is turned to be perpendicular"));
  EXPECT_EQ(squared.joints[0].on(Side::parent).C, with_x("0").joints[0].on(Side::parent).C);
  EXPECT_THAT(with_x("0").notes, testing::IsEmpty());
  EXPECT_THAT(with_x("1e-14").notes, testing::IsEmpty());  // round-off of expressions
  EXPECT_THROW(with_x("1.1e-6"), InputError);
}

/// Half a unit of the last written digit; of what is no decimal fraction 1e-9.
TEST(ModelFile, StartsKnowHowManyOfTheirDigitsAreWritten) {
  const auto slack = [](const std::string& written) {
    std::string text(kSoundModel);
    const std::string own = "start.turn_z = { keep = \"30 deg\", keep_speed = 2 }";
    text.replace(text.find(own), own.size(), "# äö\nstart.turn_z = { keep = " + written + ", keep_speed = 1.50 } # äö");
    const Model model = parse_model(text, "m.toml");
    EXPECT_DOUBLE_EQ(model.joints[0].start[0].slack_u(0), 0.005);
    return model.joints[0].start[0].slack_q(0);
  };
  EXPECT_DOUBLE_EQ(slack("0.158"), 0.0005);
  EXPECT_DOUBLE_EQ(slack("-1.500"), 0.0005);
  EXPECT_DOUBLE_EQ(slack("1.5e-2"), 0.0005);
  EXPECT_DOUBLE_EQ(slack("\"26.2 deg\""), 0.05 * kRadiansPerDegree);
  EXPECT_DOUBLE_EQ(slack("\"0.25\""), 0.005);
  EXPECT_DOUBLE_EQ(slack("2"), 1e-9);
  EXPECT_DOUBLE_EQ(slack("\"26 deg\""), 1e-9);
  EXPECT_DOUBLE_EQ(slack("\"0.5 * pi\""), 1e-9);
  EXPECT_DOUBLE_EQ(slack("\"sqrt(0.25)\""), 1e-9);
}

TEST(ModelFile, BothSaysTheSameOnEitherSide) {
  const Model model = parse_model(R"(format = 1
[[body]]
name = "b"
mass = 1
inertia = [1, 1, 1]
[[joint]]
name = "j"
type = "weld"
both = { point = [1, 2, 3], x = [0, 1, 0], z = [1, 0, 0] }
parent = "ground"
child = "b"
)",
                                  "m.toml");
  for (const Attachment& side : model.joints.front().sides) {
    EXPECT_EQ(side.point_L, Vec3(1.0, 2.0, 3.0));
    EXPECT_EQ(side.C.col(0), Vec3(Vec3::UnitY()));
    EXPECT_EQ(side.C.col(2), Vec3(Vec3::UnitX()));
  }
}

TEST(ModelFile, ReadsStartAndDriversByTheWordsOfTheMotion) {
  const Model model = parse_model(R"(format = 1
[[body]]
name = "b"
mass = 1
inertia = [1, 1, 1]
[[joint]]
name = "j"
type = "free"
parent = "ground"
child = "b"
cut = true
drive.slide_y = { law = "harmonic", amplitude = 2, frequency = 3, phase = "30 deg", offset = 1 }
[joint.start]
slide_x = { keep = 0.5, guess_speed = 4 }
ball = { guess = { axis = [0, 1, 0], angle = "60 deg" }, keep_speed = [1, 2, 3] }
)",
                                  "m.toml");
  const Joint& j = model.joints.front();
  EXPECT_TRUE(j.named_as_cut);
  ASSERT_EQ(j.start.size(), 4U);
  EXPECT_EQ(j.start[0].role_q, StartRole::keep);
  EXPECT_EQ(j.start[0].q(0), 0.5);
  EXPECT_EQ(j.start[0].role_u, StartRole::guess);
  EXPECT_EQ(j.start[0].u(0), 4.0);
  EXPECT_EQ(j.start[2].role_q, StartRole::unsaid);
  EXPECT_EQ(j.start[2].q, VecX(VecX::Zero(1)));
  EXPECT_EQ(j.start[3].role_q, StartRole::guess);
  EXPECT_LT((j.start[3].q - Vec4(std::sqrt(0.75), 0.0, 0.5, 0.0)).norm(), 1e-15);
  EXPECT_EQ(j.start[3].u, VecX(Vec3(1.0, 2.0, 3.0)));
  ASSERT_EQ(j.drivers.size(), 1U);
  EXPECT_EQ(j.drivers.front().word, 1);
  EXPECT_NEAR(evaluate(j.drivers.front().law, 0.0).f, 2.0, 1e-15);
  EXPECT_NEAR(evaluate(j.drivers.front().law, 0.0).fdot, 6.0 * std::cos(30.0 * kRadiansPerDegree), 1e-14);
}

TEST(ModelFile, ABallThatSaysNothingHasNoRotation) {
  const Model model = parse_model(kSoundModel, "m.toml");
  EXPECT_EQ(joint(model, "B").start.front().q, VecX(Vec4::UnitX()));
}

TimeFunction law_from(const std::string& law) {
  std::string text = kSoundModel;
  const std::string old = R"({ law = "constant_speed", speed = 1 })";
  text.replace(text.find(old), old.size(), law);
  return joint(parse_model(text, "m.toml"), "D").drivers.front().law;
}

TEST(ModelFile, ReadsEveryLawOfTime) {
  EXPECT_EQ(evaluate(law_from(R"({ law = "constant_speed", start = 2, speed = -3 })"), 0.5).f, 0.5);
  EXPECT_EQ(evaluate(law_from(R"({ law = "polynomial", coefficients = [1, 2, "3"] })"), 2.0).f, 17.0);
  EXPECT_EQ(evaluate(law_from(R"({ law = "smooth_step", t0 = 1, t1 = 2, from = 3, to = 4 })"), 1.5).f, 3.5);
  EXPECT_NEAR(evaluate(law_from(R"({ law = "spline", times = [0, 1, 2, 4], values = [0, 1, 8, 64] })"), 3.0).f, 27.0,
              1e-13);
}

/// The sound model with force elements before its [run].
Model with_forces(const std::string& forces) {
  std::string text = kSoundModel;
  text.replace(text.find("[run]"), 5, forces + "\n[run]");
  return parse_model(text, "m.toml");
}

TEST(ModelFile, ReadsLoadsOnRigidAndFlexibleBodies) {
  const Model model = with_forces(R"(
[[load]]
name = "push"
body = "rod"
node = "last"
offset = [0.01, 0.02, 0.03]
axis = [0, 0, 1]
angle = 0.5
axes = "follower"
force = [1, "L", 3]
law = { law = "harmonic", amplitude = 2, frequency = 3 }
[[load]]
name = "twist"
body = "crank"
axes = "body"
torque = [4, 5, 6]
law = "half*2"
[[load]]
name = "weight"
body = "crank"
point = [0.1, 0, 0]
force = [7, 8, 9]
)");
  ASSERT_EQ(model.elements.size(), 3U);
  const auto& push = std::get<Load>(model.elements[0].what);
  EXPECT_EQ(model.elements[0].name, "push");
  EXPECT_GT(model.elements[0].where.line, 1);
  EXPECT_EQ(push.axes, LoadAxes::follower);
  EXPECT_EQ(push.force, Vec3(1.0, 0.3, 3.0));
  EXPECT_EQ(push.torque, Vec3(Vec3::Zero()));
  EXPECT_NEAR(evaluate(push.law, 0.4).f, 2.0 * std::sin(1.2), 1e-15);
  EXPECT_EQ(push.at.body, 2);
  EXPECT_EQ(push.at.Psi_t_L.cols(), 2);
  EXPECT_EQ(push.at.point_L, Vec3(model.bodies[2].modal->nodes.back().s0_L + Vec3(0.01, 0.02, 0.03)));
  EXPECT_LT((push.at.C - rotation_about(Axis::z, 0.5)).norm(), 1e-15);
  const auto& twist = std::get<Load>(model.elements[1].what);
  EXPECT_EQ(twist.axes, LoadAxes::body);
  EXPECT_EQ(twist.torque, Vec3(4.0, 5.0, 6.0));
  EXPECT_EQ(evaluate(twist.law, 9.0).f, 0.3) << "a number means constant";
  const auto& weight = std::get<Load>(model.elements[2].what);
  EXPECT_EQ(weight.axes, LoadAxes::global);
  EXPECT_EQ(weight.at.point_L, Vec3(0.1, 0.0, 0.0));
  EXPECT_EQ(evaluate(weight.law, 9.0).f, 1.0) << "nothing means always";
}

TEST(ModelFile, ReadsSpringsWithTablesStopsAndActuators) {
  const Model model = with_forces(R"(
[[turn_spring]]
name = "helix"
both = { axis = [1, 0, 0], angle = 0.25 }
parent = "ground"
child = { body = "crank", point = [0.1, 0, 0] }
stiffness = 3
free = "90 deg"
actuator = { law = "polynomial", coefficients = [1, 2] }
[[line_spring]]
name = "coil"
parent = { body = "ground", point = [0, 1, 0] }
child = { body = "rod", node = "2" }
stiffness = "100*L"
damping = 5
free = 0.7
preload = -2
spring_table = { x = [-1, 0, 1, 2], force = [-1, 0, 1, 8] }
damper_table = { x = [-1, 0, 1, 3], force = [-2, 0, 1, 2] }
lower_stop = { at = 0.5, stiffness = 1e4, width = 0.01 }
upper_stop = { at = 0.9, stiffness = 2e4, damping = 30, width = 0.02 }
)");
  ASSERT_EQ(model.elements.size(), 2U) << "in the order of the file";
  const auto& helix = std::get<TurnSpring>(model.elements[0].what);
  EXPECT_EQ(helix.law.stiffness, 3.0);
  EXPECT_NEAR(helix.law.free, 90.0 * kRadiansPerDegree, 1e-15);
  EXPECT_EQ(evaluate_actuator(helix.law, 3.0), 7.0);
  for (const Attachment& end : helix.ends) EXPECT_LT((end.C - rotation_about(Axis::x, 0.25)).norm(), 1e-15);
  EXPECT_EQ(helix.ends[1].body, 1);
  EXPECT_EQ(helix.ends[1].point_L, Vec3(0.1, 0.0, 0.0));
  const auto& coil = std::get<LineSpring>(model.elements[1].what);
  EXPECT_EQ(coil.ends[0].body, kGround);
  EXPECT_EQ(coil.ends[1].Psi_t_L.cols(), 2);
  EXPECT_NEAR(coil.law.stiffness, 30.0, 1e-14);
  EXPECT_EQ(coil.law.damping, 5.0);
  EXPECT_EQ(coil.law.free, 0.7);
  EXPECT_EQ(coil.law.preload, -2.0);
  EXPECT_NEAR(coil.law.spring_table->evaluate(2.0), 8.0, 1e-14);
  EXPECT_NEAR(coil.law.damper_table->evaluate(3.0), 2.0, 1e-14);
  EXPECT_EQ(coil.law.lower->at, 0.5);
  EXPECT_EQ(coil.law.lower->damping, 0.0);
  EXPECT_EQ(coil.law.upper->damping, 30.0);
  EXPECT_EQ(coil.law.upper->width, 0.02);
  EXPECT_FALSE(coil.law.actuator.has_value());
}

TEST(ModelFile, ReadsBushingsByDiagonalAndByRows) {
  const Model model = with_forces(R"(
[[bushing]]
name = "mount"
parent = "ground"
child = "crank"
stiffness = [[1, 7, 0, 0, 0, 0], [7, 2, 0, 0, 0, 0], [0, 0, 3, 0, 0, 8], [0, 0, 0, 4, 0, 0], [0, 0, 0, 0, 5, 0], [0, 0, 8, 0, 0, 6]]
damping = [1, 2, 3, 4, 5, 6]
preload = [6, 5, 4, 3, 2, 1]
)");
  const auto& mount = std::get<Bushing>(model.elements.front().what);
  EXPECT_EQ(mount.stiffness(0, 1), 7.0);
  EXPECT_EQ(mount.stiffness(5, 2), 8.0);
  EXPECT_EQ(mount.stiffness.trace(), 21.0);
  EXPECT_EQ(mount.damping.diagonal(), mount.stiffness.diagonal());
  EXPECT_EQ(mount.damping.sum(), 21.0);
  EXPECT_EQ(mount.preload(0), 6.0);
}

TEST(ModelFile, ReadsTiresOnRoadsOfEveryProfile) {
  const Model model = with_forces(R"(
[[tire]]
name = "front"
body = "crank"
point = [0.1, 0.2, 0.3]
axis = [1, 0, 0]
angle = 0.25
road = "bump"
radius = "L"
stiffness = 2e5
damping = 300
slip_stiffness = 5e4
cornering_stiffness = 4e4
friction = 0.9
speed_scale = 0.2
[[tire]]
name = "rear"
body = "rod"
node = "last"
road = "level"
radius = 0.2
stiffness = 1e5
slip_stiffness = 0
cornering_stiffness = 0
friction = 0
[[road]]
name = "bump"
profile = "half_sine"
start = "10*L"
length = 0.5
height = 0.02
[[road]]
name = "level"
profile = "flat"
height = -0.1
[[road]]
name = "front"  # roads have names of their own
profile = "table"
x = [0, 1, 2, 3]
height = [0, 0.1, 0.1, 0]
)");
  ASSERT_EQ(model.elements.size(), 2U);
  const auto& front = std::get<Tire>(model.elements[0].what);
  EXPECT_EQ(front.wheel.body, 1);
  EXPECT_EQ(front.wheel.point_L, Vec3(0.1, 0.2, 0.3));
  EXPECT_LT((front.wheel.C - rotation_about(Axis::x, 0.25)).norm(), 1e-15);
  EXPECT_EQ(front.radius, 0.3);
  EXPECT_EQ(front.stiffness, 2e5);
  EXPECT_EQ(front.damping, 300.0);
  EXPECT_EQ(front.slip_stiffness, 5e4);
  EXPECT_EQ(front.cornering_stiffness, 4e4);
  EXPECT_EQ(front.friction, 0.9);
  EXPECT_EQ(front.speed_scale, 0.2);
  const auto& bump = std::get<HalfSineBump>(front.road->profile);
  EXPECT_DOUBLE_EQ(bump.start, 3.0);
  EXPECT_EQ(bump.length, 0.5);
  EXPECT_EQ(bump.height, 0.02);
  const auto& rear = std::get<Tire>(model.elements[1].what);
  EXPECT_EQ(rear.wheel.Psi_t_L.cols(), 2);
  EXPECT_EQ(rear.damping, 0.0);
  EXPECT_EQ(rear.speed_scale, 0.1);
  EXPECT_EQ(std::get<FlatRoad>(rear.road->profile).height, -0.1);
}

TEST(ModelFile, ReadsARoadFromATable) {
  const Model model = with_forces(R"(
[[road]]
name = "hill"
profile = "table"
x = [0, 1, 2, "10*L"]
height = [0, 0.1, 0.2, 0.3]
[[tire]]
name = "wheel"
body = "crank"
road = "hill"
radius = 0.2
stiffness = 1e5
slip_stiffness = 1
cornering_stiffness = 1
friction = 1
)");
  const Road& hill = *std::get<Tire>(model.elements.front().what).road;
  EXPECT_EQ(hill.name, "hill");
  EXPECT_EQ(edges_of(hill, 1)[0], 0.0);
  EXPECT_EQ(edges_of(hill, 3)[1], 3.0);
  EXPECT_NEAR(evaluate(hill, 2, 1.5).h, 0.15, 1e-15);
}

TEST(ModelFile, ReadsCouplingsOfTurnsAndSlides) {
  const Model model = with_forces(R"(
[[coupling]]
name = "rack"
offset = "half"
terms = [{ joint = "D", coordinate = "slide_z", factor = 1 }, { joint = "D", coordinate = "turn_z", factor = 4 },
         { joint = "A", coordinate = "turn_z", factor = "-L" }]
)");
  ASSERT_EQ(model.couplings.size(), 1U);
  const Coupling& rack = model.couplings.front();
  EXPECT_EQ(rack.name, "rack");
  EXPECT_EQ(rack.offset, 0.15);
  EXPECT_GT(rack.where.line, 1);
  ASSERT_EQ(rack.terms.size(), 3U);
  EXPECT_EQ(rack.terms[0].joint, 2);
  EXPECT_EQ(rack.terms[0].word, 0);
  EXPECT_EQ(rack.terms[1].word, 1);
  EXPECT_EQ(rack.terms[1].factor, 4.0);
  EXPECT_EQ(rack.terms[2].joint, 0);
  EXPECT_EQ(rack.terms[2].component, 0);
  EXPECT_EQ(rack.terms[2].factor, -0.3);
}

TEST(ModelFile, ReadsJointSpringsByTheWordsOfTheMotion) {
  std::string text = kSoundModel;
  text += "spring.turn_z = { stiffness = 4, damping = 0.5, free = \"20 deg\", actuator = 3 }\n";
  const Model model = parse_model(text, "m.toml");
  const Joint& slide = joint(model, "D");
  ASSERT_EQ(slide.springs.size(), 1U);
  EXPECT_EQ(slide.springs.front().word, 1);
  EXPECT_EQ(slide.springs.front().component, 0);
  EXPECT_EQ(slide.springs.front().law.stiffness, 4.0);
  EXPECT_EQ(evaluate_actuator(slide.springs.front().law, 2.0), 3.0);
}

TEST(ModelFile, GivesLinksTheirOwnLengthAndNoNameForTheirArm) {
  std::string text = kSoundModel;
  const std::string old = "type = \"spherical\"";
  text.replace(text.find(old), old.size(), R"(type = "distance"
length = "2*L"
start = { turn_x = { guess = 0.3 }, turn_y = { keep = -0.2 }, ball = { keep_speed = [1, 2, 3] } }
spring.turn_y = { damping = 2 })");
  const Model model = parse_model(text, "m.toml");
  const Joint& rod = joint(model, "B");
  ASSERT_EQ(rod.type, rod.own_type.get());
  EXPECT_EQ(rod.type->name, "distance");
  EXPECT_EQ(std::get<joints::KeepDistance>(rod.type->forbids[0]).length, 0.6);
  EXPECT_EQ(std::get<joints::Arm>(rod.type->permits[2]).length, 0.6);
  ASSERT_EQ(rod.start.size(), 4U);
  EXPECT_EQ(rod.start[0].q(0), 0.3);
  EXPECT_EQ(rod.start[1].role_q, StartRole::keep);
  EXPECT_EQ(rod.start[2].q.size(), 0);
  EXPECT_EQ(rod.start[3].u(2), 3.0);
  EXPECT_EQ(rod.springs.front().word, 1);
  EXPECT_EQ(joint(model, "A").own_type, nullptr);
}

TEST(ModelFile, PutsJointsOnNodesWithTheirModeRows) {
  std::string text = kSoundModel;
  const std::string old = R"(node = "last")";
  text.replace(text.find(old), old.size(),
               R"(node = "last", offset = [0.02, -0.01, 0.03], axis = [1, 0, 0], angle = 1)");
  const Model model = parse_model(text, "m.toml");
  const ModalData& rod = *model.bodies[2].modal;
  const ModalNode& node = rod.nodes.back();
  ASSERT_EQ(node.name, "last");
  const Attachment& side = joint(model, "D").on(Side::child);
  const Vec3 offset(0.02, -0.01, 0.03);
  EXPECT_EQ(side.point_L, Vec3(node.s0_L + offset));
  EXPECT_EQ(side.Psi_r_L, node.Psi_r_L);
  for (int mode = 0; mode < 2; ++mode) {
    const Vec3 moved = node.Psi_t_L.col(mode) + Vec3(node.Psi_r_L.col(mode)).cross(offset);
    EXPECT_LT((side.Psi_t_L.col(mode) - moved).norm(), 1e-15);
  }
  EXPECT_LT((side.C - rotation_about(Axis::x, 1.0)).norm(), 1e-15);
  EXPECT_EQ(joint(model, "D").on(Side::parent).Psi_t_L.cols(), 0);
}

TEST(ModelFile, ReadsModalStartAndBeamSections) {
  const auto rod_of = [](const std::string& section) {
    std::string text = kSoundModel;
    const std::string old = "{ diameter = 0.006 }";
    text.replace(text.find(old), old.size(), section);
    text.replace(text.find("name = \"rod\""), 12, "name = \"rod\"\nstart = { a = [1, 2], adot = [3, 4] }");
    return parse_model(text, "m.toml").bodies[2];
  };
  const Body rod = rod_of("{ diameter = 0.006, inner_diameter = 0.004 }");
  EXPECT_EQ(rod.a_start, VecX(Eigen::Vector2d(1.0, 2.0)));
  EXPECT_EQ(rod.adot_start, VecX(Eigen::Vector2d(3.0, 4.0)));
  EXPECT_NEAR(rod.modal->G(0, 0), 7870.0 * 0.3 * std::numbers::pi / 4.0 * (36e-6 - 16e-6), 1e-15);
  // The first bending frequency tells area and second moment apart: k1^2 sqrt(E I / (rho A)).
  const double k1 = std::numbers::pi / 0.3;
  const auto first = [&](double ratio) { return k1 * k1 * std::sqrt(2e11 * ratio / 7870.0); };
  EXPECT_NEAR(rod.modal->frequencies(0) / first((36e-6 + 16e-6) / 16.0), 1.0, 1e-3);
  EXPECT_NEAR(rod_of("{ width_y = 0.004, width_z = 0.01 }").modal->frequencies(0) / first(16e-6 / 12.0), 1.0, 1e-3);
  EXPECT_NEAR(rod_of("{ area = 1e-5, second_moment_y = 4e-12, second_moment_z = 3e-12, torsion_constant = 7e-12 }")
                      .modal->frequencies(0) /
                  first(3e-7),
              1.0, 1e-3);
}

TEST(ModelFile, ReadsRunAndNeeds) {
  std::string text = kSoundModel;
  text.replace(text.find("until = 1"), 9, "until = 2\nrtol = 1e-8\nsamples = 50");
  text += "[[need]]\njoint = \"B\"\ncomponent = \"F_y\"\nsame_run = 5\nbecause = \"it is chaotic\"\n";
  const Model model = parse_model(text, "m.toml");
  EXPECT_EQ(model.run.until, 2.0);
  EXPECT_EQ(model.run.rtol, 1e-8);
  EXPECT_EQ(model.run.samples, 50);
  ASSERT_EQ(model.needs.size(), 1U);
  EXPECT_EQ(model.needs.front().joint, "B");
  EXPECT_EQ(model.needs.front().component, "F_y");
  EXPECT_EQ(model.needs.front().same_run, 5.0);
  EXPECT_FALSE(model.needs.front().same_state.has_value());
  EXPECT_EQ(model.needs.front().because, "it is chaotic");
  EXPECT_GT(model.needs.front().where.line, 0);
}

TEST(ModelFile, NamesAFileThatCannotBeRead) {
  try {
    (void)read_model("nowhere/at_all.toml");
    FAIL() << "read a file that does not exist";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "nowhere/at_all.toml: error: cannot read the file: is the path right?");
  }
}

class BrokenModelFile : public testing::TestWithParam<BrokenModel> {};

TEST_P(BrokenModelFile, IsRefusedWordByWord) {
  const std::string text = GetParam().text();
  ASSERT_FALSE(text.empty()) << "the edit does not apply";
  try {
    (void)parse_model(text, "broken.toml");
    FAIL() << "the broken file was read";
  } catch (const InputError& error) {
    EXPECT_EQ(error.what(), GetParam().message("broken.toml"));
  }
}

INSTANTIATE_TEST_SUITE_P(All, BrokenModelFile, testing::ValuesIn(broken_models()),
                         [](const auto& one) { return one.param.name; });

TEST(ModelFile, TheSoundModelIsSound) { EXPECT_NO_THROW(parse_model(kSoundModel, "m.toml")); }

std::vector<std::string> shipped_models() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(CONCORD_DATA "/models")) {
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  }
  return names;
}

Model shipped(const std::string& name) { return read_model(CONCORD_DATA "/models/" + name + ".toml"); }

TEST(ShippedModels, CanAllBeRead) {
  const std::vector<std::string> names = shipped_models();
  EXPECT_GE(names.size(), 37U);
  for (const std::string& name : names) EXPECT_EQ(shipped(name).name, name);
}

TEST(ShippedModels, SliderCrankHasTheNumbersOfTheIssue) {
  const Model model = shipped("slider_crank_rigid");
  const Body& crank = model.bodies[1];
  EXPECT_EQ(crank.mass, 0.36);
  EXPECT_NEAR(crank.inertia_L(0, 0), 0.36 * 0.01 * 0.01 / 2.0, 1e-18);
  EXPECT_NEAR(crank.inertia_L(2, 2), 0.36 * (3.0 * 0.01 * 0.01 + 0.15 * 0.15) / 12.0, 1e-18);
  const Body& coupler = model.bodies[2];
  EXPECT_NEAR(coupler.mass, 7870.0 * std::numbers::pi * 0.003 * 0.003 * 0.3, 1e-15);
  EXPECT_NEAR(coupler.inertia_L(1, 1), coupler.mass * (3.0 * 0.003 * 0.003 + 0.3 * 0.3) / 12.0, 1e-17);
  EXPECT_EQ(model.bodies[3].mass, 0.0334);
  int rows = 0;
  for (const Joint& one : model.joints) rows += one.type->rows();
  EXPECT_EQ(rows, 17);
  EXPECT_EQ(evaluate(joint(model, "A").drivers.front().law, 1.0).fdot, 150.0);
  const Model running = shipped("slider_crank_rigid_free");
  EXPECT_EQ(joint(running, "A").start.front().u(0), 150.0);
  EXPECT_EQ(joint(running, "A").start.front().role_u, StartRole::keep);
}

TEST(ShippedModels, FlexibleCouplerWeighsWhatTheRigidOneDoes) {
  for (const std::string machine : {"slider_crank_", "slider_crank_spatial_"}) {
    const Body rigid = shipped(machine + "rigid").bodies[2];
    const Body flexible = shipped(machine + "flexible").bodies[2];
    const MatX& G = flexible.modal->G;
    EXPECT_NEAR(G(0, 0), rigid.mass, 1e-15);
    EXPECT_LT((G.block<3, 1>(1, 0) / rigid.mass - rigid.center_of_mass_L).norm(), 1e-14);
    const Mat3 about_origin = G.block<3, 3>(1, 1).trace() * Mat3::Identity() - G.block<3, 3>(1, 1);
    const Mat3 arm = skew(rigid.center_of_mass_L);
    EXPECT_LT((about_origin + rigid.mass * arm * arm - rigid.inertia_L).norm(), 1e-15);
  }
}

TEST(ShippedModels, TopStartsInSteadyPrecession) {
  const Model model = shipped("spinning_top");
  const Body& top = model.bodies[1];
  const Joint& support = model.joints.front();
  const Attachment& ground = support.on(Side::parent);
  const Vec4 p = support.start.front().q;
  const Mat3 A =
      ground.C * Eigen::Quaterniond(p(0), p(1), p(2), p(3)).toRotationMatrix() * support.on(Side::child).C.transpose();
  const Vec3 omega = ground.C * support.start.front().u;
  const Vec3 axis = A.col(2);
  // omega = W e_Z + spin * axis: what is left of it across both must vanish.
  const double W = omega.cross(axis).norm() / Vec3::UnitZ().cross(axis).norm();
  EXPECT_NEAR(W, 8.0, 1e-12);
  EXPECT_NEAR(omega.dot(Vec3::UnitZ().cross(axis)), 0.0, 1e-13);
  // Euler's equation about the support: the moment of weight is the rate of the angular momentum, W e_Z x h.
  const Vec3 lever = A * (top.center_of_mass_L - support.on(Side::child).point_L);
  const Mat3 J = top.inertia_L - top.mass * skew(A.transpose() * lever) * skew(A.transpose() * lever);
  const Vec3 h = A * J * A.transpose() * omega;
  EXPECT_LT((W * Vec3::UnitZ().cross(h) - lever.cross(top.mass * model.gravity)).norm(), 1e-13);
}

TEST(ShippedModels, PendulumHangsAtAngleZero) {
  const Model model = shipped("compound_pendulum");
  const Joint& hinge = model.joints.front();
  const Body& body = model.bodies[1];
  const Vec3 arm_C = hinge.on(Side::child).C.transpose() * (body.center_of_mass_L - hinge.on(Side::child).point_L);
  EXPECT_LT((arm_C - Vec3(0.22, 0.0, 0.07)).norm(), 1e-15);
  const Vec3 gravity_C = hinge.on(Side::parent).C.transpose() * model.gravity;
  EXPECT_NEAR(gravity_C.x(), 9.81 * std::cos(25.0 * kRadiansPerDegree), 1e-14);
  EXPECT_NEAR(gravity_C.y(), 0.0, 1e-15);
}

/// Mass [kg] and its centre as the guessed poses have it.
std::pair<double, Vec3> mass_and_centre(const Model& model) {
  const std::vector<Pose> poses = guess_poses(model);
  double mass = 0.0;
  Vec3 moment = Vec3::Zero();
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    const double own = body.modal ? body.modal->G(0, 0) : body.mass;
    const Vec3 own_moment_L = body.modal ? Vec3(body.modal->G.block<3, 1>(1, 0)) : Vec3(own * body.center_of_mass_L);
    mass += own;
    moment += own * poses[i].r + poses[i].A * own_moment_L;
  }
  return {mass, moment / mass};
}

TEST(ShippedModels, CarHasFifteenDegreesOfFreedomAndTheLoadsOfItsAxles) {
  const Model model = shipped("car");
  int freedoms = 6 * (static_cast<int>(model.bodies.size()) - 1);
  for (const Joint& one : model.joints) freedoms -= one.type->rows();
  EXPECT_EQ(freedoms, 15);
  EXPECT_EQ(model.joints.size() - (model.bodies.size() - 1), 4U) << "loops";
  for (const std::string name : {"car", "car_flexible_beam"}) {
    const auto [mass, centre] = mass_and_centre(shipped(name));
    EXPECT_NEAR(mass, 1094.5 + 2 * 65.7, 1e-9);
    const double rear_load = 9.81 * mass * -centre.x() / 2.393;
    EXPECT_NEAR(rear_load, 9.81 * (1094.5 * 0.884 / 2.393 + 65.7), 0.006 * rear_load) << name;
  }
}

TEST(ShippedModels, CarFitsTogetherAsItStands) {
  const Model model = shipped("car");
  const std::vector<Pose> poses = guess_poses(model);
  const auto place = [&](const Attachment& side) {
    return Vec3(poses[side.body].r + poses[side.body].A * side.point_L);
  };
  for (const Joint& one : model.joints) {
    const Vec3 gap = place(one.on(Side::child)) - place(one.on(Side::parent));
    const Mat3 turn = (poses[one.on(Side::parent).body].A * one.on(Side::parent).C).transpose() *
                      poses[one.on(Side::child).body].A * one.on(Side::child).C;
    EXPECT_LT((turn - Mat3::Identity()).norm(), 1e-14) << one.name;
    if (one.type->name == "distance") {
      const double length = std::get<joints::KeepDistance>(one.type->forbids.front()).length;
      EXPECT_NEAR(gap.norm(), length, 1e-15) << one.name;
      EXPECT_NEAR(one.on(Side::parent).C.col(2).dot(gap), length, 1e-15) << "the rod lies along z: " << one.name;
    } else if (one.type->name != "free") {
      EXPECT_LT(gap.norm(), 1e-14) << one.name;
    }
    if (one.name.starts_with("front_left_") || one.name.starts_with("rear_left_")) {
      std::string other = one.name;
      other.replace(other.find("left"), 4, "right");
      const Vec3 mirrored = place(joint(model, other).on(Side::child)).cwiseProduct(Vec3(1.0, -1.0, 1.0));
      EXPECT_LT((place(one.on(Side::child)) - mirrored).norm(), 1e-14) << one.name;
    }
  }
}

TEST(ShippedModels, CarMeetsItsBumpAfterSixSecondsOfRolling) {
  const Model model = shipped("car_left_bump");
  const double speed = joint(model, "chassis").start.front().u(0);
  for (const ForceElement& element : model.elements) {
    const auto* tire = std::get_if<Tire>(&element.what);
    if (tire == nullptr) continue;
    const bool is_left = element.name.find("left") != std::string::npos;
    const auto& bump = std::get<HalfSineBump>(tire->road->profile);
    EXPECT_EQ(bump.height, is_left ? 0.015 : 0.0) << element.name;
    EXPECT_EQ(bump.start, 6.0 * speed);
    EXPECT_LT((tire->wheel.C.col(1) - Vec3::UnitY()).norm(), 1e-15);
    const Vec3 centre = guess_poses(model)[tire->wheel.body].r;
    std::string hub = element.name;
    hub.replace(hub.find("tire"), 4, "hub");
    EXPECT_NEAR(joint(model, hub).start.front().u(0) * centre.z(), speed, 1e-12) << "rolls on its loaded radius";
  }
}

}  // namespace
}  // namespace concord
