#include <catch2/catch.hpp>
#include <numbers>

#include "closed_forms.h"

/// One rigid body whose motion is known for all time: pendulum, top, free body, rotor.
namespace concord::verification {
namespace {

using std::numbers::pi;

/// The exact swing of a compound pendulum: psi'' = -w0^2 sin(psi), psi from where it hangs at rest.
class Swing {
 public:
  Swing(double w0, double psi, double psidot) : w0_(w0), k_(std::hypot(std::sin(0.5 * psi), 0.5 * psidot / w0)) {
    u0_ = k_ < 1.0 ? std::ellint_1(k_, std::asin(std::sin(0.5 * psi) / k_)) : std::ellint_1(1.0 / k_, 0.5 * psi);
  }

  [[nodiscard]] bool turns_over() const { return k_ > 1.0; }
  [[nodiscard]] double period() const { return 4.0 * std::comp_ellint_1(k_) / w0_; }
  [[nodiscard]] double angle(double t) const { return 2.0 * (turns_over() ? at(t).am : std::asin(k_ * at(t).sn)); }
  [[nodiscard]] double speed(double t) const { return 2.0 * w0_ * k_ * (turns_over() ? at(t).dn : at(t).cn); }
  [[nodiscard]] double acceleration(double t) const { return -w0_ * w0_ * std::sin(angle(t)); }

 private:
  [[nodiscard]] Jacobi at(double t) const {
    return turns_over() ? jacobi(k_ * w0_ * t + u0_, 1.0 / k_) : jacobi(w0_ * t + u0_, k_);
  }

  double w0_;
  double k_;
  double u0_;
};

/// Angle theta of the hinge, gravity and inertia of a pendulum, all from the model's statement.
struct Pendulum {
  Vec3 gravity_C;  // in the parent's joint frame
  double offset;   // psi = theta + offset
  double w0;

  explicit Pendulum(const Model& model) {
    const Body& body = model.bodies[1];
    const Attachment& on_body = model.joints[0].on(Side::child);
    gravity_C = model.joints[0].on(Side::parent).C.transpose() * model.gravity;
    const Vec3 s = on_body.C.transpose() * (body.center_of_mass_L - on_body.point_L);
    const Vec3 z = on_body.C.col(2);
    const double c = s.head<2>().norm();
    const double inertia = z.dot(body.inertia_L * z) + body.mass * c * c;
    offset = std::atan2(s.y(), s.x()) - std::atan2(gravity_C.y(), gravity_C.x());
    w0 = std::sqrt(body.mass * gravity_C.head<2>().norm() * c / inertia);
  }
};

struct PendulumDigits {
  double angle = 0.0;
  double speed = 0.0;
  double wrench = 0.0;
};

PendulumDigits measure_pendulum(const Model& model, const Pendulum& pendulum, const Swing& swing, Solver& solver) {
  const Attachment& on_ground = model.joints[0].on(Side::parent);
  Agreement angle;
  Agreement speed;
  WrenchAgreement wrench(0.2);
  for (const Sample& sample : run(solver, 3.0, 1e-12, 300).samples) {
    const double t = sample.state.t;
    const double theta = swing.angle(t) - pendulum.offset;
    angle.add(sample.state.q[0](0), theta);
    speed.add(sample.state.u[0](0), swing.speed(t));
    const Mat3 R = rotation_about(Axis::z, theta);
    const Wrench exact = hinge_wrench(model.bodies[1], model.joints[0].on(Side::child),
                                      R.transpose() * pendulum.gravity_C, swing.speed(t), swing.acceleration(t));
    const Mat3 A_joint = on_ground.C * R;
    const JointWrenches& found = sample.evaluation.joints[0];
    wrench.add(found.reaction_on(Side::child).in_C, exact);
    wrench.add(found.reaction_on(Side::child).in_global, rotated(A_joint, exact));
    wrench.add(found.reaction_on(Side::parent).in_C, rotated(-R, exact));
    wrench.add(found.reaction_on(Side::parent).in_global, rotated(-A_joint, exact));
  }
  return {angle.digits(), speed.digits(), wrench.digits()};
}

void require_elliptic(const Model& model, const std::string& what) {
  const Pendulum pendulum(model);
  const WordStart& start = model.joints[0].start[0];
  const Swing swing(pendulum.w0, start.q(0) + pendulum.offset, start.u(0));
  REQUIRE(std::abs(pendulum.gravity_C.z()) > 1.0);
  for (const auto& solver : both_solvers(model)) {
    INFO(what << ", " << solver->name());
    const PendulumDigits digits = measure_pendulum(model, pendulum, swing, *solver);
    tell(what + ": angle over 3 s", *solver, digits.angle);
    tell(what + ": reactions over 3 s", *solver, digits.wrench);
    CHECK(digits.angle >= 11.0);
    CHECK(digits.speed >= 11.0);
    CHECK(digits.wrench >= 11.0);
  }
}

Model pendulum_with_speed(double theta, double speed) {
  Model model = read("compound_pendulum");
  model.joints[0].start[0].q(0) = theta;
  model.joints[0].start[0].u(0) = speed;
  // Away from the file's special frame: gravity and centre of mass off the joint's x.
  const Mat3 C = rotation_about(Axis::z, 0.7);
  model.joints[0].sides[index(Side::parent)].C *= C;
  model.joints[0].sides[index(Side::child)].C *= rotation_about(Axis::z, -0.4);
  return model;
}

/// A steady precession of data/models/spinning_top: rate about the vertical, spin about the top's own axis.
struct Precession {
  double theta, rate, spin;

