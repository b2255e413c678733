#include "relative/forces/tire_contact.h"

#include <gtest/gtest.h>

#include "common/reading/model_file.h"
#include "machines.h"
#include "relative/solver.h"
#include "relative/start/assembly.h"

namespace concord::relative {
namespace {

Tire tire_on(const Road& road) {
  Tire tire;
  tire.road = std::make_shared<const Road>(road);
  tire.radius = 0.3;
  tire.stiffness = 2.0e4;
  tire.damping = 150.0;
  tire.slip_stiffness = 900.0;
  tire.cornering_stiffness = 700.0;
  tire.friction = 0.8;
  return tire;
}

Road bump() { return {"bump", HalfSineBump{0.4, 0.9, 0.11}}; }

/// A wheel's centre at a generic place over the bump, leaning, on its way.
JointPoint wheel() {
  JointPoint point("wheel", {});
  point.A = rotation_about(Axis::z, 0.5) * rotation_about(Axis::x, 0.2) * rotation_about(Axis::y, 1.1);
  point.r = Vec3(0.65, 2.0, 0.31);
  point.v = Vec3(2.1, -0.7, 0.4);
  point.omega = Vec3(-1.2, 6.0, 0.8);
  return point;
}

TEST(TireContact, DeflectsAtTheRateOfItsPlace) {
  const Tire tire = tire_on(bump());
  const auto delta_at = [&](double t) {
    JointPoint moved = wheel();
    moved.r += t * moved.v;
    return contact_of(tire, 1, moved, "tire").contact.delta;
  };
  const double h = 1e-5;
  EXPECT_NEAR(contact_of(tire, 1, wheel(), "tire").contact.deltadot, (delta_at(h) - delta_at(-h)) / (2 * h), 1e-8);
}

TEST(TireContact, PushesAlongTheRoadAtTheContact) {
  const Tire tire = tire_on(bump());
  const JointPoint center = wheel();
  const ContactFrame frame = contact_of(tire, 1, center, "tire");
  // The tangent plane of the road below the centre, by hand.
  const double phase = M_PI * 0.25 / 0.9;
  const double slope = 0.11 * M_PI / 0.9 * std::cos(phase);
  const Vec3 on_road(0.65, 2.0, 0.11 * std::sin(phase));
  const Vec3 n = Vec3(-slope, 0.0, 1.0).normalized();
  EXPECT_LT((frame.n - n).norm(), 1e-15);
  EXPECT_NEAR(frame.D, (center.r - on_road).dot(n), 1e-15);
  EXPECT_NEAR(frame.t_x.dot(center.A.col(1)), 0.0, 1e-15);
  EXPECT_GT(frame.t_x.x(), 0.5);
  EXPECT_LT((frame.t_x.cross(frame.t_y) - n).norm(), 1e-15);
  EXPECT_NEAR(frame.contact.V_y, center.v.dot(frame.t_y), 1e-15);
  const Vec3 contact = center.r - frame.D * n;
  EXPECT_NEAR(frame.contact.s_x, (center.v + center.omega.cross(contact - center.r)).dot(frame.t_x), 1e-14);
  const Vec6 w = wrench_at_center(frame, {3.0, 1.5, -0.7});
  const Vec3 force = 3.0 * n + 1.5 * frame.t_x - 0.7 * frame.t_y;
  EXPECT_LT((w.head<3>() - force).norm(), 1e-15);
  EXPECT_LT((w.tail<3>() - (contact - center.r).cross(force)).norm(), 1e-15);
}

TEST(TireContact, RefusesAWheelThatLiesOnTheRoad) {
  JointPoint center = wheel();
  center.A = rotation_about(Axis::x, M_PI / 2.0);
  try {
    (void)contact_of(tire_on({"flat", FlatRoad{}}), 0, center, "tire");
    FAIL() << "a wheel that lies on the road was accepted";
  } catch (const SolverError& error) {
    EXPECT_STREQ(error.what(),
                 "relative: force element 'tire': the wheel lies flat on the road, so that it has no direction: its "
                 "spin axis must not stand on the road");
  }
}

/// Tires on rigid and on flexible bodies: what they exert holds the machine in balance.
TEST(TireContact, BalancesOnFlexibleBodiesToo) {
  Model model = test::tree_of_all_joints(true);
  test::Numbers numbers(19);
  for (const int body : {1, 2, 4}) {
    Tire tire = tire_on({"deep", FlatRoad{-2.0}});
    tire.wheel = test::attachment(model, body, numbers);
    tire.radius = 3.0;
    tire.stiffness = 40.0;
    tire.slip_stiffness = 30.0;
    tire.damping = 0.1;
    model.elements.push_back({"tire", tire, {}});
  }
  const std::unique_ptr<Solver> solver = make_solver(model);
  const State state = solver->assemble();
  const Evaluation evaluation = solver->evaluate(state);
  for (const ElementWrenches& element : evaluation.elements) {
    EXPECT_GT(element.on_side(Side::child).in_global.force.z(), 1.0);
    EXPECT_GT(element.on_side(Side::child).in_global.force.head<2>().norm(), 0.1);
  }
  const test::Imbalance left_over = test::imbalance(model, state, evaluation);
  EXPECT_LT(left_over.force + left_over.torque + left_over.modal, 1e-9);
}

/// A wheel whose centre of mass is its centre, flying over a road.
Model flying_wheel(const Road& road, double height, double x, double v_x) {
  test::Numbers numbers(5);
  Model model;
  model.file = "wheel.toml";
  model.gravity = Vec3(0, 0, -9.81);
  Body body;
  body.name = "wheel";
  body.mass = 20.0;
  body.center_of_mass_L = Vec3(0.1, -0.2, 0.15);
  body.inertia_L = Vec3(0.8, 0.8, 0.8).asDiagonal();
  model.bodies = {test::ground(), body};
  Joint flight;
  flight.name = "flight";
  flight.type = joints::find("free");
  flight.sides = {Attachment{0, Vec3::Zero(), Mat3::Identity()},
                  Attachment{1, body.center_of_mass_L, numbers.rotation()}};
  const std::array<double, 3> place{x, 0.3, height};
  for (int axis = 0; axis < 3; ++axis) {
    flight.start.push_back({StartRole::keep, StartRole::keep, VecX::Constant(1, place[axis]), VecX::Zero(1)});
  }
  flight.start[0].u(0) = v_x;
  flight.start.push_back({StartRole::keep, StartRole::keep, VecX(Vec4::Unit(0)), VecX(Vec3(0.0, v_x / 0.3, 0.0))});
  model.joints = {flight};
  Tire tire = tire_on(road);
  tire.wheel = flight.sides[1];
  model.elements = {{"tire", tire, {}}};
  return model;
}

/// Deflection of a wheel that falls on a flat road and bounces: free flights and damped swings, each in closed form,
/// put together where the force or the deflection vanishes.
class Bounce {
 public:
  Bounce(double delta, double rate) : delta_(delta), rate_(rate) {}

