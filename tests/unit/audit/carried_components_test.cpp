#include "compare/audit/carried_components.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "common/decompositions.h"
#include "common/joints/by_function.h"
#include "common/joints/catalogue.h"
#include "tests/conformance/free_axes.h"
#include "tests/unit/permitted_pose.h"

/// What a joint can carry, against ideal wrenches (S^T w = 0) at random poses.
namespace concord::compare {
namespace {

using namespace joints;  // pages are written in its words

/// Largest magnitude that a component can have among the unit ideal wrenches of one pose.
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

PermittedPose random_pose_of_speeds(const JointType& type, std::mt19937& generator) {
  PermittedPose pose = random_pose(type, generator);
  if (type.permits_speeds.empty()) return pose;
  pose.S.resize(6, 0);
  for (const PermitSpeed& word : type.permits_speeds) {
    const Vec6 direction = direction_of(word, pose);
    pose.add(direction.head<3>(), direction.tail<3>());
  }
  return pose;
}

/// How many of the twelve components the type carries, each of which some ideal wrench has at some pose.
int expect_carried_exactly(const JointType& type) {
  std::mt19937 generator(11);
  std::vector<PermittedPose> poses;
  for (int trial = 0; trial < 20; ++trial) poses.push_back(random_pose_of_speeds(type, generator));
  int count = 0;
  for (const Side side : kSides) {
    for (int component = 0; component < 6; ++component) {
      double largest = 0.0;
      for (const PermittedPose& pose : poses) largest = std::max(largest, largest_component(pose, side, component));
      const bool said = carries(type, side, component);
      EXPECT_EQ(said, largest > 1e-10) << type.name << " side " << index(side) << " component " << component;
      EXPECT_EQ(said, carried_components(type)[index(side)][component]);
      count += said ? 1 : 0;
    }
  }
  return count;
}

TEST(CarriedComponents, OfTheCatalogueAreThoseThatSomeIdealWrenchHasAtSomePose) {
  for (const JointType* type : catalogue()) expect_carried_exactly(*type);
}

TEST(CarriedComponents, OfEverySetOfFreeAxes) {
  for (const JointType& type : with_any_free_axes()) expect_carried_exactly(type);
}

/// On the child what two turns reach together counts, in their order.
TEST(CarriedComponents, OfTurnsInAnyOrderBehindAnySlides) {
  for (int slides = 0; slides < 8; ++slides) {
    for (int order = 0; order < 27; ++order) {
      JointType type;
      type.name = "slides " + std::to_string(slides) + ", turns " + std::to_string(order);
      for (int k = 0; k < 3; ++k) {
        if ((slides >> k & 1) != 0) type.permits.emplace_back(Slide{static_cast<Axis>(k)});
      }
      // Two turns, and a third one that may be about the same axis as the second: then it adds nothing.
      for (const int axis : {order / 9, order / 3 % 3, order % 3})
        type.permits.emplace_back(Turn{static_cast<Axis>(axis)});
      expect_carried_exactly(type);
    }
  }
}

/// What an arm sweeps counts as what a slide leads along.
TEST(CarriedComponents, OfArmsBehindSlides) {
  JointType type;
  type.name = "link on a sledge";
  type.permits = {Slide{Axis::x}, Turn{Axis::z}, Arm{Axis::x, 0.4}, Ball{}};
  EXPECT_EQ(expect_carried_exactly(type), 6);
  EXPECT_FALSE(carries(type, Side::parent, 1)) << "the sledge and the arm together reach the plane";
  type.permits = {Slide{Axis::z}, Turn{Axis::z}, Arm{Axis::x, 0.4}, Ball{}};
  expect_carried_exactly(type);
  EXPECT_FALSE(carries(type, Side::parent, 5));
  EXPECT_TRUE(carries(type, Side::parent, 3));
  type.permits = {Turn{Axis::z}, Arm{Axis::x, 1e-7}};
  EXPECT_EQ(expect_carried_exactly(type), 11) << "an arm is an arm, however short";
}

TEST(CarriedComponents, PlanarJointKeepsOnlyTheForceAcrossAndTheTorquesInThePlane) {
  for (const Side side : kSides) {
    for (int component = 0; component < 6; ++component) {
      const bool holds = component == 2 || component == 3 || component == 4;
      EXPECT_EQ(carries(planar, side, component), holds) << "side " << index(side) << " component " << component;
    }
  }
}

JointType by_function(std::shared_ptr<const FunctionOfCoordinates> motion, const std::vector<bool>& turns) {
  JointType type;
  type.name = "by function";
  type.permits = {ByMotion{std::move(motion), turns, {}}};
  return type;
}

TEST(CarriedComponents, OfFunctionsAreSeenFromTheirDerivatives) {
  const JointType type = by_function(function_of_coordinates<3>([]<class T>(const VectorOf<T, 3>& q) {
                                       const Mat3Of<T> R = rotation_by(Axis::z, q(2));
                                       return PlacementOf<T>{Vec3Of<T>(q(0), q(1), T(0.0)), R};
                                     }),
                                     {false, false, true});
  EXPECT_EQ(carried_components(type), carried_components(planar));
  EXPECT_EQ(expect_carried_exactly(type), 6);
}

/// A slot that is straight but for the last sixteenth of its reach.
TEST(CarriedComponents, OfAFunctionInPiecesAreThoseOfAllPieces) {
  const auto slot = function_of_coordinates<1>([]<class T>(const VectorOf<T, 1>& q) {
    const T beyond = q(0) > T(0.35) ? T(q(0) - 0.35) : T(0.0);
    return PlacementOf<T>{Vec3Of<T>(q(0), beyond * beyond * beyond, T(0.0)), Mat3Of<T>::Identity()};
  });
  const JointType type = by_function(slot, {false});
  EXPECT_TRUE(carries(type, Side::parent, 0));
  JointType straight = type;
  std::get<ByMotion>(straight.permits[0]).ranges = {{-0.4, 0.3}};
  EXPECT_FALSE(carries(straight, Side::parent, 0));
}

/// Where a function has no value, nothing is known.
TEST(CarriedComponents, OfAFunctionWithoutAValueAreAll) {
  const auto root = function_of_coordinates<1>([]<class T>(const VectorOf<T, 1>& q) {
    return PlacementOf<T>{Vec3Of<T>(sqrt(q(0)), T(0.0), T(0.0)), Mat3Of<T>::Identity()};
  });
  JointType type = by_function(root, {false});
  for (int component = 0; component < 6; ++component) EXPECT_TRUE(carries(type, Side::child, component));
  std::get<ByMotion>(type.permits[0]).ranges = {{0.1, 0.5}};
  EXPECT_FALSE(carries(type, Side::child, 0));
}

TEST(CarriedComponents, OfWordsAtBothSides) {
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
}  // namespace concord::compare
