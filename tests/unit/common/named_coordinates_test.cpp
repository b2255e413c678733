#include "common/joints/named_coordinates.h"

#include <gtest/gtest.h>

#include "common/joints/catalogue.h"

namespace concord {
namespace {

class StandsStill : public joints::FunctionOfCoordinates {
 public:
  [[nodiscard]] int n() const override { return 2; }
  void evaluate(const double* /*q*/, const double* /*u*/, Motion& motion) const override { motion = {}; }
};

struct Expected {
  std::string name;
  int word;
  int component;
};

void expect_coordinates(const joints::JointType& type, const std::vector<Expected>& expected) {
  const std::vector<NamedCoordinate> found = named_coordinates(type);
  ASSERT_EQ(found.size(), expected.size()) << type.name;
  for (std::size_t k = 0; k < found.size(); ++k) {
    EXPECT_EQ(found[k].name, expected[k].name) << type.name;
    EXPECT_EQ(found[k].word, expected[k].word) << found[k].name;
    EXPECT_EQ(found[k].component, expected[k].component) << found[k].name;
    EXPECT_EQ(found[k].place, static_cast<int>(k)) << found[k].name;
  }
}

TEST(NamedCoordinates, AreTheWordsOfTheMotion) {
  expect_coordinates(*joints::find("weld"), {});
  expect_coordinates(*joints::find("cylindrical"), {{"slide_z", 0, 0}, {"turn_z", 1, 0}});
  expect_coordinates(*joints::find("free"), {{"slide_x", 0, 0}, {"slide_y", 1, 0}, {"slide_z", 2, 0}, {"ball", 3, 0}});
}

TEST(NamedCoordinates, LeaveArmsOut) {
  expect_coordinates(*joints::find("distance"), {{"turn_x", 0, 0}, {"turn_y", 1, 0}, {"ball", 3, 0}});
}

TEST(NamedCoordinates, NumberWordsOfTheSameName) {
  const joints::JointType type{
      .name = "zxz",
      .forbids = {joints::Coincide{}},
      .permits = {joints::Turn{Axis::z}, joints::Turn{Axis::x}, joints::Turn{Axis::z}},
      .reads = {},
  };
  expect_coordinates(type, {{"turn_z", 0, 0}, {"turn_x", 1, 0}, {"turn_z2", 2, 0}});
}

TEST(NamedCoordinates, OfAMotionByFunctionsAreThoseOfItsPage) {
  joints::ByMotion motion;
  motion.motion = std::make_shared<StandsStill>();
  motion.turns = {true, false};
  motion.names = {"roll", "lift"};
  const joints::JointType type{.name = "cam", .forbids = {}, .permits = {motion}, .reads = {}};
  expect_coordinates(type, {{"roll", 0, 0}, {"lift", 0, 1}});
}

}  // namespace
}  // namespace concord
