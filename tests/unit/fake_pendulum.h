#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "common/joints/revolute.h"
#include "common/rotation.h"
#include "common/solver.h"
#include "compare/audit/element_laws.h"
#include "compare/quantities/observe.h"

/// A tilted compound pendulum, with springs and force elements if the model has them, and a solver that knows nothing
/// else, by hand from Newton and Euler: a stand-in for both solvers, with faults that the tests plant.
namespace concord::compare {

inline Model pendulum_model() {
  Model model;
  model.name = "pendulum";
  model.file = "pendulum.toml";
  model.gravity = {0.4, -9.6, 1.1};
  Body bob;
  bob.name = "bob";
  bob.mass = 1.7;
  bob.center_of_mass_L = {0.11, -0.07, 0.23};
  bob.inertia_L << 0.031, 0.004, -0.002, 0.004, 0.022, 0.003, -0.002, 0.003, 0.041;
  bob.a_start = bob.adot_start = VecX(0);
  model.bodies = {Body{}, bob};
  model.bodies[kGround].name = "ground";
  Joint hinge;
  hinge.name = "A";
  hinge.type = &joints::revolute;
  hinge.sides[0] = {kGround, Vec3(0.3, 0.2, -0.5), rotation_about(Vec3(1, 2, 2) / 3.0, 0.8)};
  hinge.sides[1] = {1, Vec3(-0.21, 0.13, 0.08), rotation_about(Vec3(2, -1, 2) / 3.0, -1.1)};
  hinge.start = {{StartRole::keep, StartRole::keep, VecX::Constant(1, 0.7), VecX::Constant(1, 3.1)}};
  model.joints = {hinge};
  model.run.until = 0.4;
  model.run.samples = 200;
  return model;
}

/// The pendulum with a spring in its hinge, a strut to ground, a bushing and a load.
inline Model sprung_pendulum_model() {
  Model model = pendulum_model();
  model.name = "sprung";
  JointSpring spring;
  spring.law.stiffness = 3.1;
  spring.law.damping = 0.2;
  spring.law.free = 0.4;
  model.joints[0].springs = {spring};
  const Attachment on_ground{kGround, Vec3(0.9, -0.4, 0.3), rotation_about(Vec3(1, 2, -2) / 3.0, 0.5)};
  const Attachment on_bob{1, Vec3(0.2, 0.15, -0.3), rotation_about(Vec3(2, 2, 1) / 3.0, -0.6)};
  LineSpring strut{{on_ground, on_bob}, {}};
  strut.law.stiffness = 40.0;
  strut.law.damping = 1.5;
  strut.law.free = 0.5;
  strut.law.actuator = Harmonic{1.0, 2.0, 9.0, 0.3};
  Bushing bushing;
  bushing.ends = {on_ground, on_bob};
  bushing.stiffness.diagonal() << 30, 20, 25, 2, 3, 4;
  bushing.damping.diagonal() << 0.3, 0.2, 0.4, 0.02, 0.03, 0.05;
  bushing.preload << 1, -2, 0.5, 0.1, 0.2, -0.3;
  const Load load{on_bob, LoadAxes::follower, Vec3(0.7, -1.1, 0.4), Vec3(0.05, 0.1, -0.2), Harmonic{0, 1, 5, 0.2}};
  model.elements = {{"strut", strut, {}}, {"rubber", bushing, {}}, {"push", load, {}}};
  return model;
}

/// A pendulum as a model file; `run`: the lines of its table [run].
inline std::string pendulum_file(const std::string& run) {
  return R"(format = 1
gravity = [0.3, -9.81, 0.2]
[[body]]
name = "bob"
mass = 1.3
center_of_mass = [0.2, 0.1, -0.05]
inertia = [0.02, 0.03, 0.04]
[[joint]]
name = "hinge"
type = "revolute"
parent = "ground"
child = "bob"
start.turn_z = { keep = 0.4, keep_speed = 2 }
[run]
)" + run;
}

class FakePendulum : public Solver {
 public:
  FakePendulum(const Model& model, std::string name)
      : model_(model), name_(std::move(name)), parent_(model.joints[0].sides[0]), child_(model.joints[0].sides[1]) {}

  /// Plant a fault: changes an evaluation, a trajectory, or the rank report.
  std::function<void(const State&, Evaluation&)> spoil = [](const State&, Evaluation&) {};
  std::function<void(Trajectory&)> spoil_run = [](Trajectory&) {};
  std::function<void(RankReport&)> spoil_rank = [](RankReport&) {};
  std::function<void(const State&)> see_rank = [](const State&) {};
  /// Angle error of a run per second and per relative tolerance [rad/s].
  double drift = 0.0;
  /// Its runs get no tighter than at this relative tolerance.
  double finest = 0.0;
  bool cannot_integrate = false;

