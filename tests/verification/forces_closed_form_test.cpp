#include <catch2/catch.hpp>

#include "closed_forms.h"

/// Machines with springs, rods, loads and redundant bearings whose motion and forces are known for all time.
namespace concord::verification {
namespace {

constexpr double kGravity = 9.81;

/// m x'' + c x' + k x = load, from x0 at the rate xdot0; c below the critical damping.
struct DampedOscillator {
  double m, c, k, load, x0, xdot0;

  [[nodiscard]] double decay() const { return 0.5 * c / m; }
  [[nodiscard]] double rate() const { return std::sqrt(k / m - decay() * decay()); }

  [[nodiscard]] TimeFunctionValue at(double t) const {
    const double rest = load / k;
    const double in_phase = x0 - rest;
    const double across = (xdot0 + decay() * in_phase) / rate();
    const double fade = std::exp(-decay() * t);
    const double cosine = fade * std::cos(rate() * t);
    const double sine = fade * std::sin(rate() * t);
    const double x = rest + in_phase * cosine + across * sine;
    const double xdot = (across * rate() - decay() * in_phase) * cosine - (in_phase * rate() + decay() * across) * sine;
    return {x, xdot, (load - c * xdot - k * x) / m};
  }
};

/// Global axes of the child's joint frame of a hinge with ground that has turned by `angle`.
Mat3 turned_frame(const Joint& hinge, double angle) {
  return hinge.on(Side::parent).C * rotation_about(Axis::z, angle);
}

const Wrench& on_child(const JointWrenches& joint) { return joint.reaction_on(Side::child).in_global; }

/// The wrench about another point: `lever` leads from there to the point that it was about.
Wrench moved(const Wrench& wrench, const Vec3& lever) {
  return {wrench.force, wrench.torque + lever.cross(wrench.force)};
}

/// A place on a body, as the hinge of another body sees it to which this one is welded: the same hinge frame, said in
/// the axes of this body.
Attachment through_weld(const Joint& weld, const Attachment& hinge) {
  const Attachment& outer = weld.on(Side::parent);
  const Attachment& own = weld.on(Side::child);
  const Mat3 to_own = own.C * outer.C.transpose();
  Attachment seen;
  seen.point_L = own.point_L + to_own * (hinge.point_L - outer.point_L);
  seen.C = to_own * hinge.C;
  return seen;
}

}  // namespace

TEST_CASE("A body on a tilted guide between springs and dampers swings as a damped oscillator does",
          "[closed form][forces][quick]") {
  const Model model = read("mass_on_spring_damper");
  const Joint& guide = model.joints[0];
  const Body& body = model.bodies[1];
  const ForceLaw& inner = guide.springs[0].law;
  const ForceLaw& outer = std::get<LineSpring>(model.elements[0].what).law;
  constexpr double kGap = 0.35;  // of the line spring at q = 0
  const Vec3 z = guide.on(Side::parent).C.col(2);
  const DampedOscillator exact{body.mass,
                               inner.damping + outer.damping,
                               inner.stiffness + outer.stiffness,
                               outer.stiffness * (outer.free - kGap) + body.mass * model.gravity.dot(z),
                               guide.start[0].q(0),
                               guide.start[0].u(0)};
  const Mat3 A = guide.on(Side::parent).C * guide.on(Side::child).C.transpose();
  const Vec3 to_center = A * (body.center_of_mass_L - guide.on(Side::child).point_L);
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    Agreement motion;
    Agreement tau;
    WrenchAgreement reaction(0.1);
    WrenchAgreement coil(0.1);
    for (const Sample& sample : run(*solver, 2.0, 1e-12, 100).samples) {
      const TimeFunctionValue q = exact.at(sample.state.t);
      motion.add(sample.state.q[0](0), q.f);
      motion.add(sample.state.u[0](0), q.fdot);
      const double spring = -inner.stiffness * q.f - inner.damping * q.fdot;
      const double tension = outer.stiffness * (kGap + q.f - outer.free) + outer.damping * q.fdot;
      tau.add(sample.evaluation.joints[0].tau(0), spring);
      // The body does not turn, so all forces at the joint's point together have no moment about its centre of mass.
      const Vec3 all = body.mass * (q.fddot * z - model.gravity);
      reaction.add(on_child(sample.evaluation.joints[0]), {all - (spring - tension) * z, to_center.cross(all)});
      coil.add(sample.evaluation.elements[0].on_side(Side::child).in_global, {-tension * z, Vec3::Zero()});
      coil.add(sample.evaluation.elements[0].on_side(Side::parent).in_global, {tension * z, Vec3::Zero()});
    }
    const double forces = std::min({tau.digits(), reaction.digits(), coil.digits()});
    tell("damped oscillator: motion", *solver, motion.digits());
    tell("damped oscillator: forces", *solver, forces);
    CHECK(motion.digits() >= 11.0);
    CHECK(forces >= 11.0);
  }
}

