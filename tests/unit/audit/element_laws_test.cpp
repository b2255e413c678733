#include "compare/audit/element_laws.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "common/rotation.h"

namespace concord::compare {
namespace {

/// Two bodies in general position, the second flexible with two modes, both moving.
struct LawBench {
  State state;
  std::array<Attachment, 2> ends;

  LawBench() {
    state.t = 0.3;
    state.bodies.resize(3);
    state.bodies[0].a = state.bodies[0].adot = VecX(0);
    set(1, {0.3, -0.2, 0.5}, {1, 2, 2}, 0.7, 0);
    set(2, {1.1, 0.4, -0.2}, {2, -1, 2}, -0.9, 2);
    ends[0] = {1, Vec3(0.2, 0.1, -0.3), rotation_about(Vec3(2, 2, 1) / 3.0, 0.4)};
    ends[1] = {2, Vec3(-0.1, 0.3, 0.2), rotation_about(Vec3(1, -2, 2) / 3.0, -0.5), Mat3X(3, 2), Mat3X(3, 2)};
    ends[1].Psi_t_L << 0.3, -0.1, 0.2, 0.5, -0.4, 0.1;
    ends[1].Psi_r_L << -0.6, 0.3, 0.2, 0.7, 0.5, -0.2;
  }

  void set(int body, const Vec3& r, const Vec3& axis, double angle, int n_modes) {
    BodyState& one = state.bodies[body];
    one.r = r;
    const Eigen::Quaterniond turned(Eigen::AngleAxisd(angle, axis.normalized()));
    one.p << turned.w(), turned.vec();
    one.v = Vec3(0.4, -0.7, 0.2) * body;
    one.omega = Vec3(-0.3, 0.8, 0.5) / body;
    one.a = VecX::LinSpaced(n_modes, 0.1, -0.15);
    one.adot = VecX::LinSpaced(n_modes, -0.4, 0.3);
  }

  /// The state a little later, moved along its own velocities.
  [[nodiscard]] State after(double step) const {
    State moved = state;
    for (BodyState& body : moved.bodies) {
      body.r += step * body.v;
      const Eigen::Quaterniond turn(exponential_of(step * body.omega));
      const Eigen::Quaterniond turned = turn * Eigen::Quaterniond(body.p(0), body.p(1), body.p(2), body.p(3));
      body.p << turned.w(), turned.vec();
      body.a += step * body.adot;
    }
    return moved;
  }

  [[nodiscard]] RelativeMotion motion(const State& at) const {
    return relative_motion(place(ends[0], at.bodies[1]), place(ends[1], at.bodies[2]));
  }

  /// Power of the wrenches on both ends along the velocities of the state.
  [[nodiscard]] double power(const ForceElement& element) const {
    const auto wrenches = wrenches_by_laws(element, state, 0);
    double sum = 0.0;
    for (const Side side : {Side::parent, Side::child}) {
      const PlacedFrame end = place(ends[index(side)], state.bodies[ends[index(side)].body]);
      sum += wrenches[index(side)].force.dot(end.v_P) + wrenches[index(side)].torque.dot(end.omega_joint);
    }
    return sum;
  }

  /// Rate of a function of the state along its velocities, by differences.
  template <class Function>
  [[nodiscard]] double rate(const Function& function) const {
    const double h = 1e-4;
    const auto slope = [&](double step) { return (function(after(step)) - function(after(-step))) / (2.0 * step); };
    return (4.0 * slope(0.5 * h) - slope(h)) / 3.0;
  }
};

TEST(Places, RelativeVelocityIsTheRateOfTheRelativePlace) {
  const LawBench bench;
  const RelativeMotion now = bench.motion(bench.state);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(bench.rate([&](const State& at) { return bench.motion(at).d(axis); }), now.v_rel(axis), 1e-10);
  }
  const auto turned = [&](const State& at) -> Vec3 {
    return rotation_vector_of(bench.motion(at).R * now.R.transpose());
  };
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(bench.rate([&](const State& at) { return turned(at)(axis); }), now.v_rel(3 + axis), 1e-10);
  }
}

TEST(Places, RotationVectorsInvertTheExponential) {
  for (const double size : {0.0, 1e-12, 1e-5, 0.3, 3.1}) {
    const Vec3 theta = size * Vec3(2, -1, 2) / 3.0;
    EXPECT_LT((rotation_vector_of(exponential_of(theta)) - theta).norm(), 1e-14);
  }
}

TEST(ElementLaws, ALineSpringPullsByItsTensionAndItsPowerIsThatOfTheLength) {
  const LawBench bench;
  LineSpring spring{bench.ends, {}};
  spring.law.stiffness = 30.0;
  spring.law.damping = 2.0;
  spring.law.free = 0.4;
  spring.law.actuator = ConstantSpeed{1.5, 0.0};
  const auto length = [&](const State& at) { return bench.motion(at).d.norm(); };
  const double rate = bench.rate(length);
  const double tension = 30.0 * (length(bench.state) - 0.4) + 2.0 * rate + 1.5;
  EXPECT_NEAR(bench.power({"strut", spring, {}}), -tension * rate, 1e-9);
  const auto wrenches = wrenches_by_laws({"strut", spring, {}}, bench.state, 0);
  EXPECT_NEAR(wrenches[1].force.norm(), std::abs(tension), 1e-9);
  EXPECT_GT(tension, 0.0);
  const Vec3 from_parent =
      place(bench.ends[1], bench.state.bodies[2]).r_P - place(bench.ends[0], bench.state.bodies[1]).r_P;
  EXPECT_LT(wrenches[1].force.dot(from_parent), 0.0) << "tension pulls the child towards the parent";
}

