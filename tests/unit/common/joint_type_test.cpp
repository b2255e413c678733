#include "common/joints/joint_type.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/decompositions.h"
#include "common/joints/catalogue.h"
#include "tests/unit/permitted_pose.h"

namespace concord::joints {
namespace {

struct Counts {
  const char* name;
  int rows;
  int n_q;
  int n_u;
};

TEST(JointType, CountsRowsCoordinatesAndSpeeds) {
  const std::vector<Counts> expected{{"weld", 6, 0, 0},
                                     {"revolute", 5, 1, 1},
                                     {"translational", 5, 1, 1},
                                     {"cylindrical", 4, 2, 2},
                                     {"spherical", 3, 4, 3},
                                     {"universal", 4, 2, 2},
                                     {"free", 0, 7, 6},
                                     {"distance", 1, 6, 5},
                                     {"revolute_spherical", 2, 5, 4},
                                     {"universal_spherical", 1, 6, 5},
                                     {"screw", 5, 1, 1},
                                     {"knife_edge", 3, 3, 3},
                                     {"rolling_ball", 1, 6, 5}};
  ASSERT_EQ(catalogue().size(), expected.size());
  for (const Counts& one : expected) {
    const JointType* type = find(one.name);
    ASSERT_NE(type, nullptr) << one.name;
    EXPECT_EQ(type->rows(), one.rows) << one.name;
    EXPECT_EQ(type->n_q(), one.n_q) << one.name;
    EXPECT_EQ(type->n_u(), one.n_u) << one.name;
  }
}

TEST(JointType, ForbidsWhatItDoesNotPermit) {
  for (const JointType* type : catalogue()) {
    EXPECT_EQ(type->rows() + type->n_u(), 6) << type->name;
    const auto n_speeds = static_cast<int>(type->permits_speeds.size());
    EXPECT_EQ(n_speeds > 0, type->nonholonomic_rows() > 0) << type->name;
    if (n_speeds > 0) {
      EXPECT_EQ(type->rows() + type->nonholonomic_rows() + n_speeds, 6) << type->name;
    }
    const auto has_coordinates = [](const Permit& word) { return n_q(word) > 0; };
    EXPECT_EQ(type->reads.size(), std::ranges::count_if(type->permits, has_coordinates)) << type->name;
  }
}

TEST(Facts, OfReadingsAreThoseOfTheMotion) {
  for (const JointType* type : catalogue()) {
    std::vector<CoordinateKind> of_motion;
    std::vector<CoordinateKind> of_readings;
    for (const Permit& word : type->permits) {
      for (const StatedCoordinate& one : stated_coordinates(word)) of_motion.push_back(one.kind);
    }
    for (const Read& word : type->reads) {
      for (const CoordinateKind kind : kinds_of(word)) of_readings.push_back(kind);
    }
    EXPECT_EQ(of_motion, of_readings) << type->name;
  }
}

TEST(Facts, OfEachWordOfAMotion) {
  const Permit turn = Turn{Axis::y};
  EXPECT_EQ(stated_coordinates(turn)[0].name, "turn_y");
  EXPECT_EQ(stated_coordinates(turn)[0].axis, Axis::y);
  EXPECT_FALSE(is_length(turn, 0));
  EXPECT_TRUE(is_length(Permit(Slide{Axis::x}), 0));
  const Permit arm = Arm{Axis::z, 0.7};
  EXPECT_EQ(stated_coordinates(arm).size(), 0);
  EXPECT_EQ(stated_length(arm), 0.7);
  EXPECT_EQ(arm_of(arm), Axis::z);
  const Permit ball = Ball{};
  EXPECT_TRUE(is_orientation(ball));
  EXPECT_EQ(n_q(ball), 4);
  EXPECT_EQ(n_u(ball), 3);
  EXPECT_EQ(home_of(ball), VecX(Vec4::Unit(0)));
  EXPECT_EQ(home_of(turn), VecX(VecX::Zero(1)));
}

TEST(Facts, OfAMotionByFunctionsAreThoseOfItsPage) {
  const Permit& thread = find("screw")->permits.front();
  const StatedCoordinates coordinates = stated_coordinates(thread);
  ASSERT_EQ(coordinates.size(), 1);
  EXPECT_EQ(coordinates[0].kind, CoordinateKind::angle);
  EXPECT_EQ(coordinates[0].name, "turn");
  EXPECT_FALSE(coordinates[0].axis.has_value()) << "it moves the child along the axis, too";
  EXPECT_NE(function_of(thread), nullptr);
  EXPECT_EQ(pushed_by(find("screw")->reads.front()), Push::stated);
}

TEST(JointType, ForbidsTheVelocityOfSkatesAndRollingBallsBesideTheirPlace) {
  EXPECT_EQ(find("knife_edge")->nonholonomic_rows(), 1);
  EXPECT_EQ(find("rolling_ball")->nonholonomic_rows(), 2);
  EXPECT_EQ(find("free")->nonholonomic_rows(), 0);
}

TEST(JointType, RollsOnTheRadiusThatAJointGives) {
  const JointType ball = find("rolling_ball")->with_parameters({0.4});
  for (const ForbidSpeed& word : ball.forbids_speeds) EXPECT_EQ(std::get<NoSlip>(word).below, 0.4);
  for (const int k : {0, 1}) EXPECT_EQ(std::get<SpeedAbout>(ball.permits_speeds[k]).below, 0.4);
}

TEST(JointType, IsFoundByItsNameOnly) {
  EXPECT_EQ(find("hinge"), nullptr);
  EXPECT_EQ(find("revolute")->name, "revolute");
}

/// Rate at which the child's material point below the joint point slips.
double slip_of(const NoSlip& word, const PermittedPose& pose, const Vec6& v_rel) {
  const Vec3 lever = -word.below * Vec3::UnitZ();
  return axis_in(pose, word.axis_of, word.axis).dot(v_rel.head<3>() + Vec3(v_rel.tail<3>()).cross(lever));
}

TEST(JointType, VelocitiesThatArePermittedDoNotSlipAndReachNoFurtherThanTheMotion) {
  std::mt19937 generator(5);
  for (const char* name : {"knife_edge", "rolling_ball"}) {
    const JointType& type = *find(name);
    for (int trial = 0; trial < 10; ++trial) {
      const PermittedPose pose = random_pose(type, generator);
      Mat6X S(6, 0);
      for (const PermitSpeed& word : type.permits_speeds) {
        S.conservativeResize(6, S.cols() + 1);
        S.rightCols<1>() = direction_of(word, pose);
        for (const ForbidSpeed& slip : type.forbids_speeds) {
          EXPECT_NEAR(slip_of(std::get<NoSlip>(slip), pose, S.rightCols<1>()), 0.0, 1e-15) << name;
        }
      }
      EXPECT_GT(singular_values(S).minCoeff(), 1e-9) << name;
      const Mat6X outside = S - pose.S * least_squares(pose.S, S);
      EXPECT_LT(outside.norm(), 1e-14) << name;
    }
  }
}

}  // namespace
}  // namespace concord::joints
