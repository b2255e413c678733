#include "common/joints/joint_type.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <random>

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
                                     {"screw", 5, 1, 1}};
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
    const auto has_coordinates = [](const Permit& word) { return n_q(word) > 0; };
    EXPECT_EQ(type->reads.size(), std::ranges::count_if(type->permits, has_coordinates)) << type->name;
  }
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

/// Largest magnitude that a component can have among the unit ideal wrenches (S^T w = 0) of one pose.
double largest_component(const PermittedPose& pose, Side side, int component) {
  const MatX ideal = pose.S.cols() == 0 ? MatX(Mat6::Identity()) : MatX(pose.S.transpose().fullPivLu().kernel());
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
          const PermittedPose pose = random_pose(*type, generator);
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
  EXPECT_FALSE(carries(*find("universal"), Side::child, 4));
  EXPECT_TRUE(carries(*find("universal"), Side::child, 3));
}

}  // namespace
}  // namespace concord::joints
