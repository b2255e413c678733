#include "cartesian/forces/applied_forces.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <functional>
#include <memory>

#include "cartesian/dynamics/equations.h"
#include "cartesian/forces/joint_springs.h"
#include "cartesian/rank/closing.h"
#include "common/error.h"
#include "common/joints/catalogue.h"
#include "machines.h"

namespace concord::cartesian {
namespace {

using testing::Numbers;

ForceLaw spring_and_damper(double stiffness, double damping, double free) {
  ForceLaw law;
  law.stiffness = stiffness;
  law.damping = damping;
  law.free = free;
  return law;
}

/// Two flexible bodies that a free joint and one element connect, somewhere and in motion.
struct Pushed {
  Model model;
  Layout layout;
  std::unique_ptr<Constraints> constraints;
  AppliedForces applied;
  VecX q;
  VecX Y;

  explicit Pushed(Model stated)
      : model(std::move(stated)), layout(model), constraints(Constraints::make(model, layout)), applied(model, layout) {
    Numbers numbers(4242);
    q = numbers.matrix(layout.n_q(), 1, 0.3);
    layout.normalize(q);
    Y = numbers.matrix(layout.n_Y(), 1, 1.5);
  }

  const AppliedForce& act(const VecX& at, double t = 0.3) {
    applied.update(constraints->place(at).move(Y), t, at, Y);
    return applied.applied_forces()[AppliedForceIndex(0)];
  }