  [[nodiscard]] std::string_view name() const override { return name_; }
  [[nodiscard]] std::vector<std::string> integrators() const override { return {"rk4", "other"}; }

  State assemble() override { return state_at(0.0, model_.joints[0].start[0].q(0), model_.joints[0].start[0].u(0)); }

  std::optional<State> close(const State& guess) override {
    const Mat3 R = parent_.C.transpose() * rotation_of(guess.bodies[1].p) * child_.C;
    const Vec3 axis = parent_.C.col(2);
    return state_at(guess.t, std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1)), axis.dot(guess.bodies[1].omega));
  }

  Evaluation evaluate(const State& state) override {
    Evaluation evaluation = solve(state);
    spoil(state, evaluation);
    return evaluation;
  }

  RankReport rank(const State& state) override {
    see_rank(state);
    RankReport report;
    report.constraints = report.rank = 5;
    report.degrees_of_freedom = 1;
    report.joints.resize(1);
    spoil_rank(report);
    return report;
  }

  MatX tangent(const State& state) override {
    const Vec3 axis = parent_.C.col(2);
    VecX direction(6);
    direction << axis.cross(state.bodies[1].r - parent_.point_L) / model_.length_scale(), axis;
    return direction.normalized();
  }

  Trajectory integrate(const RunOptions& options, const Progress& progress) override {
    if (cannot_integrate) throw SolverError(name_ + ": step size too small at t = 0.1 s");
    constexpr int kSteps = 20;
    Trajectory run;
    Vec3 y(model_.joints[0].start[0].q(0), model_.joints[0].start[0].u(0), 0.0);
    const double h = options.until / options.samples / kSteps;
    for (int k = 0; k <= options.samples; ++k) {
      const double t = options.until * k / options.samples;
      const State state = state_at(t, y(0) + drift * std::max(options.rtol, finest) * t, y(1));
      run.samples.push_back({state, evaluate(state), y(2)});
      if (progress) progress(t);
      for (int step = 0; step < kSteps; ++step) advance(t + step * h, y, h);
    }
    run.statistics = {0.01, options.samples * kSteps, 4L * options.samples * kSteps, 0.0};
    spoil_run(run);
    return run;
  }

 private:
  [[nodiscard]] static SideWrench side(const Wrench& global, const Mat3& A_joint) {
    return {{A_joint.transpose() * global.force, A_joint.transpose() * global.torque}, global};
  }

  /// Newton and Euler about the hinge, with what springs and force elements exert on the bob.
  [[nodiscard]] Evaluation solve(const State& state) const {
    const Body& body = model_.bodies[1];
    const BodyState& bob = state.bodies[1];
    const Mat3 A = rotation_of(bob.p);
    const Vec3 axis = parent_.C.col(2);
    const Vec3 omega = bob.omega;
    const Vec3 arm = A * (body.center_of_mass_L - child_.point_L);
    const Mat3 I = A * body.inertia_L * A.transpose();
    Evaluation evaluation;
    evaluation.elements = element_wrenches(state);
    const Wrench applied = applied_at_hinge(state, evaluation.elements);
    const double tau = spring_torque(state);
    const double inertia = axis.dot(I * axis) + body.mass * axis.cross(arm).squaredNorm();
    const Vec3 weight = body.mass * model_.gravity;
    const Vec3 alpha = (axis.dot(arm.cross(weight) + applied.torque) + tau) / inertia * axis;
    const Vec3 inertia_force = body.mass * (alpha.cross(arm) + omega.cross(omega.cross(arm))) - weight;
    const Vec3 force = inertia_force - applied.force;
    const Vec3 torque = I * alpha + omega.cross(I * omega) + arm.cross(inertia_force) - applied.torque;
    const Vec3 s = -(A * child_.point_L);
    evaluation.bodies.resize(2);
    for (auto& one : evaluation.bodies) one.addot = VecX(0);
    evaluation.bodies[1].vdot = alpha.cross(s) + omega.cross(omega.cross(s));
    evaluation.bodies[1].omegadot = alpha;
    JointWrenches wrenches;
    wrenches.total = both_sides({force, torque}, A);
    wrenches.reaction = both_sides({force, torque - tau * axis}, A);
    wrenches.tau = VecX::Constant(1, tau);
    wrenches.shares = spring_shares(state);
    evaluation.joints = {wrenches};
    return evaluation;
  }

  [[nodiscard]] std::array<SideWrench, 2> both_sides(const Wrench& on_child, const Mat3& A) const {
    return {side({-on_child.force, -on_child.torque}, parent_.C), side(on_child, A * child_.C)};
  }

  [[nodiscard]] std::vector<ElementWrenches> element_wrenches(const State& state) const {
    std::vector<ElementWrenches> all;
    for (const ForceElement& element : model_.elements) {
      const std::array<Wrench, 2> by_law = wrenches_by_laws(element, state, all.size());
      ElementWrenches& wrenches = all.emplace_back();
      for (const Side on : {Side::parent, Side::child}) {
        const Attachment* end = end_of(element, on);
        if (end == nullptr) continue;
        wrenches.on[index(on)] = side(by_law[index(on)], place(*end, state.bodies[end->body]).A_joint);
      }
    }
    return all;
  }

  /// What force elements exert on the bob, about the hinge.
  [[nodiscard]] Wrench applied_at_hinge(const State& state, const std::vector<ElementWrenches>& elements) const {
    Wrench sum;
    for (std::size_t k = 0; k < elements.size(); ++k) {
      for (const Side on : {Side::parent, Side::child}) {
        const Attachment* end = end_of(model_.elements[k], on);
        if (end == nullptr || end->body != 1) continue;
        const Wrench& wrench = elements[k].on_side(on).in_global;
        const Vec3 lever = place(*end, state.bodies[1]).r_P - parent_.point_L;
        sum += Wrench{wrench.force, wrench.torque + lever.cross(wrench.force)};
      }
    }
    return sum;
  }

  [[nodiscard]] std::array<VecX, kActors.size()> spring_shares(const State& state) const {
    std::array<VecX, kActors.size()> shares;
    shares.fill(VecX::Zero(1));
    for (const JointSpring& spring : model_.joints[0].springs) {
      const double at_rest = evaluate_resistance(spring.law, state.q[0](0), 0.0).force;
      shares[index(Actor::motor)](0) += evaluate_actuator(spring.law, state.t);
      shares[index(Actor::spring)](0) -= at_rest;
      shares[index(Actor::damper)](0) += at_rest - evaluate_resistance(spring.law, state.q[0](0), state.u[0](0)).force;
    }
    return shares;
  }

  [[nodiscard]] double spring_torque(const State& state) const {
    double tau = 0.0;
    for (const VecX& share : spring_shares(state)) tau += share(0);
    return tau;
  }

  [[nodiscard]] Mat3 rotation_at(double q) const {
    return parent_.C * rotation_about(Axis::z, q) * child_.C.transpose();
  }

  /// Rates of angle, speed, and work of springs and elements.
  [[nodiscard]] Vec3 rate(double t, const Vec3& y) const {
    const State state = state_at(t, y(0), y(1));
    const Evaluation evaluation = solve(state);
    const Vec3 axis = parent_.C.col(2);
    const double moment = axis.dot(applied_at_hinge(state, evaluation.elements).torque) + spring_torque(state);
    return {y(1), axis.dot(evaluation.bodies[1].omegadot), moment * y(1)};
  }

  void advance(double t, Vec3& y, double h) const {
    const Vec3 k1 = rate(t, y);
    const Vec3 k2 = rate(t + 0.5 * h, y + 0.5 * h * k1);
    const Vec3 k3 = rate(t + 0.5 * h, y + 0.5 * h * k2);
    const Vec3 k4 = rate(t + h, y + h * k3);
    y += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }

  [[nodiscard]] State state_at(double t, double q, double u) const {
    State state;
    state.t = t;
    state.bodies.resize(2);
    for (BodyState& body : state.bodies) body.a = body.adot = VecX(0);
    const Mat3 A = rotation_at(q);
    const Eigen::Quaterniond turned(A);
    const Vec3 s = A * child_.point_L;
    BodyState& bob = state.bodies[1];
    bob.p << turned.w(), turned.x(), turned.y(), turned.z();
    bob.r = parent_.point_L - s;
    bob.omega = u * parent_.C.col(2);
    bob.v = -bob.omega.cross(s);
    state.q = {VecX::Constant(1, q)};
    state.u = {VecX::Constant(1, u)};
    return state;
  }

  const Model& model_;
  std::string name_;
  Attachment parent_;
  Attachment child_;
};

}  // namespace concord::compare