TEST_CASE("A torsion pendulum with two springs swings as a damped oscillator does and loads its bearing by Euler's law",
          "[closed form][forces][quick]") {
  const Model model = read("torsion_pendulum");
  const Joint& bearing = model.joints[0];
  const Body& disc = model.bodies[1];
  const ForceLaw& inner = bearing.springs[0].law;
  const ForceLaw& outer = std::get<TurnSpring>(model.elements[0].what).law;
  const Vec3 gravity_C = bearing.on(Side::parent).C.transpose() * model.gravity;
  const double inertia = hinge_wrench(disc, bearing.on(Side::child), Vec3::Zero(), 0.0, 1.0).torque.z();
  const DampedOscillator exact{inertia,
                               inner.damping + outer.damping,
                               inner.stiffness + outer.stiffness,
                               outer.stiffness * outer.free,
                               bearing.start[0].q(0),
                               bearing.start[0].u(0)};
  REQUIRE(gravity_C.head<2>().norm() < 1e-14);
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    Agreement motion;
    Agreement springs;
    WrenchAgreement reaction(0.1);
    for (const Sample& sample : run(*solver, 2.0, 1e-12, 100).samples) {
      const TimeFunctionValue q = exact.at(sample.state.t);
      motion.add(sample.state.q[0](0), q.f);
      motion.add(sample.state.u[0](0), q.fdot);
      springs.add(sample.evaluation.joints[0].tau(0), -inner.stiffness * q.f - inner.damping * q.fdot);
      const double helix = -outer.stiffness * (q.f - outer.free) - outer.damping * q.fdot;
      springs.add(sample.evaluation.elements[0].on_side(Side::child).in_C.torque, Vec3(0.0, 0.0, helix));
      Wrench needed = hinge_wrench(disc, bearing.on(Side::child), gravity_C, q.fdot, q.fddot);
      needed.torque.z() = 0.0;  // what turns the disc is the springs'
      reaction.add(sample.evaluation.joints[0].reaction_on(Side::child).in_C, needed);
    }
    const double forces = std::min(springs.digits(), reaction.digits());
    tell("torsion pendulum: motion", *solver, motion.digits());
    tell("torsion pendulum: forces", *solver, forces);
    CHECK(motion.digits() >= 11.0);
    CHECK(forces >= 11.0);
  }
}

