#include "tests/second_reading/stated_motions.h"

#include <gtest/gtest.h>

#include "common/joints/catalogue.h"
#include "compare/audit/referee.h"

namespace concord::second_reading {
namespace {

std::vector<double> examples_of(const joints::JointType& type) {
  std::vector<double> numbers;
  for (const joints::Parameter& parameter : type.parameters) numbers.push_back(parameter.example);
  return numbers;
}

VecX some_coordinates(const joints::JointType& type) {
  VecX q = VecX::LinSpaced(type.n_q(), 0.3, 1.1);
  if (q.size() > 3) q.tail<4>().normalize();  // a ball comes last
  return q;
}

/// The table of data/format/joints.md has a row for each type of the catalogue.
TEST(StatedMotions, EveryTypeOfTheCatalogueMovesAsTheFormatSays) {
  int n_types = 0;
  for (const joints::JointType* type : joints::catalogue()) {
    const VecX q = some_coordinates(*type);
    const auto stated = stated_placement(type->name, examples_of(*type), q);
    if (!stated) continue;  // a page outside the project
    ++n_types;
    const joints::Placement page = compare::referee_motion(*type, q).placement;
    EXPECT_LT((page.d - stated->d).norm(), 1e-15) << type->name;
    EXPECT_LT((page.R - stated->R).norm(), 1e-14) << type->name;
    const auto speeds = stated_speeds(type->name, examples_of(*type), stated->R);
    ASSERT_EQ(speeds.has_value(), !type->permits_speeds.empty()) << type->name;
    if (!speeds) continue;
    EXPECT_EQ(speeds->n, static_cast<int>(type->permits_speeds.size())) << type->name;
    for (const joints::PermitSpeed& word : type->permits_speeds) {
      EXPECT_LT((speeds->forbidden * compare::referee_permitted_speed(word, page.R)).norm(), 1e-15) << type->name;
    }
  }
  EXPECT_EQ(n_types, 13);
}

TEST(StatedMotions, AThreadIsRightHanded) {
  const auto turned = stated_placement("screw", {0.02}, VecX::Constant(1, 0.5));
  EXPECT_DOUBLE_EQ(turned->d.z(), 0.01);
  EXPECT_GT(turned->R(1, 0), 0.0);
}

/// Rolling along x turns a ball about y: its lowest point rests.
TEST(StatedMotions, ABallRollsOnThePlaneBelow) {
  const auto speeds = stated_speeds("rolling_ball", {0.25}, Mat3::Identity());
  Vec6 rolling;
  rolling << 0.5, 0.0, 0.0, 0.0, 2.0, 0.0;
  EXPECT_EQ((speeds->forbidden * rolling).norm(), 0.0);
  rolling(4) = -2.0;
  EXPECT_GT((speeds->forbidden * rolling).norm(), 0.5);
}

TEST(StatedMotions, ASkateGlidesAlongItsX) {
  Mat3 quarter_turn;
  quarter_turn << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  const auto speeds = stated_speeds("knife_edge", {}, quarter_turn);
  Vec6 along = Vec6::Zero();
  along(1) = 1.0;
  EXPECT_EQ((speeds->forbidden * along).norm(), 0.0);
  EXPECT_EQ((speeds->forbidden * Vec6::Unit(0)).norm(), 1.0);
}

TEST(StatedMotions, AnUnknownTypeHasNone) {
  EXPECT_FALSE(stated_placement("planar_cam", {}, VecX::Zero(1)).has_value());
  EXPECT_FALSE(stated_speeds("revolute", {}, Mat3::Identity()).has_value());
}

}  // namespace
}  // namespace concord::second_reading
