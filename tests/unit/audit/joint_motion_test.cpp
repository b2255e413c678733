#include "compare/audit/joint_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "common/joints/catalogue.h"
#include "common/joints/universal_spherical.h"
#include "common/rotation.h"

namespace concord::compare {
namespace {

/// Where a motion of turns, slides, arms and a ball leads, and the ball's rotation: composed anew.
RelativeMotion compose(const joints::JointType& type, const VecX& q) {
  RelativeMotion reached{Vec3::Zero(), Mat3::Identity(), Vec6::Zero()};
  int next = 0;
  for (const joints::Permit& word : type.permits) {
    if (const auto* turn = std::get_if<joints::Turn>(&word)) {
      reached.R = reached.R * rotation_about(turn->axis, q(next));
    } else if (const auto* slide = std::get_if<joints::Slide>(&word)) {
      reached.d += q(next) * reached.R.col(index(slide->axis));
    } else if (const auto* arm = std::get_if<joints::Arm>(&word)) {
      reached.d += arm->length * reached.R.col(index(arm->axis));
    } else if (std::holds_alternative<joints::Ball>(word)) {
      reached.R = Eigen::Quaterniond(q(next), q(next + 1), q(next + 2), q(next + 3)).toRotationMatrix();
    }
    next += n_q(word);
  }
  return reached;
}

VecX generic_coordinates(const joints::JointType& type) {
  VecX q(type.n_q());
  int next = 0;
  for (const joints::Permit& word : type.permits) {
    if (std::holds_alternative<joints::Ball>(word)) {
      q.segment<4>(next) = Vec4(0.8, 0.3, -0.4, 0.2).normalized();
    } else {
      for (int k = 0; k < n_q(word); ++k) q(next + k) = 0.5 - 0.17 * (next + k);
    }
    next += n_q(word);
  }
  return q;
}

bool is_by_functions(const joints::JointType& type) {
  return std::holds_alternative<joints::ByMotion>(type.permits.empty() ? joints::Permit{} : type.permits.front());
}

TEST(JointMotion, CoordinatesSpeedsAndDirectionsOfEveryTypeAreThoseOfItsMotion) {
  for (const joints::JointType* type : joints::catalogue()) {
    if (is_by_functions(*type)) continue;
    SCOPED_TRACE(type->name);
    const VecX q = generic_coordinates(*type);
    const RelativeMotion here = compose(*type, q);
    const JointMotion motion = read_motion(*type, here, q);
    EXPECT_LT((motion.q - q).norm(), 1e-14);
    const double h = 1e-6;
    int iq = 0;
    int iu = 0;
    for (const joints::Permit& word : type->permits) {
      const bool is_ball = std::holds_alternative<joints::Ball>(word);
      for (int k = 0; k < n_u(word) && !is_ball; ++k) {
        VecX plus = q;
        VecX minus = q;
        plus(iq + k) += h;
        minus(iq + k) -= h;
        const RelativeMotion a = compose(*type, plus);
        const RelativeMotion b = compose(*type, minus);
        Vec6 column;
        column << (a.d - b.d) / (2.0 * h), rotation_vector_of(a.R * b.R.transpose()) / (2.0 * h);
        EXPECT_LT((column - motion.S.col(iu + k)).norm(), 1e-9);
      }
      if (is_ball) {
        EXPECT_EQ((motion.S.block<3, 3>(3, iu)), Mat3(Mat3::Identity()));
      }
      iq += n_q(word);
      iu += n_u(word);
    }
  }
}

/// Slides, arms and leads of a third of a micrometre beside turns of a radian: round-off of one does not reach the
/// other.
TEST(JointMotion, SpeedsOfATinyJointAreReadToRoundOff) {
  constexpr double kSize = 3e-7;
  for (const joints::JointType* stated : joints::catalogue()) {
    if (is_by_functions(*stated)) continue;
    SCOPED_TRACE(stated->name);
    const joints::JointType type = stated->with_parameters != nullptr ? stated->with_parameters({kSize}) : *stated;
    if (type.n_u() == 0) continue;
    VecX q = generic_coordinates(type);
    int next = 0;
    for (const joints::Permit& word : type.permits) {
      if (std::holds_alternative<joints::Slide>(word)) q(next) *= kSize;
      next += n_q(word);
    }
    const std::vector<bool> turning = turning_speeds(type);
    VecX unit(type.n_u());
    VecX u(type.n_u());
    for (int k = 0; k < type.n_u(); ++k) {
      unit(k) = turning[static_cast<std::size_t>(k)] ? 1.0 : kSize;
      u(k) = (0.7 - 0.43 * k) * unit(k);
    }
    RelativeMotion moving = compose(type, q);
    moving.v_rel = read_motion(type, moving, q).S * u;
    const VecX found = read_motion(type, moving, q).u;
    EXPECT_LT((found - u).cwiseQuotient(unit).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(JointMotion, TurnsAreCountedFromTheHintAndSpeedsAreRead) {
  const joints::JointType& cylindrical = *joints::find("cylindrical");
  RelativeMotion moved = compose(cylindrical, Eigen::Vector2d(0.3, 0.4));
  moved.v_rel << 0, 0, 1.5, 0, 0, -2.5;
  const JointMotion motion = read_motion(cylindrical, moved, Eigen::Vector2d(0.0, 14.0));
  EXPECT_NEAR(motion.q(1), 0.4 + 4.0 * std::acos(-1.0), 1e-14);
  EXPECT_NEAR(motion.u(0), 1.5, 1e-14);
  EXPECT_NEAR(motion.u(1), -2.5, 1e-14);
}

TEST(JointMotion, ALinkIsReadOnTheBranchOfTheHint) {
  const joints::JointType type = joints::universal_spherical_of({0.35});
  const Vec3 along = rotation_about(Vec3::UnitY(), 0.6) * rotation_about(Vec3::UnitZ(), 2.1) * Vec3::UnitX();
  const RelativeMotion relative{0.35 * along, Mat3::Identity(), Vec6::Zero()};
  VecX hint(6);
  hint << 0.55, 2.0, 1.0, 0.0, 0.0, 0.0;
  const JointMotion near = read_motion(type, relative, hint);
  EXPECT_NEAR(near.q(0), 0.6, 1e-14);
  EXPECT_NEAR(near.q(1), 2.1, 1e-14);
  EXPECT_LT((near.d - relative.d).norm(), 1e-15);
  const JointMotion plain = read_motion(type, relative, VecX());
  EXPECT_NEAR(plain.q(1), std::numbers::pi - 2.1, 1e-14);
  EXPECT_LT((plain.d - relative.d).norm(), 1e-15);
}

TEST(JointMotion, LawfulTauIsActuatorMinusResistance) {
  Joint joint;
  joint.type = joints::find("cylindrical");
  JointSpring spring;
  spring.word = 1;
  spring.law.stiffness = 10.0;
  spring.law.damping = 2.0;
  spring.law.free = 0.1;
  spring.law.actuator = ConstantSpeed{3.0, 1.0};
  joint.springs = {spring};
  joint.drivers = {{0, ConstantSpeed{0.0, 1.0}}};
  const JointMotion motion{Eigen::Vector2d(0.5, 0.4), Eigen::Vector2d(1.0, -1.5), Mat6X::Zero(6, 2),
                           MatX::Identity(2, 2)};
  const VecX tau = tau_by_laws(joint, {LawOfForce(joint.springs[0].law)}, motion, 0.5);
  EXPECT_TRUE(std::isnan(tau(0)));
  EXPECT_DOUBLE_EQ(tau(1), 3.5 - 10.0 * 0.3 + 2.0 * 1.5);
}

TEST(JointMotion, SpeedsHaveNamesAndUnits) {
  const joints::JointType& free = *joints::find("free");
  EXPECT_EQ(speed_names(free),
            (std::vector<std::string>{"slide_x", "slide_y", "slide_z", "ball_x", "ball_y", "ball_z"}));
  EXPECT_EQ(turning_speeds(free), (std::vector<bool>{false, false, false, true, true, true}));
}

TEST(JointMotion, CouplingsPushEachCoordinateByItsFactor) {
  Model model;
  model.bodies.resize(3);
  model.joints.resize(2);
  model.joints[0].type = joints::find("cylindrical");
  model.joints[1].type = joints::find("revolute");
  model.couplings = {{"rack", {{0, 0, 0, 2.0}, {1, 0, 0, -0.5}}, 0.1, {}},
                     {"gear", {{0, 1, 0, 3.0}, {1, 0, 0, 7.0}}, 0.0, {}}};
  const std::vector<double> forces{4.0, 0.2};
  EXPECT_TRUE(coupled_tau(model, 0, forces).isApprox(Eigen::Vector2d(8.0, 0.6), 1e-15));
  EXPECT_NEAR(coupled_tau(model, 1, forces)(0), -2.0 + 1.4, 1e-15);
}

TEST(JointMotion, ASkateMovesAlongItsEdgeAndTurns) {
  const joints::JointType& edge = *joints::find("knife_edge");
  const Mat3 R = rotation_about(Axis::z, 0.3);
  const JointMotion motion = read_motion(edge, {Vec3(0.4, -0.2, 0.0), R, Vec6::Zero()}, {});
  ASSERT_EQ(motion.free.cols(), 2);
  EXPECT_TRUE(motion.free.col(0).isApprox(Vec3(std::cos(0.3), std::sin(0.3), 0.0), 1e-14));
  EXPECT_TRUE(motion.free.col(1).isApprox(Vec3::UnitZ(), 1e-14));
  EXPECT_EQ(turning_free_speeds(edge), (std::vector<bool>{false, true}));
}

TEST(JointMotion, ARollingBallRestsAtItsContact) {
  const joints::JointType& ball = *joints::find("rolling_ball");
  const Mat3 R = rotation_about(Axis::x, 0.7) * rotation_about(Axis::y, -0.4);
  const JointMotion motion = read_motion(ball, {Vec3(0.4, -0.2, 0.0), R, Vec6::Zero()}, {});
  const Mat6X possible = motion.S * motion.free;
  ASSERT_EQ(possible.cols(), 3);
  const Vec3 contact(0.0, 0.0, -0.25);
  for (const auto& v_rel : possible.colwise()) {
    EXPECT_LT((v_rel.head<3>() + Vec3(v_rel.tail<3>()).cross(contact)).norm(), 1e-14);
  }
}

}  // namespace
}  // namespace concord::compare