  /// I1 W^2 cos(theta) - I3 w3 W + m g l = 0 has two roots for one whole spin w3: the file's, and the other one.
  Precession(const Model& model, bool other_root) {
    const Body& top = model.bodies[1];
    theta = 35.0 * pi / 180.0;
    const double l = (top.center_of_mass_L - model.joints[0].on(Side::child).point_L).norm();
    const double I1 = top.inertia_L(0, 0) + top.mass * l * l;
    const double moment = top.mass * model.gravity.norm() * l;
    const double w3 = (I1 * 64.0 * std::cos(theta) + moment) / (top.inertia_L(2, 2) * 8.0);
    rate = other_root ? moment / (I1 * std::cos(theta) * 8.0) : 8.0;
    spin = w3 - rate * std::cos(theta);
  }

  /// Orientation of the top's body frame, the axis leaning from Z to -Y at t = 0.
  [[nodiscard]] Mat3 orientation(double t) const {
    return rotation_about(Axis::z, rate * t) * rotation_about(Axis::x, theta) * rotation_about(Axis::z, spin * t);
  }
  [[nodiscard]] Vec3 angular_velocity(double t) const { return rate * Vec3::UnitZ() + spin * orientation(t).col(2); }
};

void require_precession(bool other_root, const std::string& what) {
  Model model = read("spinning_top");
  const Precession exact(model, other_root);
  const Vec3 omega = exact.angular_velocity(0.0);
  model.joints[0].start[0].u = model.joints[0].on(Side::parent).C.transpose() * omega;
  const Body& top = model.bodies[1];
  const Vec3 lever_L = top.center_of_mass_L - model.joints[0].on(Side::child).point_L;
  for (const auto& solver : both_solvers(model)) {
    INFO(what << ", " << solver->name());
    Agreement orientation;
    Agreement turning;
    Agreement accelerating;
    WrenchAgreement wrench(lever_L.norm());
    for (const Sample& sample : run(*solver, 1.0, 1e-12, 200).samples) {
      const double t = sample.state.t;
      const BodyState& body = sample.state.bodies[1];
      const Mat3 A = exact.orientation(t);
      const Vec3 W(0.0, 0.0, exact.rate);
      orientation.add(rotation_of(body.p), A);
      turning.add(body.omega, exact.angular_velocity(t));
      // The axis goes round the vertical, and the angular velocity with it.
      accelerating.add(sample.evaluation.bodies[1].omegadot, Vec3(W.cross(exact.angular_velocity(t))));
      const Vec3 acceleration = W.cross(W.cross(A * lever_L));
      const Wrench on_top{top.mass * (acceleration - model.gravity), Vec3::Zero()};
      const JointWrenches& found = sample.evaluation.joints[0];
      wrench.add(found.reaction_on(Side::child).in_global, on_top);
      wrench.add(found.reaction_on(Side::parent).in_global, rotated(-Mat3::Identity(), on_top));
      wrench.add(found.reaction_on(Side::child).in_C,
                 rotated((A * model.joints[0].on(Side::child).C).transpose(), on_top));
    }
    tell(what + ": orientation over 1 s", *solver, orientation.digits());
    tell(what + ": reactions over 1 s", *solver, wrench.digits());
    CHECK(orientation.digits() >= 9.5);
    CHECK(turning.digits() >= 9.5);
    CHECK(accelerating.digits() >= 9.5);
    CHECK(wrench.digits() >= 9.5);
  }
}

/// A body in space: three unequal moments along tilted axes, centre of mass off the origin.
const std::string kFreeBody = R"(format = 1
[[body]]
name = "rock"
mass = 1.7
center_of_mass = [0.11, -0.07, 0.05]
inertia = [0.02, 0.05, 0.06]
[[joint]]
name = "space"
type = "free"
parent = { body = "ground", point = [0.1, 0.3, -0.2], axis = [1, 2, -1], angle = "40 deg" }
child = { body = "rock", point = [-0.03, 0.02, 0.06], axis = [-1, 1, 3], angle = "65 deg" }
start.slide_x = { keep = 0.1, keep_speed = 0.0 }
start.slide_y = { keep = -0.2, keep_speed = 0.0 }
start.slide_z = { keep = 0.3, keep_speed = 0.0 }
start.ball = { keep = { axis = [2, 1, 1], angle = "100 deg" }, keep_speed = [0.0, 0.0, 0.0] }
)";

/// Free rotation of a rigid body (Euler), I1 < I2 < I3 and M^2 > 2 E I2 (Landau and Lifshitz, Mechanics, section 37):
/// angular velocity along the principal axes.
class FreeRotation {
 public:
  FreeRotation(const Vec3& I, double w1, double w3, double t0) : t0_(t0) {
    // Largest values of w1 and w3, reached where w2 vanishes.
    const double twice_energy = I(0) * w1 * w1 + I(2) * w3 * w3;
    const double M2 = I(0) * I(0) * w1 * w1 + I(2) * I(2) * w3 * w3;
    amplitudes_ = Vec3(w1, std::sqrt((twice_energy * I(2) - M2) / (I(1) * (I(2) - I(1)))), w3);
    rate_ = std::sqrt((I(2) - I(1)) * (M2 - twice_energy * I(0)) / (I(0) * I(1) * I(2)));
    k_ = std::sqrt((I(1) - I(0)) * (twice_energy * I(2) - M2) / ((I(2) - I(1)) * (M2 - twice_energy * I(0))));
    REQUIRE(k_ < 1.0);
  }