  VecX forces(const VecX& at) {
    act(at);
    VecX sum = VecX::Zero(layout.n_Y());
    applied.add_to(sum);
    return sum;
  }
};

Model two_bodies_with(const std::function<ForceElement(Numbers&, const Model&)>& element) {
  Model model = testing::make_pair(77, *joints::find("free"), 2, 1);
  Numbers numbers(79);  // ends that a bushing can join: turned by less than 175 deg
  model.elements.push_back(element(numbers, model));
  return model;
}

std::array<Attachment, 2> both_ends(Numbers& numbers, const Model& model) {
  return {testing::make_attachment(numbers, model, 1), testing::make_attachment(numbers, model, 2)};
}

/// Q against the slope of -energy, energy computed from the ends' markers alone.
void expect_conservative(Pushed& rig, const std::function<double(const AppliedForce&)>& energy) {
  constexpr double kStep = 1e-5;
  const VecX forces = rig.forces(rig.q);
  ASSERT_GT(forces.norm(), 1.0);
  for (const BodyIndex i : rig.layout.moving_bodies()) {
    for (int c = 0; c < rig.layout.size_Y(i); ++c) {
      const auto energy_at = [&](double size) {
        VecX moved = rig.q;
        rig.layout.displace_along(i, c, size, moved);
        return energy(rig.act(moved));
      };
      // Fourth order.
      const double slope =
          (8.0 * (energy_at(kStep) - energy_at(-kStep)) - energy_at(2 * kStep) + energy_at(-2 * kStep)) /
          (12.0 * kStep);
      EXPECT_NEAR(forces(rig.layout.first_Y(i) + c), -slope, 1e-7 * forces.norm()) << "body " << i.value << ", " << c;
    }
  }
}

TEST(AppliedForces, LineSpringFollowsFromItsEnergy) {
  Pushed rig(two_bodies_with([](Numbers& numbers, const Model& model) {
    return ForceElement{"strut", LineSpring{both_ends(numbers, model), spring_and_damper(300.0, 0.0, 0.4)}, {}};
  }));
  expect_conservative(rig, [](const AppliedForce& applied) {
    const double length = (applied.markers[1].point - applied.markers[0].point).norm();
    return 0.5 * 300.0 * (length - 0.4) * (length - 0.4);
  });
}

TEST(AppliedForces, TurnSpringFollowsFromItsEnergyWhereAxesDoNotCoincide) {
  Pushed rig(two_bodies_with([](Numbers& numbers, const Model& model) {
    return ForceElement{"torsion", TurnSpring{both_ends(numbers, model), spring_and_damper(50.0, 0.0, 0.2)}, {}};
  }));
  expect_conservative(rig, [](const AppliedForce& applied) {
    const Mat3 R = applied.markers[0].A_joint.transpose() * applied.markers[1].A_joint;
    const double angle = std::atan2(R(1, 0), R(0, 0));
    return 0.5 * 50.0 * (angle - 0.2) * (angle - 0.2);
  });
}

TEST(AppliedForces, BushingWithFullStiffnessAndPreloadFollowsFromItsEnergy) {
  Numbers numbers(5);
  const Mat6 root = numbers.matrix(6, 6);
  const Mat6 stiffness = 100.0 * (root * root.transpose());
  const Vec6 preload = numbers.matrix(6, 1, 30.0);
  Pushed rig(two_bodies_with([&](Numbers& own, const Model& model) {
    return ForceElement{"rubber", Bushing{both_ends(own, model), stiffness, Mat6::Zero(), preload}, {}};
  }));
  expect_conservative(rig, [&](const AppliedForce& applied) {
    const Mat3& A_parent = applied.markers[0].A_joint;
    const Eigen::AngleAxisd turn(Mat3(A_parent.transpose() * applied.markers[1].A_joint));
    Vec6 z;
    z << A_parent.transpose() * (applied.markers[1].point - applied.markers[0].point), turn.angle() * turn.axis();
    return 0.5 * z.dot(stiffness * z) - preload.dot(z);
  });
}

TEST(AppliedForces, DampersTakeTheirPower) {
  Pushed strut(two_bodies_with([](Numbers& numbers, const Model& model) {
    return ForceElement{"strut", LineSpring{both_ends(numbers, model), spring_and_damper(0.0, 7.0, 0.0)}, {}};
  }));
  const AppliedForce& ends = strut.act(strut.q);
  const Vec3 along = (ends.markers[1].point - ends.markers[0].point).normalized();
  const double rate = along.dot(ends.markers[1].velocity - ends.markers[0].velocity);
  EXPECT_NEAR(strut.applied.power(strut.Y), -7.0 * rate * rate, 1e-12 * 7.0 * rate * rate);

  Mat6 damping = Mat6::Zero();
  damping.diagonal() << 3.0, 4.0, 5.0, 0.6, 0.7, 0.8;
  Pushed rubber(two_bodies_with([&](Numbers& numbers, const Model& model) {
    return ForceElement{"rubber", Bushing{both_ends(numbers, model), Mat6::Zero(), damping, Vec6::Zero()}, {}};
  }));
  const AppliedForce& applied = rubber.act(rubber.q);
  Vec6 v_rel;
  v_rel << applied.motion.ddot, applied.motion.omega;
  const double lost = v_rel.dot(damping * v_rel);
  EXPECT_NEAR(rubber.applied.power(rubber.Y), -lost, 1e-12 * lost);
}

TEST(AppliedForces, LoadIsSaidInGlobalBodyOrFollowingAxes) {
  const Vec3 force(3.0, -1.0, 2.0);
  const Vec3 torque(0.4, 0.7, -0.2);
  for (const LoadAxes axes : {LoadAxes::global, LoadAxes::body, LoadAxes::follower}) {
    Pushed rig(two_bodies_with([&](Numbers& numbers, const Model& model) {
      return ForceElement{
          "push", Load{testing::make_attachment(numbers, model, 1), axes, force, torque, ConstantSpeed{0.0, 10.0}}, {}};
    }));
    const AppliedForce& applied = rig.act(rig.q);
    const Marker& marker = applied.markers[1];
    const Mat3 A = axes == LoadAxes::global ? Mat3(Mat3::Identity())
                   : axes == LoadAxes::body ? rig.constraints->place(rig.q).rotation(BodyIndex(1))
                                            : marker.A_joint;
    EXPECT_LE((applied.wrenches[1].force - 3.0 * A * force).norm(), 1e-13);  // the law is 10 t, t = 0.3 s
    EXPECT_LE((applied.wrenches[1].torque - 3.0 * A * torque).norm(), 1e-13);
    const double power =
        applied.wrenches[1].force.dot(marker.velocity) + applied.wrenches[1].torque.dot(marker.angular_velocity);
    EXPECT_NEAR(rig.applied.power(rig.Y), power, 1e-12 * std::abs(power));
  }
}

TEST(AppliedForces, TurnSpringCountsTurnsFromWhatTheStateSays) {
  Pushed rig(two_bodies_with([](Numbers& numbers, const Model& model) {
    return ForceElement{"torsion", TurnSpring{both_ends(numbers, model), spring_and_damper(50.0, 0.0, 0.2)}, {}};
  }));
  const auto torque = [&] { return rig.act(rig.q).wrenches[index(Side::child)].torque; };
  const Vec3 unwound = torque();
  const MovingConstraints& at = rig.constraints->place(rig.q).move(rig.Y);
  const double angle = rig.applied.spring_angles(at, rig.q, rig.Y).at(0);
  EXPECT_LT(std::abs(angle), EIGEN_PI);
  constexpr double kWholeTurn = 2.0 * EIGEN_PI;
  const Vec3 of_a_radian = unwound / (angle - 0.2);
  for (const int turns : {-3, 0, 2}) {
    for (const double off : {-3.1, 0.0, 3.1}) {
      State known;
      known.spring_angles = {angle + kWholeTurn * turns + off};
      rig.applied.count_spring_turns_from(known);
      const double counted = angle + kWholeTurn * turns;
      EXPECT_LT((torque() - (counted - 0.2) * of_a_radian).norm(), 1e-12 * torque().norm()) << turns << ", " << off;
      EXPECT_NEAR(rig.applied.spring_angles(at, rig.q, rig.Y).at(0), counted, 1e-13);
      rig.applied.follow_spring_turns();
      EXPECT_NEAR(rig.applied.applied_forces()[AppliedForceIndex(0)].known_angle, counted, 1e-13);
    }
  }
}

TEST(AppliedForces, SpringOnEveryCoordinateOfEveryTypePushesItAndCountsTurns) {
  for (const joints::JointType* type : joints::catalogue()) {
    for (std::size_t word = 0; word < type->permits.size(); ++word) {
      if (joints::n_q(type->permits[word]) != 1) continue;
      SCOPED_TRACE(type->name + ", word " + std::to_string(word));
      Model model = testing::make_pair(31, *type, 2, 1);
      model.joints.front().springs.push_back({static_cast<int>(word), spring_and_damper(20.0, 3.0, 0.1)});
      model.joints.front().springs.front().law.actuator = ConstantSpeed{0.7, 1.3};
      Equations equations(model);
      Numbers numbers(32);
      VecX q;
      VecX Y;
      bool closed = false;
      for (int guess = 0; guess < 10 && !closed; ++guess) {  // a guess far off may end on the branch of turned axes
        q = numbers.matrix(equations.layout().n_q(), 1, 0.3);
        Y = numbers.matrix(equations.layout().n_Y(), 1, 1.5);
        closed = close_machine(equations, 0.0, Hold::constraints, Modes::kept, q, Y).closed;
      }
      ASSERT_TRUE(closed);
      equations.update(0.0, q, Y);
      const RelativeMotion& motion = equations.moving_constraints().joint(JointIndex(0)).motion;
      const joints::Read& read = *read_of(*type, static_cast<int>(word));
      const ConstraintRow row = evaluate_read(read, 0, motion);
      const double rate = row.over_d.dot(motion.ddot) + row.over_rho.dot(motion.omega);
      const double turns = reads_turn(read, 0) ? 4.0 * EIGEN_PI : 0.0;
      VecX known = VecX::Zero(type->n_q());
      known(first_q(*type, static_cast<int>(word))) = row.value + turns + 0.5;
      equations.applied().count_turns_from({known});
      equations.update(0.0, q, Y);
      const double at_rest = -20.0 * (row.value + turns - 0.1);
      const double tau = 0.7 + at_rest - 3.0 * rate;
      const AppliedForce& springs = *equations.applied().springs_of(JointIndex(0));
      const int u = first_u(*type, static_cast<int>(word));
      EXPECT_NEAR(springs.tau(u), tau, 1e-11 * std::abs(tau));
      std::array<VecX, kActors.size()> shares;
      shares.fill(VecX::Zero(type->n_u()));
      const JointEquations& joint = equations.moving_constraints().joint(JointIndex(0));
      add_spring_shares(model.joints.front(), joint, 0.0, springs, shares);
      EXPECT_NEAR(shares[index(Actor::motor)](u), 0.7, 1e-15);
      EXPECT_NEAR(shares[index(Actor::spring)](u), at_rest, 1e-11 * std::abs(at_rest));
      EXPECT_NEAR(shares[index(Actor::damper)](u), -3.0 * rate, 1e-11 * (std::abs(at_rest) + std::abs(rate)));
      EXPECT_NEAR(equations.applied().power(Y), tau * rate, 1e-10 * (1.0 + std::abs(tau)));
    }
  }
}

/// Event functions that read the angles of an arm from the wrong side find a stop outside the regime that it has just
/// taken.
TEST(AppliedForces, EventsOfSpringsKnowTheSideThatAnArmStandsOn) {
  Model model = testing::make_pair(33, *joints::find("universal_spherical"), 2, 1);
  for (const int word : {0, 1}) {
    JointSpring spring{word, spring_and_damper(20.0, 3.0, 0.1)};
    spring.law.upper = SmoothStop{.at = 1.6, .stiffness = 50.0, .damping = 0.0, .width = 1e-3};
    spring.law.lower = SmoothStop{.at = -1.6, .stiffness = 50.0, .damping = 0.0, .width = 1e-3};
    model.joints.front().springs.push_back(spring);
  }
  Pushed rig(model);
  for (const double elevation : {0.4, 2.4}) {
    SCOPED_TRACE(elevation);
    VecX known = VecX::Zero(6);
    known(1) = elevation;
    known(2) = 1.0;
    rig.constraints->count_turns_from({known});
    rig.applied.count_turns_from({known});
    rig.act(rig.q);
    const AppliedForce& springs = *rig.applied.springs_of(JointIndex(0));
    EXPECT_EQ(springs.stop_regimes[1].upper, elevation > 1.6 ? StopRegime::full : StopRegime::off);
    EXPECT_GE(rig.applied.event_functions(rig.constraints->place(rig.q), 0.3, rig.q, rig.Y).minCoeff(), 0.0);
  }
}

TEST(AppliedForces, RefusesWhereALawHasNoDirection) {
  Model model = testing::make_pair(11, *joints::find("free"), 0, 0);
  const Attachment at_origin{1, Vec3::Zero(), Mat3::Identity(), Mat3X(3, 0), Mat3X(3, 0)};
  const Attachment on_ground{kGround, Vec3::Zero(), Mat3::Identity(), Mat3X(3, 0), Mat3X(3, 0)};
  double turned = 177.0;  // deg
  const auto refusal = [&](const ForceElement& element) {
    model.elements = {element};
    Pushed rig(model);
    rig.q.setZero();
    const double half = turned / 2.0 * EIGEN_PI / 180.0;
    rig.layout.p(rig.q, BodyIndex(1)) = Vec4(std::cos(half), 0.0, 0.0, std::sin(half));
    rig.layout.p(rig.q, BodyIndex(2)) = Vec4(1.0, 0.0, 0.0, 0.0);
    try {
      rig.act(rig.q);
    } catch (const SolverError& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  ForceLaw pushing;
  pushing.preload = 3.0;
  EXPECT_EQ(refusal({"strut", LineSpring{{on_ground, at_origin}, pushing}, {}}),
            "cartesian: at t = 0.3 s the ends of line spring 'strut' meet: its force has no direction there");
  Attachment beside_origin = at_origin;
  beside_origin.point_L.x() = 1e-10 * model.length_scale();
  EXPECT_EQ(refusal({"short", LineSpring{{on_ground, beside_origin}, pushing}, {}}),
            "cartesian: at t = 0.3 s the ends of line spring 'short' meet: its force has no direction there");
  EXPECT_EQ(refusal({"torsion", TurnSpring{{on_ground, at_origin}, {}}, {}}), "nothing");
  EXPECT_EQ(
      refusal({"rubber", Bushing{{on_ground, at_origin}, Mat6::Identity(), Mat6::Zero(), Vec6::Zero()}, {}}),
      "cartesian: at t = 0.3 s bushing 'rubber' is turned by 177.0 deg, allowed are 175 deg where it resists turning");
  turned = 173.0;
  beside_origin.point_L.x() = 1e-8 * model.length_scale();
  for (const ForceElement& sound :
       {ForceElement{"short", LineSpring{{on_ground, beside_origin}, pushing}, {}},
        ForceElement{"torsion", TurnSpring{{on_ground, at_origin}, {}}, {}},
        ForceElement{"rubber", Bushing{{on_ground, at_origin}, Mat6::Identity(), Mat6::Zero(), Vec6::Zero()}, {}}}) {
    EXPECT_EQ(refusal(sound), "nothing");
  }
}

}  // namespace
}  // namespace concord::cartesian
