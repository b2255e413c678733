#include "common/joints/joint_type.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <random>

#include "common/decompositions.h"
#include "common/joints/catalogue.h"
#include "common/rotation.h"

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

/// A pose of the permitted motion and its directions [ddot; omega_rel], in the parent's joint frame.
struct PermittedPose {
  Vec3 d = Vec3::Zero();
  Mat3 R = Mat3::Identity();
  Mat6X S = Mat6X(6, 0);

  void add(const Vec3& velocity, const Vec3& turning) {
    S.conservativeResize(6, S.cols() + 1);
    S.rightCols<1>() << velocity, turning;
  }
  /// An arm moves as the turns before it turn.
  void reach(const Vec3& arm) {
    d += arm;
    for (auto column : S.colwise()) column.head<3>() += Vec3(column.tail<3>()).cross(arm);
  }
  /// The turns before a ball are not the child's.
  void turn_alone() {
    R.setIdentity();
    S.bottomRows<3>().setZero();
  }
};

PermittedPose random_pose(const JointType& type, std::mt19937& generator) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  PermittedPose pose;
  for (const Permit& word : type.permits) {
    if (const auto* slide = std::get_if<Slide>(&word)) {
      const Vec3 axis = pose.R.col(index(slide->axis));
      pose.add(axis, Vec3::Zero());
      pose.d += uniform(generator) * axis;
    } else if (const auto* turn = std::get_if<Turn>(&word)) {
      pose.add(Vec3::Zero(), pose.R.col(index(turn->axis)));
      pose.R = pose.R * rotation_about(turn->axis, uniform(generator));
    } else if (const auto* arm = std::get_if<Arm>(&word)) {
      pose.reach(arm->length * pose.R.col(index(arm->axis)));
    } else if (const auto* by = std::get_if<ByMotion>(&word)) {
      const VecX q = VecX::NullaryExpr(n_q(word), [&] { return uniform(generator); });
      FunctionOfCoordinates::Motion motion;
      by->motion->evaluate(q.data(), q.data(), motion);
      pose.d = motion.placement.d;
      pose.R = motion.placement.R;
      pose.S = motion.S.leftCols(n_q(word));
    } else {
      pose.turn_alone();
      for (int k = 0; k < 3; ++k) pose.add(Vec3::Zero(), Vec3::Unit(k));
      const Vec3 axis = Vec3::NullaryExpr([&] { return uniform(generator); }).normalized();
      pose.R = pose.R * rotation_about(axis, 1.0 + uniform(generator));
    }
  }
  return pose;
}

/// An axis of the parent or of the child in the pose, in the parent's joint frame.
Vec3 axis_in(const PermittedPose& pose, Side axis_of, Axis axis) {
  return axis_of == Side::parent ? Vec3::Unit(index(axis)) : Vec3(pose.R.col(index(axis)));
}

Vec6 direction_of(const PermitSpeed& word, const PermittedPose& pose) {
  Vec6 direction;
  if (const auto* along = std::get_if<SpeedAlong>(&word)) {
    direction << axis_in(pose, along->axis_of, along->axis), Vec3::Zero();
  } else {
    const auto& about = std::get<SpeedAbout>(word);
    const Vec3 axis = axis_in(pose, about.axis_of, about.axis);
    direction << about.below * axis.cross(Vec3::UnitZ()), axis;
  }
  return direction;
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

/// Largest magnitude that a component can have among the unit ideal wrenches (S^T w = 0) of one pose.
double largest_component(const PermittedPose& pose, Side side, int component) {
  const MatX ideal = pose.S.cols() == 0 ? MatX(Mat6::Identity()) : kernel_of(pose.S.transpose());
  double largest = 0.0;
  for (const auto& wrench : ideal.colwise()) {
    const Vec3 force = wrench.head<3>();
    const Vec3 torque = wrench.tail<3>();
    Vec6 seen;
    if (side == Side::child) {
      seen << pose.R.transpose() * force, pose.R.transpose() * torque;
    } else {
      seen << -force, -(torque + pose.d.cross(force));
    }
    largest = std::max(largest, std::abs(seen(component)));
  }
  return largest;
}

TEST(JointType, CarriesExactlyWhatSomeIdealWrenchHasAtSomePose) {
  std::mt19937 generator(11);
  for (const JointType* type : catalogue()) {
    for (const Side side : {Side::parent, Side::child}) {
      for (int component = 0; component < 6; ++component) {
        double largest = 0.0;
        for (int trial = 0; trial < 20; ++trial) {
          PermittedPose pose = random_pose(*type, generator);
          if (type->nonholonomic_rows() > 0) {
            pose.S.resize(6, 0);
            for (const PermitSpeed& word : type->permits_speeds) {
              const Vec6 direction = direction_of(word, pose);
              pose.add(direction.head<3>(), direction.tail<3>());
            }
          }
          if (pose.S.cols() < 6) largest = std::max(largest, largest_component(pose, side, component));
        }
        EXPECT_EQ(carries(*type, side, component), largest > 1e-10)
            << type->name << " side " << index(side) << " component " << component;
      }
    }
  }
}

TEST(JointType, CarriesNoForceAlongASlideAndNoTorqueAboutAHinge) {
  EXPECT_FALSE(carries(*find("translational"), Side::parent, 2));
  EXPECT_FALSE(carries(*find("translational"), Side::child, 2));
  EXPECT_TRUE(carries(*find("translational"), Side::child, 5));
  EXPECT_FALSE(carries(*find("universal"), Side::parent, 3));
  EXPECT_TRUE(carries(*find("universal"), Side::parent, 4));
  EXPECT_FALSE(carries(*find("knife_edge"), Side::child, 0));
  EXPECT_TRUE(carries(*find("knife_edge"), Side::child, 1));
  EXPECT_TRUE(carries(*find("knife_edge"), Side::parent, 0));
  EXPECT_FALSE(carries(*find("universal"), Side::child, 4));
  EXPECT_TRUE(carries(*find("universal"), Side::child, 3));
}

}  // namespace
}  // namespace concord::joints