  [[nodiscard]] Vec3 at(double t) const {
    const Jacobi j = jacobi(rate_ * (t + t0_), k_);
    return amplitudes_.cwiseProduct(Vec3(j.cn, j.sn, j.dn));
  }

 private:
  double t0_;
  Vec3 amplitudes_;
  double rate_;
  double k_;
};

/// Linear momentum, angular momentum about the global origin and kinetic energy, by the direct sum.
struct Momenta {
  Vec3 linear = Vec3::Zero();
  Vec3 angular = Vec3::Zero();
  double energy = 0.0;

  Momenta(const Body& body, const BodyState& state) {
    const Mat3 A = rotation_of(state.p);
    const auto add = [&](double mass, const Vec3& s, const Vec3& rate) {
      const Vec3 velocity = state.v + state.omega.cross(s) + rate;
      linear += mass * velocity;
      angular += mass * (state.r + s).cross(velocity);
      energy += 0.5 * mass * velocity.squaredNorm();
    };
    if (body.modal) {
      for (const MassPoint& p : body.modal->mass_points) {
        add(p.mass, A * (p.s0_L + p.Psi_t_L * state.a), A * (p.Psi_t_L * state.adot));
      }
      energy += 0.5 * state.a.dot(body.modal->stiffness * state.a);
    } else {
      add(body.mass, A * body.center_of_mass_L, Vec3::Zero());
      const Vec3 spin = A * body.inertia_L * A.transpose() * state.omega;
      angular += spin;
      energy += 0.5 * state.omega.dot(spin);
    }
  }
};

/// Digits to which a free body keeps its momenta and energy over a run, and to which its joint carries nothing.
struct KeptDigits {
  Agreement linear, angular, energy;
  double largest_wrench = 0.0;
};

KeptDigits measure_kept(const Model& model, const Trajectory& trajectory) {
  KeptDigits kept;
  const Momenta start(model.bodies[1], trajectory.samples.front().state.bodies[1]);
  for (const Sample& sample : trajectory.samples) {
    const Momenta now(model.bodies[1], sample.state.bodies[1]);
    kept.linear.add(now.linear, start.linear);
    kept.angular.add(now.angular, start.angular);
    kept.energy.add(now.energy, start.energy);
    for (const Side side : {Side::parent, Side::child}) {
      kept.largest_wrench = std::max(
          kept.largest_wrench, sample.evaluation.joints[0].total_on(side).in_global.vector().lpNorm<Eigen::Infinity>());
    }
  }
  return kept;
}

void require_kept(const KeptDigits& kept, const std::string& what, const Solver& solver) {
  tell(what + ": linear momentum", solver, kept.linear.digits());
  tell(what + ": angular momentum", solver, kept.angular.digits());
  tell(what + ": energy", solver, kept.energy.digits());
  CHECK(kept.linear.digits() >= 11.0);
  CHECK(kept.angular.digits() >= 11.0);
  CHECK(kept.energy.digits() >= 11.0);
}

const std::string kFlexibleFreeBody = R"(format = 1
[[body]]
name = "beam"
start.a = [0.02, -0.004, 0.01, 0.003, 0.0005]
start.adot = [0.3, -0.2, -0.4, 0.5, 0.1]
[body.beam]
first_end = [0.1, -0.2, 0.05]
x = [6, 2, -3]
z = [2, 3, 6]
length = 1.1
elements = 12
section = { width_y = 0.02, width_z = 0.03 }
youngs_modulus = 1.0e7
poissons_ratio = 0.3
density = 1200
support = "free_free"
modes = { bending_xy = [1, 2], bending_xz = [1], torsion = [1], axial = [1] }
[[joint]]
name = "space"
type = "free"
parent = { body = "ground", point = [0.1, 0.3, -0.2], axis = [1, 2, -1], angle = "40 deg" }
child = { body = "beam", node = "4", offset = [0.02, 0.03, -0.01], axis = [-1, 1, 3], angle = "65 deg" }
start.slide_x = { keep = 0.1, keep_speed = 0.7 }
start.slide_y = { keep = -0.2, keep_speed = -0.4 }
start.slide_z = { keep = 0.3, keep_speed = 1.1 }
start.ball = { keep = { axis = [2, 1, 1], angle = "100 deg" }, keep_speed = [2.0, -3.0, 4.0] }
)";