  double at(double t) {
    while (true) {
      double end = 0.0;
      while (begin_ + end < t && holds(end + 1e-4)) end += 1e-4;
      if (begin_ + end >= t) return state(t - begin_).first;
      double beyond = end + 1e-4;
      for (int halvings = 0; halvings < 60; ++halvings)
        (holds(0.5 * (end + beyond)) ? end : beyond) = 0.5 * (end + beyond);
      if (begin_ + end >= t) return state(t - begin_).first;
      std::tie(delta_, rate_) = state(end);
      begin_ += end;
      pushes_ = !pushes_;
    }
  }

 private:
  static constexpr double m = 20.0, k = 2.0e4, c = 150.0, g = 9.81;

  std::pair<double, double> state(double t) const {
    if (!pushes_) return {delta_ + rate_ * t + 0.5 * g * t * t, rate_ + g * t};
    const double decay = 0.5 * c / m;
    const double omega = std::sqrt(k / m - decay * decay);
    const double a = delta_ - m * g / k;
    const double b = (rate_ + decay * a) / omega;
    const double e = std::exp(-decay * t);
    const double x = e * (a * std::cos(omega * t) + b * std::sin(omega * t));
    return {m * g / k + x, -decay * x + e * omega * (b * std::cos(omega * t) - a * std::sin(omega * t))};
  }
  bool holds(double t) const {
    const auto [delta, rate] = state(t);
    return pushes_ ? k * delta + c * rate > -1e-12 : !(delta > 0.0 && rate > 0.0);
  }

