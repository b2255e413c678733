#include "common/model.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "common/joints/catalogue.h"
#include "common/rotation.h"

namespace concord {
namespace {

Attachment attach(int body, const Vec3& point, double tilt) {
  Attachment side;
  side.body = body;
  side.point_L = point;
  side.C = rotation_about(Vec3(0.3, -1.0, 0.6).normalized(), tilt);
  return side;
}

WordStart value(StartRole role, std::initializer_list<double> q) {
  WordStart start;
  start.role_q = role;
  start.q = VecX(static_cast<Eigen::Index>(q.size()));
  std::copy(q.begin(), q.end(), start.q.begin());
  return start;
}

Joint connect(const char* type, const Attachment& parent, const Attachment& child, std::vector<WordStart> start) {
  Joint joint;
  joint.type = joints::find(type);
  joint.sides = {parent, child};
  joint.start = std::move(start);
  return joint;
}

/// Position and orientation of the child's joint frame in the parent's, from poses: (S10).
Pose measured(const Joint& joint, const std::vector<Pose>& poses) {
  const Attachment& parent = joint.on(Side::parent);
  const Attachment& child = joint.on(Side::child);
  const Pose& pose_j = poses[parent.body];
  const Pose& pose_i = poses[child.body];
  const Mat3 A_joint_j = pose_j.A * parent.C;
  return {A_joint_j.transpose() * (pose_i.r + pose_i.A * child.point_L - pose_j.r - pose_j.A * parent.point_L),
          A_joint_j.transpose() * pose_i.A * child.C};
}

Model chain_of_three() {
  Model model;
  model.bodies.resize(4);
  model.joints = {
      connect("universal", attach(kGround, {0.1, 0.4, -0.2}, 0.5), attach(1, {-0.3, 0.1, 0.2}, -0.8),
              {value(StartRole::keep, {0.6}), value(StartRole::keep, {-0.4})}),
      // Runs from body 2 to body 1: the child is reached first.
      connect("cylindrical", attach(2, {0.2, 0.2, 0.5}, 1.1), attach(1, {0.3, -0.1, 0.0}, 0.3),
              {value(StartRole::guess, {0.25}), value(StartRole::guess, {1.2})}),
      connect("spherical", attach(2, {0.0, -0.6, 0.1}, -0.2), attach(3, {0.1, 0.1, 0.4}, 0.9),
              {value(StartRole::keep, {0.5, 0.5, -0.5, 0.5})}),
  };
  return model;
}

TEST(Model, GuessedPosesHaveTheStartCoordinates) {
  const Model model = chain_of_three();
  const auto poses = guess_poses(model);
  ASSERT_EQ(poses.size(), 4U);
  const Pose universal = measured(model.joints[0], poses);
  EXPECT_LT(universal.r.norm(), 1e-15);
  EXPECT_LT((universal.A - rotation_about(Axis::x, 0.6) * rotation_about(Axis::y, -0.4)).norm(), 1e-14);
  const Pose cylindrical = measured(model.joints[1], poses);
  EXPECT_LT((cylindrical.r - Vec3(0.0, 0.0, 0.25)).norm(), 1e-14);
  EXPECT_LT((cylindrical.A - rotation_about(Axis::z, 1.2)).norm(), 1e-14);
  const Pose spherical = measured(model.joints[2], poses);
  EXPECT_LT(spherical.r.norm(), 1e-14);
  EXPECT_LT((spherical.A - Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5).toRotationMatrix()).norm(), 1e-14);
}

/// Newton's method starts from the guess: a soft beam that bends by a right angle would lead it to a joint that is
/// turned round.
TEST(Model, GuessedPosesHoldTheDeformationOfTheStart) {
  Model model = chain_of_three();
  model.bodies[1].a_start = Eigen::Vector2d(0.7, -1.9);
  model.joints[0].sides[index(Side::child)].Psi_t_L = Mat3X::Zero(3, 2);
  model.joints[0].sides[index(Side::child)].Psi_r_L = Mat3X::Zero(3, 2);
  Attachment& bent = model.joints[1].sides[index(Side::child)];
  ASSERT_EQ(bent.body, 1);
  bent.Psi_t_L.resize(3, 2);
  bent.Psi_r_L.resize(3, 2);
  bent.Psi_t_L << 0.1, 0.3, -0.4, 0.2, 0.6, -0.1;
  bent.Psi_r_L << 0.9, -0.3, 0.2, 0.8, -0.5, 0.4;
  const auto poses = guess_poses(model);
  Joint as_bent = model.joints[1];
  Attachment& there = as_bent.sides[index(Side::child)];
  const Vec3 theta = bent.Psi_r_L * model.bodies[1].a_start;
  ASSERT_GT(theta.norm(), 1.5);
  there.point_L += bent.Psi_t_L * model.bodies[1].a_start;
  there.C = Eigen::AngleAxisd(theta.norm(), theta.normalized()).toRotationMatrix() * bent.C;
  const Pose cylindrical = measured(as_bent, poses);
  EXPECT_LT((cylindrical.r - Vec3(0.0, 0.0, 0.25)).norm(), 1e-14);
  EXPECT_LT((cylindrical.A - rotation_about(Axis::z, 1.2)).norm(), 1e-14);
}

TEST(Model, AGuessOfABodysPoseIsTakenAsItIs) {
  Model model = chain_of_three();
  const Pose guess{{1.0, 2.0, 3.0}, rotation_about(Axis::y, 0.4)};
  model.bodies[2].pose_guess = guess;
  const auto poses = guess_poses(model);
  EXPECT_EQ(poses[2].r, guess.r);
  EXPECT_EQ(poses[2].A, guess.A);
  EXPECT_LT(measured(model.joints[2], poses).r.norm(), 1e-14);
}

TEST(Model, ADriverSaysWhereItsCoordinateStarts) {
  Model model = chain_of_three();
  model.joints[0].drivers = {{1, ConstantSpeed{0.9, 3.0}}};
  const Pose universal = measured(model.joints[0], guess_poses(model));
  EXPECT_LT((universal.A - rotation_about(Axis::x, 0.6) * rotation_about(Axis::y, 0.9)).norm(), 1e-14);
}

TEST(Model, AJointThatSaysNothingIsBelievedLast) {
  Model model = chain_of_three();
  // Closes the loop from ground to body 3 and stands first in the file, without a start value.
  model.joints.insert(model.joints.begin(),
                      connect("revolute", attach(kGround, {5.0, 5.0, 5.0}, 0.0), attach(3, {0.0, 0.0, 0.0}, 0.7),
                              {value(StartRole::unsaid, {0.0})}));
  const auto poses = guess_poses(model);
  EXPECT_LT(measured(model.joints[3], poses).r.norm(), 1e-14);
  EXPECT_GT(measured(model.joints[0], poses).r.norm(), 1.0);
}

TEST(Model, WordsKnowWhereTheirNumbersStand) {
  const joints::JointType& free = *joints::find("free");
  EXPECT_EQ(first_q(free, 0), 0);
  EXPECT_EQ(first_q(free, 3), 3);
  EXPECT_EQ(first_u(free, 3), 3);
  EXPECT_EQ(first_q(free, 4), 7);
  EXPECT_EQ(first_u(free, 4), 6);
}

TEST(Model, DriversAreFoundByTheirWord) {
  Joint joint = connect("cylindrical", attach(0, Vec3::Zero(), 0.0), attach(1, Vec3::Zero(), 0.0), {});
  joint.drivers = {{1, Harmonic{0.0, 1.0, 2.0, 0.0}}};
  EXPECT_EQ(driver_of(joint, 0), nullptr);
  EXPECT_EQ(driver_of(joint, 1), &joint.drivers[0]);
}

TEST(Model, LengthScaleIsTheLargestDistanceOfJointPointsOfABody) {
  EXPECT_EQ(Model{}.length_scale(), 1.0);
  const Model model = chain_of_three();
  EXPECT_DOUBLE_EQ(model.length_scale(), (Vec3(0.2, 0.2, 0.5) - Vec3(0.0, -0.6, 0.1)).norm());
}

TEST(Model, LengthScaleWhereNoBodyHasTwoPlacesGrowsWithTheMachine) {
  const auto of_size = [](double size) {
    Model model;
    model.bodies.resize(2);
    model.bodies[1].mass = 2.0;
    model.bodies[1].center_of_mass_L = size * Vec3(0.3, 0.0, 0.4);
    model.bodies[1].inertia_L = size * size * Mat3::Identity();
    model.joints = {connect("knife_edge", attach(0, Vec3::Zero(), 0.0), attach(1, Vec3::Zero(), 0.0), {})};
    return model;
  };
  EXPECT_DOUBLE_EQ(of_size(1.0).length_scale(), std::sqrt(0.75));  // the radius of gyration, sqrt(tr I / 2 m)
  EXPECT_EQ(of_size(0x1p20).length_scale(), 0x1p20 * of_size(1.0).length_scale());
  EXPECT_EQ(of_size(0x1p-20).length_scale(), 0x1p-20 * of_size(1.0).length_scale());
}

TEST(Model, LengthScaleIsNoRoundOffOfAPlaceThatIsStatedTwice) {
  Model model;
  model.bodies.resize(2);
  model.bodies[1].mass = 2.0;
  model.bodies[1].inertia_L = 0.002 * Mat3::Identity();
  const auto hinge_at = [](const Vec3& point) {
    return connect("revolute", attach(0, Vec3::Zero(), 0.0), attach(1, point, 0.0), {});
  };
  model.joints = {hinge_at({0.0, 0.11, 0.0}), hinge_at({7e-18, 0.11 - 1e-17, 0.0})};
  EXPECT_DOUBLE_EQ(model.length_scale(), 0.11);
  model.joints = {hinge_at(Vec3::Zero()), hinge_at({1e-17, 0.0, 0.0})};
  EXPECT_DOUBLE_EQ(model.length_scale(), std::sqrt(0.5 * 0.006 / 2.0));
  model.joints = {hinge_at({0.0, 0.11, 0.0}), hinge_at({0.0, 0.11 + 1e-9, 0.0})};
  EXPECT_NEAR(model.length_scale(), 1e-9, 1e-15);
}

TEST(Model, LengthScaleOfABodyOnALinkWithoutMassIsTheLinks) {
  Model model;
  model.bodies.resize(2);
  model.bodies[1].mass = 2.0;
  model.bodies[1].inertia_L = 1e-4 * Mat3::Identity();
  Joint joint = connect("distance", attach(0, Vec3::Zero(), 0.0), attach(1, Vec3::Zero(), 0.0), {});
  const joints::JointType type = joint.type->with_parameters({0.85});
  joint.type = &type;
  model.joints = {joint};
  EXPECT_EQ(model.length_scale(), 0.85);
}

TEST(Model, AFreeJointCarriesNothingUnlessSomethingActsInIt) {
  const auto with = [](const char* type) {
    Model model = chain_of_three();
    model.joints.push_back(connect(type, attach(0, Vec3::Zero(), 0.0), attach(3, Vec3::Zero(), 0.3), {}));
    return model;
  };
  Model model = with("free");
  EXPECT_TRUE(model.carries_nothing(3));
  EXPECT_FALSE(model.carries_nothing(2));
  Coupling coupling;
  coupling.terms = {{.joint = 2, .word = 0, .factor = 1.0}, {.joint = 1, .word = 0, .factor = 1.0}};
  model.couplings = {coupling};
  EXPECT_TRUE(model.carries_nothing(3)) << "coupled are others";
  model.couplings.front().terms[1].joint = 3;
  EXPECT_FALSE(model.carries_nothing(3));
  model = with("free");
  model.joints[3].drivers = {{0, ConstantSpeed{}}};
  EXPECT_FALSE(model.carries_nothing(3));
  model = with("free");
  model.joints[3].springs = {{0, ForceLaw{}}};
  EXPECT_FALSE(model.carries_nothing(3));
  joints::JointType rolls_anywhere = *joints::find("free");
  rolls_anywhere.forbids_speeds = {joints::NoSlip{.axis_of = Side::parent, .axis = Axis::x}};
  model = with("free");
  model.joints[3].type = &rolls_anywhere;
  EXPECT_FALSE(model.carries_nothing(3));
}

TEST(Model, IsFlexibleIfABodyHasModes) {
  Model model = chain_of_three();
  EXPECT_FALSE(model.is_flexible());
  model.bodies[2].modal.emplace();
  EXPECT_TRUE(model.is_flexible());
}

}  // namespace
}  // namespace concord