TEST_CASE("Two hinges of a door carry together what Newton and Euler ask; what each carries is told to be not unique",
          "[closed form][forces][redundant][quick]") {
  Model model = read("two_hinge_door");
  // Driven, so that the motion is known; the closer works all the same.
  const TimeFunction law = Polynomial{{1.2, 0.6, -0.9, 0.7}};
  model.joints[0].drivers.push_back({0, law});
  model.joints[0].start[0] = model.joints[1].start[0];
  model.joints[0].start[0].role_q = StartRole::unsaid;
  const Joint& lower = model.joints[0];
  const Attachment& door = lower.on(Side::child);
  const Attachment handle = through_weld(model.joints[2], door);
  const Vec3 upwards = model.joints[1].on(Side::parent).point_L - lower.on(Side::parent).point_L;
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    WrenchAgreement sum(1.5);
    const Trajectory trajectory = run(*solver, 1.0, 1e-11, 50);
    for (const Sample& sample : trajectory.samples) {
      const TimeFunctionValue q = evaluate(law, sample.state.t);
      const Mat3 frame = turned_frame(lower, q.f);
      const Vec3 gravity_C = frame.transpose() * model.gravity;
      Wrench needed = hinge_wrench(model.bodies[1], door, gravity_C, q.fdot, q.fddot);
      needed += hinge_wrench(model.bodies[2], handle, gravity_C, q.fdot, q.fddot);
      Wrench found = sample.evaluation.joints[0].total_on(Side::child).in_global;
      found += moved(sample.evaluation.joints[1].total_on(Side::child).in_global, upwards);
      sum.add(found, rotated(frame, needed));
    }
    tell("two hinges of a door: their sum", *solver, sum.digits());
    CHECK(sum.digits() >= 12.0);
    const RankReport rank = solver->rank(trajectory.samples.back().state);
    CHECK(rank.constraints - rank.rank == 5);
    for (int joint = 0; joint < 2; ++joint) {
      for (const auto& unique : rank.joints[joint].unique) {
        for (int component = 0; component < 5; ++component) CHECK_FALSE(unique[component]);
        CHECK(unique[5]);
      }
    }
  }
}

TEST_CASE("A universal joint at 30 degrees under 10 N m turns unevenly and loads the bearings with moments across",
          "[closed form][forces][redundant][quick]") {
  const Model model = read("universal_shaft_30deg");
  const Joint& in = model.joints[0];
  const Joint& out = model.joints[2];
  const Vec3 in_axis = in.on(Side::parent).C.col(2);
  const Vec3 out_axis = out.on(Side::parent).C.col(2);
  const double b = std::acos(in_axis.dot(out_axis));
  REQUIRE(b == Approx(30.0 * EIGEN_PI / 180.0).epsilon(1e-14));
  constexpr double kBrake = 10.0;
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    Agreement speed;
    Agreement torques;
    for (const Sample& sample : run(*solver, 1.0, 1e-11, 100).samples) {
      const TimeFunctionValue theta = evaluate(in.drivers[0].law, sample.state.t);
      const double n = 1.0 - std::pow(std::sin(b) * std::sin(theta.f), 2);
      const double phidot = std::cos(b) / n * theta.fdot;
      const double phiddot = phidot * theta.fdot * std::pow(std::sin(b), 2) * std::sin(2.0 * theta.f) / n;
      speed.add(sample.state.u[2](0), phidot);
      speed.add(sample.evaluation.bodies[2].omegadot, Vec3(phiddot * out_axis));

      // The yokes: x of the driving shaft, y of the driven one, at right angles to each other and to their shafts.
      const Mat3 driving = turned_frame(in, theta.f);
      const Vec3 yoke = out_axis.cross(Vec3(driving.col(0))).normalized();
      Mat3 driven;
      driven << yoke.cross(out_axis), yoke, out_axis;
      const Vec3 normal = Vec3(driving.col(0)).cross(yoke);
      const Vec3 for_driving = driving * hinge_wrench(model.bodies[1], in.on(Side::child),
                                                      driving.transpose() * model.gravity, theta.fdot, 0.0)
                                             .torque;
      const Vec3 for_driven = driven * hinge_wrench(model.bodies[2], out.on(Side::child),
                                                    driven.transpose() * model.gravity, phidot, phiddot)
                                           .torque;
      // The cross passes torque about its own normal only: as much as the driven shaft's spin and brake ask.
      const Vec3 cross = (for_driven.dot(out_axis) + kBrake) / normal.dot(out_axis) * normal;
      const Vec3 in_total = for_driving + cross;
      const double motor = in_total.dot(in_axis);
      torques.add(on_child(sample.evaluation.joints[1]).torque, cross);
      torques.add(sample.evaluation.joints[0].tau(0), motor);
      torques.add(on_child(sample.evaluation.joints[0]).torque, Vec3(in_total - motor * in_axis));
      torques.add(on_child(sample.evaluation.joints[2]).torque, Vec3(for_driven + kBrake * out_axis - cross));
    }
    tell("universal joint at 30 deg: speed ratio", *solver, speed.digits());
    tell("universal joint at 30 deg: bearing moments, 10 N m", *solver, torques.digits());
    CHECK(speed.digits() >= 12.0);
    CHECK(torques.digits() >= 12.0);
  }
}

