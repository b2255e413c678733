#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/joints/by_function.h"
#include "common/joints/catalogue.h"
#include "compare/joint_check/command.h"
#include "compare/joint_check/sheet.h"

/// The joint check must refute what is wrong: types with one mistake each, and what it says of them.
namespace concord::compare::joint_check {
namespace {

using namespace joints;  // pages are written in its words

constexpr std::uint32_t kSeed = 5;

Sheet sheet_of(const JointType& type) {
  SheetOptions options;
  options.seed = kSeed;
  options.poses = {0, 1, 2};
  return check_joint(type, options);
}

/// The failing properties of a sheet, one on each line.
std::string failures(const Sheet& sheet) {
  std::string names;
  for (const Property& property : sheet.properties) {
    if (!property.holds()) names += property.name + '\n';
  }
  for (const Property& cell : sheet.wrenches.cells) {
    if (!cell.holds()) names += cell.name + '\n';
  }
  return names;
}

void expect_refuted(const JointType& type, const std::string& property) {
  const Sheet sheet = sheet_of(type);
  EXPECT_FALSE(sheet.holds());
  EXPECT_NE(failures(sheet).find(property + '\n'), std::string::npos) << "found only:\n" << failures(sheet);
}

const JointType& hinge() { return *find("revolute"); }

TEST(JointCheck, RefutesAMotionAboutAnotherAxis) {
  JointType type = hinge();
  type.permits = {Turn{Axis::y}};
  expect_refuted(type, "the permitted motion is forbidden by nothing");
  expect_refuted(type, "permitted speeds and forbidden directions are orthogonal");
  expect_refuted(type, "each solver accepts the other's states");
}

TEST(JointCheck, RefutesAReadingOfAnotherAngle) {
  JointType type = hinge();
  type.reads = {TurnOfParentAxis{.about = Axis::z, .of_parent_axis = Axis::x}};
  EXPECT_EQ(failures(sheet_of(type)), "") << "the same angle in other words";
  type.permits = {Turn{Axis::x}};
  type.forbids = {Coincide{}, SameDirection{Axis::x}};
  type.reads = {TurnOfChildAxis{.about = Axis::x, .of_child_axis = Axis::y}};
  EXPECT_EQ(failures(sheet_of(type)), "") << "a hinge about another axis";
  type.reads = {TurnOfChildAxis{.about = Axis::y, .of_child_axis = Axis::z}};
  expect_refuted(type, "coordinates read back from the permitted motion");
  expect_refuted(type, "their rates read back too");
}

TEST(JointCheck, RefutesADirectionThatIsForbiddenTwice) {
  JointType type = hinge();
  type.forbids = {NoGapAlong{Axis::x}, NoGapAlong{Axis::y}, NoGapAlong{Axis::x}, SameDirection{Axis::z}};
  expect_refuted(type, "both together have full rank, away from singular poses");
}

TEST(JointCheck, RefutesASecondPlaceNearby) {
  JointType type = *find("translational");
  const auto gap_or_a_tenth = function_of_placement(
      []<class T>(const Vec3Of<T>& d, const Mat3Of<T>&) { return VectorOf<T, 1>(d.x() * (10.0 * d.x() - 1.0)); });
  type.forbids = {ByResidual{gap_or_a_tenth}, NoGapAlong{Axis::y}, SameOrientation{}};
  expect_refuted(type, "nothing else nearby is allowed");
}

TEST(JointCheck, RefutesAnAngleOfASlideAndLooksNoFurther) {
  JointType type = hinge();
  type.permits = {Turn{Axis::z}, Slide{Axis::z}};
  EXPECT_EQ(failures(sheet_of(type)), "rows and speeds are six together\n");
  type.forbids = {NoGapAlong{Axis::x}, NoGapAlong{Axis::y}, SameDirection{Axis::z}};
  EXPECT_EQ(failures(sheet_of(type)), "every coordinate has its reading\n");
  type.reads.emplace_back(SlideAlong{Axis::z});
  EXPECT_EQ(failures(sheet_of(type)), "words stand in an order that has a meaning\n");
}

/// A slide along a circle in the xy plane, that keeps its orientation: by functions throughout.
JointType ring_by_functions(Wrenches (*wrenches)(const Placement&)) {
  const auto off_the_ring = function_of_placement(
      []<class T>(const Vec3Of<T>& d, const Mat3Of<T>&) { return VectorOf<T, 2>(hypot(d.x(), d.y()) - 0.3, d.z()); });
  const auto along_the_ring = function_of_coordinates<1>([]<class T>(const VectorOf<T, 1>& q) {
    return PlacementOf<T>{Vec3Of<T>(0.3 * cos(q(0)), 0.3 * sin(q(0)), T(0.0)), Mat3Of<T>::Identity()};
  });
  const auto bearing = function_of_placement(
      []<class T>(const Vec3Of<T>& d, const Mat3Of<T>&) { return VectorOf<T, 1>(atan2(d.y(), d.x())); });
  return {
      .name = "ring",
      .forbids = {ByResidual{off_the_ring}, SameOrientation{}},
      .permits = {ByMotion{along_the_ring, {true}, {"along"}}},
      .reads = {ByReading{bearing, {true}, wrenches}},
  };
}

Wrenches push_along(const Placement& at) {
  Wrenches span(6, 1);
  span << Vec3::UnitZ().cross(at.d), Vec3::Zero();
  return span;
}

Wrenches push_outward(const Placement& at) {
  Wrenches span(6, 1);
  span << at.d, Vec3::Zero();
  return span;
}

TEST(JointCheck, ProvesATypeByFunctions) { EXPECT_EQ(failures(sheet_of(ring_by_functions(push_along))), ""); }

TEST(JointCheck, RefutesACoordinateWrenchThatDoesNoWork) {
  expect_refuted(ring_by_functions(push_outward), "each coordinate's wrench works on it alone, by both solvers");
  EXPECT_EQ(failures(sheet_of(ring_by_functions(nullptr))), "functions say all that is asked of them\n");
}

TEST(JointCheck, RefutesAMotionThatTurnsByNoRotation) {
  JointType type = ring_by_functions(push_along);
  const auto swelling = function_of_coordinates<1>([]<class T>(const VectorOf<T, 1>& q) {
    return PlacementOf<T>{Vec3Of<T>(0.3 * cos(q(0)), 0.3 * sin(q(0)), T(0.0)), Mat3Of<T>::Identity() * (1.0 + 1e-9)};
  });
  type.permits = {ByMotion{swelling, {true}, {"along"}}};
  expect_refuted(type, "the permitted motion turns the child by a rotation");
}

TEST(JointCheck, OnePoseOfASeedIsTheSameAloneAndAmongOthers) {
  JointType type = hinge();
  type.reads = {TurnOfChildAxis{.about = Axis::z, .of_child_axis = Axis::y}};
  type.permits = {Turn{Axis::y}};
  SheetOptions alone;
  alone.seed = kSeed;
  alone.poses = {2};
  const Sheet among = sheet_of(type);
  for (const Property& property : check_joint(type, alone).properties) {
    for (const Property& same : among.properties) {
      if (same.name == property.name && same.pose == 2) {
        EXPECT_EQ(same.where, property.where) << same.name;
      }
    }
  }
}

TEST(JointCheck, SheetTellsWhatFailsAndHowToSeeItAgain) {
  JointType type = hinge();
  type.permits = {Turn{Axis::y}};
  const Sheet sheet = sheet_of(type);
  const std::string text = format_sheet(sheet);
  EXPECT_EQ(text.find("joint revolute: forbids 5 directions, permits turn_y; seed 5, poses 0 to 2\n"), 0U);
  EXPECT_NE(text.find("FAIL revolute: the permitted motion is forbidden by nothing: 0."), std::string::npos) << text;
  EXPECT_NE(text.find("     again: concord joint revolute --seed 5 --pose "), std::string::npos);
  EXPECT_NE(text.find("\nFAILS revolute: "), std::string::npos);
  const auto json = nlohmann::json::parse(format_sheet_json(sheet));
  EXPECT_EQ(json["verdict"], "fails");
  EXPECT_EQ(json["seed"], 5);
  EXPECT_EQ(json["properties"].size(), sheet.properties.size() + sheet.wrenches.cells.size());
}

struct Told {
  int code;
  std::string out;
  std::string err;
};

Told run(const JointCommand& command) {
  std::ostringstream out;
  std::ostringstream err;
  const int code = check_joints(command, {out, err});
  return {code, out.str(), err.str()};
}

TEST(JointCommand, RefusesWhatIsNoJointType) {
  const Told told = run({.names = {"revolut"}});
  EXPECT_EQ(told.code, kBadInput);
  EXPECT_EQ(told.err, "command line: error: no joint type 'revolut': did you mean 'revolute'?\n");
  EXPECT_EQ(run({}).code, kBadInput);
}

TEST(JointCommand, WritesSheetsAndSumsThemUp) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "concord_joint_sheets";
  const Told told = run({.names = {"weld", "cylindrical"}, .poses = 2, .out = folder});
  EXPECT_EQ(told.code, kAgree) << told.out;
  EXPECT_NE(told.out.find("| cylindrical |    4 | slide_z, turn_z |   75 of 75 |"), std::string::npos) << told.out;
  for (const char* name : {"weld", "cylindrical"}) {
    std::ifstream text(folder / (std::string(name) + ".sheet.txt"));
    EXPECT_TRUE(text.good());
    std::ifstream json(folder / (std::string(name) + ".sheet.json"));
    EXPECT_EQ(nlohmann::json::parse(json)["verdict"], "holds");
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace concord::compare::joint_check