/// A disc that is neither centred nor aligned on its shaft.
const std::string kRotor = R"(format = 1
gravity = [1.1, -9.3, 2.7]
[[body]]
name = "rotor"
mass = 2.3
center_of_mass = [0.04, -0.03, 0.06]
inertia = [0.031, 0.022, 0.043, 0.003, -0.004, 0.002]
[[joint]]
name = "bearing"
type = "revolute"
parent = { body = "ground", point = [0.3, -0.2, 0.5], sequence = "zxz", angles = ["20 deg", "55 deg", "-35 deg"] }
child = { body = "rotor", point = [-0.05, 0.08, 0.02], axis = [2, -1, 1], angle = "75 deg" }
drive.turn_z = { law = "polynomial", coefficients = [0.3, 25, 40, -12] }
)";

}  // namespace

TEST_CASE("Jacobi's functions satisfy their differential equations and reach quarter periods", "[closed form][quick]") {
  for (const double k : {0.0, 0.3, 0.94, 0.9999}) {
    const double K = std::comp_ellint_1(k);
    CHECK(jacobi(K, k).am == Approx(0.5 * pi).epsilon(1e-14));
    CHECK(jacobi(std::ellint_1(k, 0.8), k).am == Approx(0.8).epsilon(1e-14));
    CHECK(jacobi(5.0 * K, k).am == Approx(2.5 * pi).epsilon(1e-13));
    const double h = 1e-5;
    const double rate = (jacobi(1.3 + h, k).am - jacobi(1.3 - h, k).am) / (2.0 * h);
    CHECK(rate == Approx(jacobi(1.3, k).dn).epsilon(1e-9));
  }
}

TEST_CASE("The compound pendulum swings as elliptic functions say, and its tilted hinge carries what follows from them",
          "[closed form][quick]") {
  require_elliptic(read("compound_pendulum"), "pendulum from rest at 140 deg");
}

TEST_CASE("A pendulum that starts with a speed, frames turned about the hinge, keeps to its elliptic function",
          "[closed form][quick]") {
  require_elliptic(pendulum_with_speed(-0.9, 2.5), "pendulum with a start speed");
}

TEST_CASE("A pendulum that turns over keeps to its elliptic function and counts its turns", "[closed form][quick]") {
  require_elliptic(pendulum_with_speed(0.6, 14.0), "pendulum turning over");
}

TEST_CASE("The compound pendulum is back where it was released after 4 K(k) / w0", "[closed form][quick]") {
  const Model model = read("compound_pendulum");
  const Pendulum pendulum(model);
  const double theta = model.joints[0].start[0].q(0);
  const double period = Swing(pendulum.w0, theta + pendulum.offset, 0.0).period();
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    const Trajectory trajectory = run(*solver, period, 1e-12, 4);
    // Halfway it rests on the other side.
    CHECK(trajectory.samples[2].state.q[0](0) == Approx(-theta).epsilon(1e-9));
    CHECK(trajectory.samples[4].state.q[0](0) == Approx(theta).epsilon(1e-9));
    CHECK(std::abs(trajectory.samples[4].state.u[0](0)) < 1e-8);
  }
}