TEST(ElementLaws, ALineSpringWhoseEndsMeetActsAlongTheirVelocity) {
  Model model;
  model.bodies.resize(2);
  State state;
  state.bodies.resize(2);
  state.bodies[1].v = Vec3(0.3, -0.4, 1.2);
  LineSpring spring;
  spring.ends[1].body = 1;
  spring.law.stiffness = 30.0;
  spring.law.damping = 2.0;
  const auto force = [&] { return wrenches_by_laws({"strut", spring, {}}, state, 0)[1].force; };
  EXPECT_LT((force() + 2.0 * state.bodies[1].v).norm(), 1e-15);
  state.bodies[1].v.setZero();
  EXPECT_EQ(force().norm(), 0.0);
}

TEST(ElementLaws, ATurnSpringsPowerIsThatOfItsAngleThoughTheAxesDoNotCoincide) {
  const LawBench bench;
  TurnSpring spring{bench.ends, {}};
  spring.law.stiffness = 5.0;
  spring.law.damping = 0.7;
  spring.law.free = -0.2;
  spring.law.actuator = ConstantSpeed{-0.4, 0.0};
  const auto angle = [&](const State& at) {
    const Vec3 x = bench.motion(at).R.col(0);
    return std::atan2(x(1), x(0));
  };
  const double rate = bench.rate(angle);
  const double resistance = 5.0 * (angle(bench.state) + 0.2) + 0.7 * rate - 0.4;
  EXPECT_NEAR(bench.power({"coil", spring, {}}), -resistance * rate, 1e-9);
  EXPECT_EQ(wrenches_by_laws({"coil", spring, {}}, bench.state, 0)[1].force.norm(), 0.0);
}

TEST(ElementLaws, ATurnSpringIsOnTheTurnThatTheStateSays) {
  LawBench bench;
  TurnSpring spring{bench.ends, {}};
  spring.law.stiffness = 5.0;
  const auto torque = [&] { return wrenches_by_laws({"coil", spring, {}}, bench.state, 1)[1].torque; };
  const Vec3 x = bench.motion(bench.state).R.col(0);
  const double angle = std::atan2(x(1), x(0));
  const Vec3 unwound = torque();
  for (const int turns : {-2, 0, 3}) {
    const double counted = angle + 2.0 * M_PI * turns;
    for (const double off : {-3.0, 3.0}) {
      bench.state.spring_angles = {0.0, counted + off};
      EXPECT_LT((torque() - counted / angle * unwound).norm(), 1e-12 * torque().norm()) << turns;
    }
  }
}

TEST(ElementLaws, ABushingsPowerIsWhatItsEnergyLosesAndItsDampersTake) {
  const LawBench bench;
  Bushing bushing;
  bushing.ends = bench.ends;
  Mat6 root;
  for (int k = 0; k < 36; ++k) root(k / 6, k % 6) = std::sin(1.0 + k * k);
  bushing.stiffness = root * root.transpose();
  bushing.damping = 0.1 * bushing.stiffness + 0.2 * Mat6::Identity();
  bushing.preload << 3, -2, 1, 0.5, -0.7, 0.3;
  const auto energy = [&](const State& at) {
    const RelativeMotion motion = bench.motion(at);
    Vec6 offset;
    offset << motion.d, rotation_vector_of(motion.R);
    return 0.5 * offset.dot(bushing.stiffness * offset) - bushing.preload.dot(offset);
  };
  const Vec6 v_rel = bench.motion(bench.state).v_rel;
  EXPECT_NEAR(bench.power({"rubber", bushing, {}}), -bench.rate(energy) - v_rel.dot(bushing.damping * v_rel), 1e-8);
}

TEST(ElementLaws, ALoadKnowsItsAxes) {
  const LawBench bench;
  const Vec3 force(1.0, -2.0, 0.5);
  const Vec3 torque(0.3, 0.1, -0.2);
  const auto on_child = [&](LoadAxes axes) {
    const Load load{bench.ends[1], axes, force, torque, Polynomial{{2.0, 1.0}}};
    const auto wrenches = wrenches_by_laws({"push", load, {}}, bench.state, 0);
    EXPECT_EQ(wrenches[0].vector().norm(), 0.0);
    return wrenches[1];
  };
  const Mat3 A = rotation_of(bench.state.bodies[2].p);
  EXPECT_LT((on_child(LoadAxes::global).force - 2.3 * force).norm(), 1e-14);
  EXPECT_LT((on_child(LoadAxes::body).torque - 2.3 * A * torque).norm(), 1e-14);
  const Mat3 frame = place(bench.ends[1], bench.state.bodies[2]).A_joint;
  EXPECT_LT((on_child(LoadAxes::follower).force - 2.3 * frame * force).norm(), 1e-14);
  EXPECT_GT((frame - A).norm(), 0.1);
}

}  // namespace
}  // namespace concord::compare