TEST_CASE("An unbalanced rotor turns at its rate and pushes its two bearings round with m W^2 e and W x (I W)",
          "[closed form][forces][quick]") {
  const Model model = read("unbalanced_rotor");
  constexpr double kW = 60.0;
  constexpr double kLength = 0.4;
  Attachment shaft = model.joints[0].on(Side::parent);
  const Mat3 C = shaft.C;
  const Wrench needed = hinge_wrench(model.bodies[1], shaft, Vec3::Zero(), kW, 0.0);
  REQUIRE(needed.torque.norm() > 1.0);
  const Vec3 far = needed.torque.cross(Vec3(Vec3::UnitZ())) / kLength;
  const Vec3 near = needed.force - far;
  const auto on_rotor = [&](const Evaluation& evaluation, int joint) {
    const Side side = model.joints[joint].on(Side::parent).body == 1 ? Side::parent : Side::child;
    return evaluation.joints[joint].reaction_on(side).in_global.force;
  };
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    Agreement rate;
    Agreement forces;
    for (const Sample& sample : run(*solver, 0.5, 1e-12, 100).samples) {
      rate.add(sample.state.bodies[1].omega, Vec3(kW * C.col(2)));
      const Mat3 turned = C * rotation_about(Axis::z, kW * sample.state.t);
      // Each rod carries what is along it: those named x and y stand along these axes of the ground's frame C.
      const Vec3 exact_near = turned * near;
      const Vec3 exact_far = turned * far;
      forces.add(on_rotor(sample.evaluation, 0), Vec3(C.col(0).dot(exact_near) * C.col(0)));
      forces.add(on_rotor(sample.evaluation, 1), Vec3(C.col(1).dot(exact_near) * C.col(1)));
      forces.add(on_rotor(sample.evaluation, 2), Vec3(C.col(0).dot(exact_far) * C.col(0)));
      forces.add(on_rotor(sample.evaluation, 3), Vec3(C.col(1).dot(exact_far) * C.col(1)));
    }
    tell("unbalanced rotor: rate", *solver, rate.digits());
    tell("unbalanced rotor: bearing forces", *solver, forces.digits());
    CHECK(rate.digits() >= 11.0);
    CHECK(forces.digits() >= 11.0);
  }
}

TEST_CASE("A conical pendulum goes round at sqrt(g/(L cos)) and pulls its rod with m g/cos",
          "[closed form][forces][quick]") {
  const Model model = read("conical_pendulum");
  const Joint& rod = model.joints[0];
  const double length = std::get<joints::KeepDistance>(rod.type->forbids[0]).length;
  const double lean = rod.start[1].q(0);
  const double W = std::sqrt(kGravity / (length * std::cos(lean)));
  const Body& bob = model.bodies[1];
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    Agreement path;
    WrenchAgreement pull(length);
    for (const Sample& sample : run(*solver, 2.0, 1e-12, 100).samples) {
      const Mat3 turned = turned_frame(rod, W * sample.state.t);
      const Vec3 along = turned * Vec3(std::sin(lean), 0.0, std::cos(lean));
      const BodyState& state = sample.state.bodies[1];
      path.add(Vec3(state.r + rotation_of(state.p) * bob.center_of_mass_L),
               Vec3(rod.on(Side::parent).point_L + length * along));
      const Vec3 tension = bob.mass * kGravity / std::cos(lean) * along;
      pull.add(on_child(sample.evaluation.joints[0]), {-tension, Vec3::Zero()});
      pull.add(sample.evaluation.joints[0].reaction_on(Side::parent).in_global, {tension, Vec3::Zero()});
    }
    tell("conical pendulum: path", *solver, path.digits());
    tell("conical pendulum: pull of the rod", *solver, pull.digits());
    CHECK(path.digits() >= 10.5);
    CHECK(pull.digits() >= 10.5);
  }
}

}  // namespace concord::verification