  double begin_ = 0.0, delta_, rate_;
  bool pushes_ = false;
};

class BouncingWheel : public ::testing::TestWithParam<std::pair<const char*, double>> {};

TEST_P(BouncingWheel, FollowsTheClosedFormsThroughItsEvents) {
  const auto [integrator, allowed] = GetParam();
  RunOptions options;
  options.until = 0.9;
  options.samples = 30;
  options.rtol = allowed * 1e-2;
  options.integrator = integrator;
  const Trajectory run = make_solver(flying_wheel({"flat", FlatRoad{}}, 0.4, 0.0, 0.0))->integrate(options, {});
  ASSERT_EQ(run.samples.size(), 31u);
  bool lifted = false;
  for (const Sample& sample : run.samples) {
    const double t = sample.state.t;
    const double expected = Bounce(-0.1, 0.0).at(t);
    EXPECT_NEAR(0.3 - sample.state.q[0](2), expected, allowed) << t;
    lifted = lifted || (t > 0.25 && expected < -0.01);
  }
  EXPECT_TRUE(lifted);
}

INSTANTIATE_TEST_SUITE_P(Integrators, BouncingWheel,
                         ::testing::Values(std::pair{"adams", 1e-9}, std::pair{"dirk", 1e-6}));

/// Over a bump, with a lift-off, sliding and edges of the road: the same by both integrators, and energy kept.
TEST(TireContact, WheelOverABumpIsTheSameByBothIntegrators) {
  const Model model = flying_wheel(bump(), 0.29, 0.0, 4.0);
  RunOptions options;
  options.until = 0.6;
  options.samples = 6;
  options.rtol = 1e-9;
  const Trajectory adams = make_solver(model)->integrate(options, {});
  options.integrator = "dirk";
  const Trajectory dirk = make_solver(model)->integrate(options, {});
  const double at_start = test::energy(model, adams.samples.front().state);
  double highest = 0.0;
  for (std::size_t i = 0; i < adams.samples.size(); ++i) {
    const State& state = adams.samples[i].state;
    EXPECT_LT((state.q[0] - dirk.samples[i].state.q[0]).norm(), 1e-6) << state.t;
    EXPECT_NEAR(test::energy(model, state) - adams.samples[i].work, at_start, 1e-6);
    highest = std::max(highest, state.q[0](2));
  }
  EXPECT_GT(highest, 0.4);
}

/// A run that misses where the slip has turned by a right angle goes on with a force that is not the law's: told.
TEST(TireContact, ForceOfAnEndedTurnDepartsFromItsLaw) {
  Model model = flying_wheel({"flat", FlatRoad{}}, 0.29, 0.0, 4.0);
  model.joints[0].start.back().u = VecX(Vec3::Zero());  // locked: it slides
  Equations equations(model);
  const Coordinates start = Assembly(equations).start();
  const auto departed = [&](double turn) {
    VecX u = start.u;
    u.head<2>() = 4.0 * Eigen::Vector2d(std::cos(turn), std::sin(turn));
    equations.update_forces(0.0, start.q, u);
    return equations.applied_forces().departed_contact();
  };
  EXPECT_FALSE(departed(0.0));
  equations.applied_forces().freeze_regimes();
  EXPECT_FALSE(departed(0.0));
  EXPECT_FALSE(departed(1.2));
  EXPECT_FALSE(departed(-1.2));
  ASSERT_TRUE(departed(2.5));
  EXPECT_EQ(departed(2.5)->name(), "tire 'tire'");
}

/// A drive that presses a wheel against the foot of a bump, where the road tilts at once, through a strong damper:
/// pushed forward before the foot and back behind it, the wheel comes to rest by ever more events.
TEST(TireContact, SaysWhereATireChatters) {
  Model model = flying_wheel({"step", HalfSineBump{1e-6, 1.0, 0.012}}, 0.29, 0.0, 0.0);
  model.elements.push_back({"drive",
                            Load{std::get<Tire>(model.elements[0].what).wheel, LoadAxes::global, Vec3(3.0, 0.0, 0.0),
                                 Vec3::Zero(), ConstantSpeed{1.0, 0.0}},
                            {}});
  ForceLaw damper;
  damper.damping = 3.0e5;
  model.joints[0].springs = {{0, damper, 0}};
  RunOptions options;
  options.until = 6.0;
  options.samples = 4;
  options.rtol = 1e-7;
  try {
    (void)make_solver(model)->integrate(options, {});
    FAIL() << "a wheel that chatters was integrated";
  } catch (const SolverError& error) {
    EXPECT_NE(std::string(error.what()).find("the contact of tire 'tire' changes its regime 200 times within"),
              std::string::npos)
        << error.what();
  }
}

/// Bounces on and on after a push, because no damper stops it: in a long run 200 ends of regimes are soon there.
TEST(TireContact, AWheelThatTouchesLateAndBouncesOnDoesNotChatter) {
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
  RunOptions options;
  options.until = 1e6;
  options.samples = 4;
  options.rtol = 1e-6;
  options.most_evaluations = 90000;
  EXPECT_THROW((void)make_solver(model)->integrate(options, {}), EvaluationsSpent);
}

}  // namespace
}  // namespace concord::relative