TEST_CASE("A heavy symmetric top precesses steadily at the slow rate, its support carrying m (a - g) and no torque",
          "[closed form][quick]") {
  require_precession(false, "top, rate of the file");
}

TEST_CASE("A heavy symmetric top with the same spin precesses steadily at the other rate as well",
          "[closed form][quick]") {
  require_precession(true, "top, other rate");
}

TEST_CASE("A free rigid body turns as Euler's solution in elliptic functions says", "[closed form][quick]") {
  Model model = parse(kFreeBody);
  const Mat3 principal = rotation_about(Vec3(Vec3(1.0, -0.5, 0.8).normalized()), 1.1);
  const Vec3 moments(0.02, 0.05, 0.06);
  Body& rock = model.bodies[1];
  rock.inertia_L = principal * moments.asDiagonal() * principal.transpose();
  const FreeRotation exact(moments, 4.0, 6.0, 0.13);
  const Joint& joint = model.joints[0];
  WordStart& ball = model.joints[0].start[3];
  const Mat3 R = rotation_of(ball.q);
  ball.u = R * joint.on(Side::child).C.transpose() * principal * exact.at(0.0);
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    const Trajectory trajectory = run(*solver, 3.0, 1e-12, 300);
    Agreement turning;
    Agreement center;
    const Momenta start(rock, trajectory.samples.front().state.bodies[1]);
    const auto center_of = [&](const BodyState& body) {
      return Vec3(body.r + rotation_of(body.p) * rock.center_of_mass_L);
    };
    const Vec3 first = center_of(trajectory.samples.front().state.bodies[1]);
    for (const Sample& sample : trajectory.samples) {
      const BodyState& body = sample.state.bodies[1];
      turning.add(Vec3(principal.transpose() * rotation_of(body.p).transpose() * body.omega), exact.at(sample.state.t));
      center.add(center_of(body), Vec3(first + sample.state.t * start.linear / rock.mass));
    }
    tell("free body: angular velocity over 3 s", *solver, turning.digits());
    tell("free body: path of the centre of mass", *solver, center.digits());
    CHECK(turning.digits() >= 8.5);
    CHECK(center.digits() >= 9.0);
    const KeptDigits kept = measure_kept(model, trajectory);
    require_kept(kept, "free body", *solver);
    CHECK(kept.largest_wrench < 1e-12 * rock.mass * 36.0);
  }
}

TEST_CASE("A free vibrating beam keeps its linear and angular momentum and, undamped, its energy",
          "[closed form][quick]") {
  const Model model = parse(kFlexibleFreeBody);
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    const KeptDigits kept = measure_kept(model, run(*solver, 1.0, 1e-11, 100));
    require_kept(kept, "free vibrating beam", *solver);
    CHECK(kept.largest_wrench < 1e-10);
  }
}

TEST_CASE("The bearing of a driven unbalanced rotor carries its static and dynamic unbalance, its driver the rest",
          "[closed form][quick]") {
  const Model model = parse(kRotor);
  const Joint& bearing = model.joints[0];
  const Mat3 A_parent = bearing.on(Side::parent).C;
  for (const auto& solver : both_solvers(model)) {
    INFO(solver->name());
    WrenchAgreement wrench(0.1);
    Agreement driver;
    for (const Sample& sample : run(*solver, 1.0, 1e-10, 100).samples) {
      const TimeFunctionValue law = evaluate(bearing.drivers[0].law, sample.state.t);
      const Mat3 A_joint = A_parent * rotation_about(Axis::z, law.f);
      const Wrench total = hinge_wrench(model.bodies[1], bearing.on(Side::child), A_joint.transpose() * model.gravity,
                                        law.fdot, law.fddot);
      Wrench reaction = total;
      reaction.torque.z() = 0.0;
      const JointWrenches& found = sample.evaluation.joints[0];
      wrench.add(found.total_on(Side::child).in_C, total);
      wrench.add(found.total_on(Side::child).in_global, rotated(A_joint, total));
      wrench.add(found.reaction_on(Side::child).in_C, reaction);
      wrench.add(found.reaction_on(Side::parent).in_global, rotated(-A_joint, reaction));
      wrench.add(found.reaction_on(Side::parent).in_C, rotated(-rotation_about(Axis::z, law.f), reaction));
      driver.add(found.tau(0), total.torque.z());
    }
    tell("unbalanced rotor: bearing", *solver, wrench.digits());
    tell("unbalanced rotor: driver", *solver, driver.digits());
    CHECK(wrench.digits() >= 12.0);
    CHECK(driver.digits() >= 12.0);
  }
}

}  // namespace concord::verification
