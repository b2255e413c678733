#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "cartesian/bodies/euler_parameters.h"
#include "cartesian/forces/applied_forces.h"
#include "cartesian/solver.h"
#include "common/error.h"
#include "common/joints/catalogue.h"
#include "common/reading/model_file.h"
#include "machines.h"

/// Tires: the statement in common/elements/tire.h against the definitions of its words, and runs over events.
namespace concord::cartesian {
namespace {

using ::testing::HasSubstr;
using testing::kGravity;
using testing::Numbers;
using testing::rigid;

Tire make_tire(const Attachment& wheel, const Road& road) {
  Tire tire;
  tire.wheel = wheel;
  tire.road = std::make_shared<Road>(road);
  tire.radius = 2.5;
  tire.stiffness = 300.0;
  tire.damping = 7.0;
  tire.slip_stiffness = 11.0;
  tire.cornering_stiffness = 17.0;
  tire.friction = 0.9;
  return tire;
}

/// A wheel on a flexible body above the flank of a bump.
struct WheelRig {
  Model model;
  Layout layout;
  std::unique_ptr<Constraints> constraints;
  AppliedForces applied;
  VecX q;
  VecX Y;

  WheelRig() : model(make()), layout(model), constraints(Constraints::make(model, layout)), applied(model, layout) {
    Numbers numbers(231);
    q = numbers.matrix(layout.n_q(), 1, 0.3);
    layout.normalize(q);
    Y = numbers.matrix(layout.n_Y(), 1, 1.5);
  }

  static Model make() {
    Model model = testing::make_pair(232, *joints::find("free"), 2, 3);
    Numbers numbers(233);
    const Road bump{"bump", HalfSineBump{-6.0, 11.0, 0.8}};
    model.elements.push_back({"tire", make_tire(testing::make_attachment(numbers, model, 2), bump), {}});
    return model;
  }

  const AppliedForce& act(const VecX& at) {
    applied.update(constraints->place(at).move(Y), 0.0, at, Y);
    return applied.applied_forces()[AppliedForceIndex(0)];
  }

