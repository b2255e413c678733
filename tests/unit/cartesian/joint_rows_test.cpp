#include "cartesian/bodies/joint_rows.h"

#include <gtest/gtest.h>

#include "common/joints/catalogue.h"
#include "common/joints/screw.h"
#include "machines.h"

namespace concord::cartesian {
namespace {

using testing::Numbers;

/// The motion from (d, R) with constant ddot and omega, which has no accelerations of components.
RelativeMotion carried(const RelativeMotion& from, double t) {
  RelativeMotion motion = from;
  motion.d += t * from.ddot;
  motion.R = rotation_about(from.omega.normalized(), from.omega.norm() * t) * from.R;
  return motion;
}

RelativeMotion generic_motion(Numbers& numbers) {
  return {numbers.vector(), numbers.rotation(), numbers.vector(2.0), numbers.vector(2.0)};
}

/// First and second derivative of a row along the motion against differences of its value and its rate.
void expect_derivatives(const std::function<ConstraintRow(const RelativeMotion&)>& evaluate,
                        const RelativeMotion& motion) {
  const double h = 1e-5;
  const ConstraintRow row = evaluate(motion);
  const ConstraintRow after = evaluate(carried(motion, h));
  const ConstraintRow before = evaluate(carried(motion, -h));
  EXPECT_NEAR((after.value - before.value) / (2 * h), rate_of(row, motion), 3e-8);
  EXPECT_NEAR((rate_of(after, motion) - rate_of(before, motion)) / (2 * h), row.bias, 3e-7);
}

TEST(JointRows, GradientsAndBiasesOfAllThatIsForbidden) {
  Numbers numbers(17);
  for (const joints::JointType* type : joints::catalogue()) {
    SCOPED_TRACE(type->name);
    const RelativeMotion motion = generic_motion(numbers);
    for (int k = 0; k < type->rows(); ++k) {
      expect_derivatives(
          [&](const RelativeMotion& at) {
            ConstraintRow rows[kMaxRows];
            EXPECT_EQ(evaluate_forbids(*type, at, rows), type->rows());
            return rows[k];
          },
          motion);
    }
  }
}

/// By the definition: the child's material point at d - below e_z, followed for a moment.
TEST(JointRows, ForbiddenSpeedsAreTheSlipOfTheMaterialPoint) {
  Numbers numbers(18);
  int found = 0;
  for (const joints::JointType* type : joints::catalogue()) {
    for (int k = 0; k < type->nonholonomic_rows(); ++k) {
      SCOPED_TRACE(type->name);
      ++found;
      const auto& word = std::get<joints::NoSlip>(type->forbids_speeds[k]);
      const auto evaluate = [&](const RelativeMotion& at) {
        ConstraintRow rows[kMaxRows];
        EXPECT_EQ(evaluate_forbidden_speeds(*type, at, rows), type->nonholonomic_rows());
        return rows[k];
      };
      const RelativeMotion motion = generic_motion(numbers);
      const ConstraintRow row = evaluate(motion);
      const Vec3 point = motion.d - word.below * Vec3::UnitZ();
      const Vec3 in_child = motion.R.transpose() * (point - motion.d);
      const double h = 1e-5;
      const auto place = [&](double t) { return Vec3(carried(motion, t).d + carried(motion, t).R * in_child); };
      const Vec3 e = Vec3::Unit(index(word.axis));
      const Vec3 axis = word.axis_of == Side::child ? Vec3(motion.R * e) : e;
      EXPECT_NEAR(rate_of(row, motion), axis.dot(place(h) - place(-h)) / (2 * h), 1e-8);
      EXPECT_EQ(row.value, 0.0);
      const double after = rate_of(evaluate(carried(motion, h)), motion);
      const double before = rate_of(evaluate(carried(motion, -h)), motion);
      EXPECT_NEAR((after - before) / (2 * h), row.bias, 3e-7);
    }
  }
  EXPECT_GE(found, 3);
}

TEST(JointRows, GradientsAndBiasesOfAllCoordinates) {
  Numbers numbers(19);
  for (const joints::JointType* type : joints::catalogue()) {
    SCOPED_TRACE(type->name);
    for (std::size_t word = 0; word < type->reads.size(); ++word) {
      const joints::Read& read = type->reads[word];
      if (std::holds_alternative<joints::OrientationOf>(read)) continue;
      expect_derivatives([&](const RelativeMotion& at) { return evaluate_read(read, 0, at); }, generic_motion(numbers));
    }
  }
}

TEST(JointRows, OrientationVanishesAtItsTargetAndLooksLikeARotationVectorThere) {
  Numbers numbers(23);
  const Mat3 target = numbers.rotation();
  const Vec3 small = numbers.vector(1e-5);
  RelativeMotion motion;
  motion.R = rotation_about(small.normalized(), small.norm()) * target;
  ConstraintRow rows[3];
  evaluate_orientation(target, motion, rows);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(rows[k].value, small(k), 1e-14);
}

TEST(JointRows, CoordinatesOfAUniversalJointReadWhatTheMotionSays) {
  const double q1 = 1.9;
  const double q2 = -2.4;
  RelativeMotion motion;
  motion.R = rotation_about(Axis::x, q1) * rotation_about(Axis::y, q2);
  const joints::JointType& universal = *joints::find("universal");
  EXPECT_NEAR(evaluate_read(universal.reads[0], 0, motion).value, q1, 1e-15);
  EXPECT_NEAR(evaluate_read(universal.reads[1], 0, motion).value, q2, 1e-15);
}

TEST(JointRows, AnglesOfALinkReadWhatTheMotionSays) {
  const double q1 = 2.1;
  const double q2 = -0.7;
  RelativeMotion motion;
  motion.d = rotation_about(Axis::x, q1) * rotation_about(Axis::y, q2) * Vec3(0.0, 0.0, 0.4);
  const joints::JointType& distance = *joints::find("distance");
  EXPECT_NEAR(evaluate_read(distance.reads[0], 0, motion).value, q1, 1e-15);
  EXPECT_NEAR(evaluate_read(distance.reads[1], 0, motion).value, q2, 1e-15);
  motion.d = rotation_about(Axis::y, q1) * rotation_about(Axis::z, q2) * Vec3(0.4, 0.0, 0.0);
  const joints::JointType& link = *joints::find("universal_spherical");
  EXPECT_NEAR(evaluate_read(link.reads[0], 0, motion).value, q1, 1e-15);
  EXPECT_NEAR(evaluate_read(link.reads[1], 0, motion).value, q2, 1e-15);
}

TEST(JointRows, AnArmBeyondUprightReadsOnItsOwnSide) {
  RelativeMotion motion;
  const double q1 = -0.7;
  const double q2 = 2.2;  // beyond a right angle
  motion.d = rotation_about(Axis::x, q1) * rotation_about(Axis::y, q2) * Vec3(0.0, 0.0, 0.4);
  motion.ddot = Vec3(0.3, -0.5, 0.8).cross(motion.d);
  const joints::JointType& distance = *joints::find("distance");
  const ConstraintRow near_side = evaluate_read(distance.reads[1], 0, motion);
  motion.is_beyond_upright = true;
  EXPECT_NEAR(evaluate_read(distance.reads[0], 0, motion).value, q1, 1e-15);
  const ConstraintRow beyond = evaluate_read(distance.reads[1], 0, motion);
  EXPECT_NEAR(beyond.value, q2, 1e-15);
  EXPECT_EQ(rate_of(beyond, motion), -rate_of(near_side, motion));
  EXPECT_EQ(beyond.bias, -near_side.bias);
}

TEST(JointRows, AThreadCountsTurnsByItselfAndABearingDoesNot) {
  for (const double lead : {1e-140, 3e-9, 0.003, 2e5, 1e30, 1e140}) {
    EXPECT_FALSE(reads_turn(joints::screw_of({lead}).reads[0], 0)) << lead;
  }
  EXPECT_TRUE(reads_turn(joints::find("distance")->reads[0], 0));
  EXPECT_TRUE(reads_turn(joints::find("revolute")->reads[0], 0));
  EXPECT_FALSE(reads_turn(joints::find("cylindrical")->reads[0], 0));
}

TEST(JointRows, CoordinateWrenchDoesTheWorkOfItsForcesOnly) {
  Numbers numbers(29);
  for (const joints::JointType* type : joints::catalogue()) {
    if (type->n_u() == 0) continue;
    SCOPED_TRACE(type->name);
    const RelativeMotion motion = generic_motion(numbers);
    const VecX tau = VecX::Random(type->n_u());
    const Vec6 wrench = coordinate_wrench(*type, motion, tau);
    int at_u = 0;
    for (const joints::Read& read : type->reads) {
      if (std::holds_alternative<joints::OrientationOf>(read)) {
        EXPECT_LE((wrench.tail<3>() - tau.segment<3>(at_u)).norm(), 1e-14);
        at_u += 3;
        continue;
      }
      // What moves this coordinate at unit speed and no other: for slides and turns the wrench's own axis, for links
      // the motion of the link's end.
      if (std::holds_alternative<joints::BearingOfGap>(read) || std::holds_alternative<joints::ElevationOfGap>(read)) {
        const ConstraintRow row = evaluate_read(read, 0, motion);
        const Vec3 along = row.over_d / row.over_d.squaredNorm();
        EXPECT_NEAR(wrench.head<3>().dot(along), tau(at_u), 1e-13);
      }
      ++at_u;
    }
  }
}

RelativeMotion turned(const Mat3& R) {
  RelativeMotion motion;
  motion.R = R;
  return motion;
}

TEST(JointRows, BranchTellsAHingeFromItsTurnedTwin) {
  const joints::JointType& revolute = *joints::find("revolute");
  const joints::JointType& weld = *joints::find("weld");
  EXPECT_TRUE(on_branch(revolute, turned(rotation_about(Axis::z, 2.0))));
  EXPECT_FALSE(on_branch(revolute, turned(rotation_about(Axis::x, EIGEN_PI))));
  EXPECT_TRUE(on_branch(weld, turned(Mat3::Identity())));
  EXPECT_FALSE(on_branch(weld, turned(rotation_about(Axis::y, EIGEN_PI))));
}

}  // namespace
}  // namespace concord::cartesian