  [[nodiscard]] VecX carried(double t) const {
    VecX moved = q;
    for (const BodyIndex i : layout.moving_bodies()) {
      const Vec3 omega = layout.omega(Y, i);
      layout.r(moved, i) += t * layout.v(Y, i);
      layout.p(moved, i) =
          euler_parameters_of(rotation_about(omega.normalized(), omega.norm() * t) * rotation_of(layout.p(q, i)));
      layout.a(moved, i) += t * layout.adot(Y, i);
    }
    return moved;
  }
};

TEST(Tires, WrenchAtTheCentreFollowsFromTheStatement) {
  WheelRig rig;
  const auto& tire = std::get<Tire>(rig.model.elements[0].what);
  const auto slope_at = [](double x) { return 0.8 * EIGEN_PI / 11.0 * std::cos(EIGEN_PI / 11.0 * (x + 6.0)); };
  const auto height_at = [](double x) { return 0.8 * std::sin(EIGEN_PI / 11.0 * (x + 6.0)); };
  const auto distance_at = [&](const VecX& q) {
    const Vec3 c = rig.act(q).markers[1].point;
    return (c.z() - height_at(c.x())) / std::sqrt(1.0 + std::pow(slope_at(c.x()), 2));
  };
  const double h = 1e-6;
  const double rate = -(distance_at(rig.carried(h)) - distance_at(rig.carried(-h))) / (2 * h);
  const double distance = distance_at(rig.q);
  const AppliedForce& applied = rig.act(rig.q);
  const Marker& wheel = applied.markers[1];
  ASSERT_GT(tire.radius, distance);
  EXPECT_EQ(applied.regime.stretch, 1);
  EXPECT_TRUE(applied.regime.pushes);

  const double slope = slope_at(wheel.point.x());
  const Vec3 n = Vec3(-slope, 0.0, 1.0).normalized();
  const Vec3 forward = wheel.A_joint.col(1).cross(n).normalized();
  const Vec3 sideways = n.cross(forward);
  const Vec3 contact_velocity = wheel.velocity + wheel.angular_velocity.cross(-distance * n);
  const double V = std::hypot(wheel.velocity.dot(forward), tire.speed_scale);
  const double N = tire.stiffness * (tire.radius - distance) + tire.damping * rate;
  const double F_x = -tire.slip_stiffness * contact_velocity.dot(forward) / V;
  const double F_y = -tire.cornering_stiffness * wheel.velocity.dot(sideways) / V;
  ASSERT_LT(std::hypot(F_x, F_y), tire.friction * N);
  const Vec3 force = N * n + F_x * forward + F_y * sideways;
  EXPECT_LT((applied.wrenches[1].force - force).norm(), 1e-6 * force.norm());  // the rate is a difference
  EXPECT_LT((applied.wrenches[1].torque + (distance * n).cross(force)).norm(), 1e-6 * force.norm());
  // Power of what acts at the contact, on the flexible body.
  const double power =
      applied.wrenches[1].force.dot(wheel.velocity) + applied.wrenches[1].torque.dot(wheel.angular_velocity);
  EXPECT_NEAR(rig.applied.power(rig.Y), power, 1e-11 * std::abs(power));
}

TEST(Tires, FrozenRegimesGoOnBeyondTheirEnd) {
  WheelRig rig;
  const TireRegime before = rig.act(rig.q).regime;
  EXPECT_GT(rig.applied.event_functions(rig.constraints->place(rig.q), 0.0, rig.q, rig.Y).minCoeff(), 0.0);
  VecX lifted = rig.q;
  rig.layout.r(lifted, BodyIndex(2)).z() += 5.0;
  rig.applied.freeze_regimes(true);
  EXPECT_EQ(rig.act(lifted).regime, before);
  EXPECT_GT(rig.act(lifted).wrenches[1].force.norm(), 1.0);
  EXPECT_LT(rig.applied.event_functions(rig.constraints->place(lifted), 0.0, lifted, rig.Y).minCoeff(), 0.0);
  rig.applied.freeze_regimes(false);
  EXPECT_FALSE(rig.act(lifted).regime.touches);
  EXPECT_EQ(rig.act(lifted).wrenches[1].force.norm(), 0.0);
}

/// Where the slip has turned by a right angle since sliding began, the regime ends: from there on, and not before, the
/// force that is kept departs from the law.
TEST(Tires, KeptFrictionDepartsFromItsLawBeyondARightAngle) {
  WheelRig rig;
  std::get<Tire>(rig.model.elements[0].what).friction = 0.02;
  rig.Y.setZero();
  const auto slide_along = [&](double turn) {
    rig.layout.v(rig.Y, BodyIndex(2)) = 3.0 * Vec3(std::cos(turn), std::sin(turn), 0.0);
    return rig.act(rig.q).regime.slides;
  };
  ASSERT_TRUE(slide_along(0.3));
  rig.applied.freeze_regimes(true);
  int ended = 0;
  for (double turn = -3.0; turn < 3.0; turn += 0.11) {
    (void)slide_along(turn);
    const double inside = rig.applied.event_functions(rig.constraints->place(rig.q), 0.0, rig.q, rig.Y).minCoeff();
    const bool has_departed = rig.applied.departed(rig.constraints->place(rig.q).move(rig.Y), 0.0).has_value();
    EXPECT_EQ(has_departed, inside < 0.0) << turn;
    if (inside < 0.0) ++ended;
  }
  EXPECT_GT(ended, 20);
  EXPECT_LT(ended, 50);
}

constexpr double kWheelMass = 20.0;
constexpr double kRadius = 0.3;
constexpr double kStiffness = 9000.0;

/// Ground - sled, driven along x at `speed` - wheel carrier, free up and down: a quarter of a car without a spring.
Model make_quarter_car(const Road& road, double speed, double height, double damping) {
  Numbers numbers(235);
  Model model;
  model.name = "quarter";
  model.file = "quarter.toml";
  model.gravity = {0.0, 0.0, -kGravity};
  model.bodies.resize(1);
  model.bodies.push_back(testing::make_body(numbers, "sled", 0));
  model.bodies.push_back(testing::make_body(numbers, "wheel", 0));
  model.bodies[2].mass = kWheelMass;
  Mat3 z_along_x;
  z_along_x << Vec3::UnitY(), Vec3::UnitZ(), Vec3::UnitX();
  Joint guide = testing::make_joint(numbers, model, *joints::find("translational"), kGround, 1);
  guide.sides = {rigid(kGround, Vec3::Zero(), z_along_x), rigid(1, Vec3::Zero(), z_along_x)};
  guide.drivers = {{0, ConstantSpeed{0.0, speed}, 0}};
  model.joints.push_back(guide);
  Joint strut = testing::make_joint(numbers, model, *joints::find("translational"), 1, 2);
  strut.sides = {rigid(1, Vec3::Zero(), Mat3::Identity()), rigid(2, Vec3::Zero(), Mat3::Identity())};
  strut.start[0].role_q = strut.start[0].role_u = StartRole::keep;
  strut.start[0].q(0) = height;
  model.joints.push_back(strut);
  Tire tire;
  tire.wheel = rigid(2, Vec3::Zero(), Mat3::Identity());
  tire.road = std::make_shared<Road>(road);
  tire.radius = kRadius;
  tire.stiffness = kStiffness;
  tire.damping = damping;
  tire.friction = 0.8;
  model.elements.push_back({"tire", tire, {}});
  return model;
}

Trajectory run(const Model& model, const char* integrator, double until, double rtol) {
  RunOptions options;
  options.until = until;
  options.samples = 50;
  options.rtol = rtol;
  options.integrator = integrator;
  return make_solver(model)->integrate(options, {});
}

/// Dropped, without damping: parabola, half an oscillation about the equilibrium, parabola, ...
TEST(Tires, BounceFollowsItsClosedForm) {
  constexpr double kDrop = 0.1;
  const Model model = make_quarter_car({"flat", FlatRoad{0.05}}, 2.0, 0.05 + kRadius + kDrop, 0.0);
  const double omega = std::sqrt(kStiffness / kWheelMass);
  const double sag = kWheelMass * kGravity / kStiffness;
  const double fall = std::sqrt(2.0 * kDrop / kGravity);
  const double impact = kGravity * fall;
  const double contact = (EIGEN_PI + 2.0 * std::atan(omega * sag / impact)) / omega;
  const double period = 2.0 * fall + contact;
  const auto deflected = [&](double t) {  // height over the touching one, t from the top
    const double in = std::fmod(t, period);
    if (in < fall) return kDrop - 0.5 * kGravity * in * in;
    const double touching = in - fall;
    if (touching < contact) {
      return -(sag - sag * std::cos(omega * touching) + impact / omega * std::sin(omega * touching));
    }
    const double rising = period - in;
    return kDrop - 0.5 * kGravity * rising * rising;
  };
  for (const auto& [integrator, rtol, allowed] : {std::tuple{"gauss", 1e-11, 3e-11}, std::tuple{"ida", 1e-9, 3e-6}}) {
    SCOPED_TRACE(integrator);
    const Trajectory trajectory = run(model, integrator, 6.3 * period, rtol);
    double worst = 0.0;
    for (const Sample& sample : trajectory.samples) {
      const double z = sample.state.bodies[2].r.z() - 0.05 - kRadius;
      worst = std::max(worst, std::abs(z - deflected(sample.state.t)));
    }
    EXPECT_LT(worst, allowed);
  }
}

/// At rest on the flat, steps are long: a short bump far away must not be missed, nor its edges smeared. A tolerance
/// 100 times smaller brings the run 50 times nearer to the limit at least.
TEST(Tires, AShortBumpIsNeitherMissedNorSmeared) {
  const double sag = kWheelMass * kGravity / kStiffness;
  const Model model = make_quarter_car({"bump", HalfSineBump{3.0, 0.4, 0.04}}, 8.0, kRadius - sag, 120.0);
  const double until = 0.7;
  const auto end_of = [&](const char* integrator, double rtol) {
    const Trajectory trajectory = run(model, integrator, until, rtol);
    double highest = 0.0;
    for (const Sample& sample : trajectory.samples) {
      highest = std::max(highest, sample.state.bodies[2].r.z() - (kRadius - sag));
      // What stands in the run is what the state by itself says.
      const Evaluation alone = make_solver(model)->evaluate(sample.state);
      EXPECT_NEAR(alone.bodies[2].vdot.z(), sample.evaluation.bodies[2].vdot.z(), 1e-9);
    }
    EXPECT_GT(highest, 0.01);
    return trajectory.samples.back().state.bodies[2].r.z();
  };
  const double limit = end_of("gauss", 1e-13);
  const double coarse = std::abs(end_of("gauss", 1e-7) - limit);
  const double fine = std::abs(end_of("gauss", 1e-9) - limit);
  RecordProperty("coarse", std::to_string(coarse));
  EXPECT_LT(coarse, 1e-7);
  EXPECT_LT(fine, 1e-9);
  EXPECT_NEAR(end_of("ida", 1e-9), limit, 1e-6);
}

/// A locked wheel drawn sideways: friction N until the slip force falls below, the kink between them at V_y / V of
/// friction N / cornering stiffness.
TEST(Tires, SlidesAtItsLimitAndSticksBelow) {
  Numbers numbers(237);
  Model model;
  model.name = "skid";
  model.file = "skid.toml";
  model.gravity = {0.0, 0.0, -kGravity};
  model.bodies.resize(1);
  model.bodies.push_back(testing::make_body(numbers, "wheel", 0));
  model.bodies[1].mass = kWheelMass;
  Mat3 z_along_y;
  z_along_y << Vec3::UnitZ(), Vec3::UnitX(), Vec3::UnitY();
  Joint guide = testing::make_joint(numbers, model, *joints::find("translational"), kGround, 1);
  guide.sides = {rigid(kGround, Vec3(0.0, 0.0, 0.25), z_along_y), rigid(1, Vec3::Zero(), z_along_y)};
  guide.start[0].role_q = guide.start[0].role_u = StartRole::keep;
  guide.start[0].u(0) = 2.0;
  model.joints.push_back(guide);
  Tire tire;
  tire.wheel = rigid(1, Vec3::Zero(), Mat3::Identity());
  tire.road = std::make_shared<Road>(Road{"flat", FlatRoad{}});
  tire.radius = kRadius;
  tire.stiffness = kStiffness;
  tire.cornering_stiffness = 90.0;
  tire.friction = 0.8;
  tire.speed_scale = 0.1;
  model.elements.push_back({"tire", tire, {}});
  const double limit = tire.friction * kStiffness * 0.05;      // N = stiffness times deflection
  const double slow = limit / tire.cornering_stiffness * 0.1;  // V = speed_scale: the wheel does not travel forward
  ASSERT_LT(slow, 2.0);
  const double at_event = (2.0 - slow) * kWheelMass / limit;
  const double until = at_event + 0.03;
  for (const auto& [integrator, allowed] : {std::pair{"gauss", 1e-11}, std::pair{"ida", 1e-7}}) {
    SCOPED_TRACE(integrator);
    const Trajectory trajectory = run(model, integrator, until, 1e-11);
    const double speed = slow * std::exp(-tire.cornering_stiffness / 0.1 / kWheelMass * 0.03);
    EXPECT_NEAR(trajectory.samples.back().state.bodies[1].v.y(), speed, allowed);
    EXPECT_NEAR(trajectory.samples[10].evaluation.elements[0].on_side(Side::child).in_global.force.y(), -limit, 1e-9);
  }
}

/// A locked wheel that its weight pushes against a kerb and the kerb pushes back: it rattles on the edge.
TEST(Tires, RattlingWithoutEndIsTold) {
  Numbers numbers(239);
  Model model;
  model.name = "kerb";
  model.file = "kerb.toml";
  model.gravity = {4.0, 0.0, -kGravity};
  model.bodies.resize(1);
  model.bodies.push_back(testing::make_body(numbers, "wheel", 0));
  model.bodies[1].mass = kWheelMass;
  Mat3 z_along_x;
  z_along_x << Vec3::UnitY(), Vec3::UnitZ(), Vec3::UnitX();
  Joint guide = testing::make_joint(numbers, model, *joints::find("translational"), kGround, 1);
  guide.sides = {rigid(kGround, Vec3(0.0, 0.0, 0.25), z_along_x), rigid(1, Vec3::Zero(), z_along_x)};
  guide.start[0].role_q = guide.start[0].role_u = StartRole::keep;
  guide.start[0].q(0) = 1.0 - 1e-12;
  model.joints.push_back(guide);
  Tire tire;
  tire.wheel = rigid(1, Vec3::Zero(), Mat3::Identity());
  tire.road = std::make_shared<Road>(Road{"kerb", HalfSineBump{1.0, 0.5, 0.16}});
  tire.radius = kRadius;
  tire.stiffness = kStiffness;
  tire.slip_stiffness = 300.0;
  tire.friction = 0.1;
  tire.speed_scale = 1e-2;
  model.elements.push_back({"tire", tire, {}});
  std::string message;
  try {
    (void)run(model, "gauss", 1.0, 1e-7);
  } catch (const SolverError& error) {
    message = error.what();
  }
  EXPECT_THAT(message, HasSubstr("tire 'tire' changes its regime without end: 201 times within")) << message;
}

/// Nothing moves it at first; pushed onto the road later, it bounces on and on, because no damper stops it.
TEST(Tires, AWheelThatTouchesLateAndBouncesOnIsNotSaidToRattle) {
  const Model model = parse_model(R"toml(format = 1
gravity = [0, 0, 0]
[[road]]
name = "flat"
profile = "flat"
[[body]]
name = "wheel"
mass = 20
inertia = [0.6, 1, 0.6]
[[joint]]
name = "guide"
type = "translational"
both = { z = [0, 0, 1], x = [1, 0, 0] }
parent = "ground"
child = "wheel"
start.slide_z = { keep = 0.5, keep_speed = 0 }
[[tire]]
name = "tire"
body = "wheel"
road = "flat"
radius = 0.3
stiffness = 2e5
slip_stiffness = 2e4
cornering_stiffness = 2e4
friction = 0.8
speed_scale = 0.5
[[load]]
name = "push"
body = "wheel"
force = [0, 0, -200]
law = { law = "smooth_step", t0 = 1, t1 = 1.2, from = 0, to = 1 }
)toml",
                                  "late.toml");
  EXPECT_NO_THROW((void)run(model, "gauss", 60.0, 1e-6));
}

TEST(Tires, RefusesAWheelThatLiesOnItsSide) {
  Model model = make_quarter_car({"flat", FlatRoad{}}, 1.0, 0.2, 0.0);
  std::get<Tire>(model.elements[0].what).wheel.C << Vec3::UnitY(), Vec3::UnitZ(), Vec3::UnitX();
  std::string message;
  try {
    (void)make_solver(model)->evaluate(make_solver(model)->assemble());
  } catch (const SolverError& error) {
    message = error.what();
  }
  EXPECT_EQ(message,
            "cartesian: at t = 0 s tire 'tire' has no forward direction: its spin axis stands upright on the road");
}

}  // namespace
}  // namespace concord::cartesian
