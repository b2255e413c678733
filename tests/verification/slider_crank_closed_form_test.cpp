#include <catch2/catch.hpp>

#include "closed_forms.h"

/// The rigid slider-crank in its plane, by hand: kinematics written out, then equilibrium of slider, coupler and crank
/// in that order, inertia forces included (d'Alembert).
namespace concord::verification {
namespace {

using Vec2 = Eigen::Vector2d;

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }
Vec2 along(double angle) { return {std::cos(angle), std::sin(angle)}; }
Vec2 across(const Vec2& v) { return {-v.y(), v.x()}; }

/// Mass, centre of mass in the body's axes, inertia about it.
struct Member {
  double mass;
  Vec2 center;
  double inertia;
};

/// What the plane shows of the model: x along the slide, z the hinge axis, A at the origin.
struct Plane {
  Member crank, coupler, slider;
  double r, L;
  Vec2 guide;  // where joint D sits on ground
  Vec2 gravity;

  explicit Plane(const Model& model)
      : crank(member(model.bodies[1])),
        coupler(member(model.bodies[2])),
        slider(member(model.bodies[3])),
        r(model.joints[1].on(Side::parent).point_L.x()),
        L(model.joints[2].on(Side::parent).point_L.x()),
        guide(model.joints[3].on(Side::parent).point_L.head<2>()),
        gravity(model.gravity.head<2>()) {}

  static Member member(const Body& body) { return {body.mass, body.center_of_mass_L.head<2>(), body.inertia_L(2, 2)}; }
};

/// Forces on the child of each joint at its point, driver torque, and torque of the guide.
struct ByHand {
  double phi, phidot, phiddot;
  Vec2 A, B, C, D;
  double tau, T_D;
  double gap;  // from the guide's point on ground to the slider, along the slide
};

/// Crank angle and its rates given; phi is the coupler's angle, between -90 and 90 degrees.
ByHand solve_by_hand(const Plane& m, double theta, double thetadot, double thetaddot) {
  ByHand h{};
  const Vec2 B = m.r * along(theta);
  const Vec2 B_acc = thetaddot * across(B) - thetadot * thetadot * B;
  h.phi = std::asin((m.guide.y() - B.y()) / m.L);
  const Vec2 l = m.L * along(h.phi);
  h.phidot = -thetadot * B.x() / l.x();
  h.phiddot = (h.phidot * h.phidot * l.y() - B_acc.y()) / l.x();
  const Vec2 C_acc = B_acc + h.phiddot * across(l) - h.phidot * h.phidot * l;
  h.gap = B.x() + l.x() - m.guide.x();

  const Vec2 to_slider = m.slider.center;
  const Vec2 to_coupler = m.coupler.center.x() * along(h.phi) + m.coupler.center.y() * across(along(h.phi));  // from B
  const Vec2 to_crank = m.crank.center.x() * along(theta) + m.crank.center.y() * across(along(theta));
  // What must act on each body: mass times (acceleration of its centre of mass - gravity).
  const Vec2 on_slider = m.slider.mass * (C_acc - m.gravity);
  const Vec2 on_coupler =
      m.coupler.mass * (B_acc + h.phiddot * across(to_coupler) - h.phidot * h.phidot * to_coupler - m.gravity);
  const Vec2 on_crank = m.crank.mass * (thetaddot * across(to_crank) - thetadot * thetadot * to_crank - m.gravity);

  h.C.x() = on_slider.x();
  // Moments on the coupler about B: I phiddot + to_coupler x on_coupler = l x (-C).
  h.C.y() = (l.y() * h.C.x() - m.coupler.inertia * h.phiddot - cross(to_coupler, on_coupler)) / l.x();
  h.D = on_slider - h.C;
  h.T_D = cross(to_slider, on_slider);
  h.B = on_coupler + h.C;
  h.A = on_crank + h.B;
  h.tau = m.crank.inertia * thetaddot + cross(to_crank, on_crank) + cross(B, h.B);
  return h;
}

Wrench in_plane(const Vec2& force, double torque) { return {Vec3(force.x(), force.y(), 0.0), Vec3(0.0, 0.0, torque)}; }

/// Total wrenches on child and parent of the joints A, B, C, D, in the plane's axes.
struct JointWrenchesByHand {
  std::array<std::array<Wrench, 2>, 4> total;

  explicit JointWrenchesByHand(const ByHand& h) {
    const std::array<Wrench, 4> on_child{in_plane(h.A, h.tau), in_plane(h.B, 0.0), in_plane(h.C, 0.0),
                                         in_plane(h.D, h.T_D)};
    for (int k = 0; k < 4; ++k) {
      total[k][index(Side::child)] = on_child[k];
      total[k][index(Side::parent)] = {-on_child[k].force, -on_child[k].torque};
    }
    // The guide feels the slider at its own point.
    total[3][index(Side::parent)].torque.z() -= h.gap * h.D.y();
  }
};

/// Joint frames of the model file in the plane's axes.
std::array<std::array<Mat3, 2>, 4> joint_frames(double theta, double phi) {
  const Mat3 crank = rotation_about(Axis::z, theta);
  const Mat3 coupler = rotation_about(Axis::z, phi);
  const Mat3 yoke = rotation_from_x_and_z(Vec3::UnitZ(), Vec3::UnitX());
  const Mat3 guide = rotation_from_x_and_z(Vec3::UnitY(), Vec3::UnitX());
  return {{{Mat3::Identity(), crank}, {crank, coupler}, {coupler * yoke, yoke}, {guide, guide}}};
}

/// Off the lines, off the centre, speeding up.
Model made_generic(Model model) {
  model.gravity = Vec3(1.5, -9.4, 0.0);
  model.bodies[1].center_of_mass_L = Vec3(0.06, 0.011, 0.0);
  model.bodies[2].center_of_mass_L = Vec3(0.13, -0.008, 0.0);
  model.bodies[3].center_of_mass_L = Vec3(0.006, 0.009, 0.0);
  model.joints[3].sides[index(Side::parent)].point_L = Vec3(0.05, 0.02, 0.0);
  model.joints[0].drivers[0].law = Polynomial{{0.4, 90.0, 700.0, -2000.0}};
  return model;
}

/// Every wrench of the driven machine on both sides, in both frames, at 400 crank angles over more than three turns.
/// `planar` is the machine in the x-y plane, which the solver meets turned by Q.
void require_driven_forces(const Model& planar, const Mat3& Q, const std::string& what) {
  const Plane plane(planar);
  const Model model = turn_world(planar, Q);
  for (const auto& solver : both_solvers(model)) {
    INFO(what << ", " << solver->name());
    std::vector<WrenchAgreement> wrenches(4, WrenchAgreement(plane.L));
    Agreement driver;
    Agreement turning;
    for (const Sample& sample : run(*solver, 0.15, 1e-10, 400).samples) {
      const TimeFunctionValue law = evaluate(planar.joints[0].drivers[0].law, sample.state.t);
      const ByHand exact = solve_by_hand(plane, law.f, law.fdot, law.fddot);
      const JointWrenchesByHand by_hand(exact);
      const auto frames = joint_frames(law.f, exact.phi);
      for (int k = 0; k < 4; ++k) {
        const JointWrenches& found = sample.evaluation.joints[k];
        for (const Side side : {Side::parent, Side::child}) {
          const Wrench total = by_hand.total[k][index(side)];
          Wrench reaction = total;
          if (k == 0) reaction.torque.setZero();  // the driver's torque is all that acts about the hinge
          const Mat3 to_C = frames[k][index(side)].transpose();
          wrenches[k].add(found.total_on(side).in_global, rotated(Q, total));
          wrenches[k].add(found.reaction_on(side).in_global, rotated(Q, reaction));
          wrenches[k].add(found.total_on(side).in_C, rotated(to_C, total));
          wrenches[k].add(found.reaction_on(side).in_C, rotated(to_C, reaction));
        }
      }
      driver.add(sample.evaluation.joints[0].tau(0), exact.tau);
      turning.add(sample.evaluation.bodies[2].omegadot, Vec3(Q.col(2) * exact.phiddot));
    }
    double worst = std::min(driver.digits(), turning.digits());
    for (const WrenchAgreement& joint : wrenches) worst = std::min(worst, joint.digits());
    tell(what, *solver, worst);
    for (int k = 0; k < 4; ++k) {
      INFO("joint " << planar.joints[k].name);
      CHECK(wrenches[k].digits() >= 12.0);
    }
    CHECK(driver.digits() >= 12.0);
    CHECK(turning.digits() >= 12.0);
  }
}

/// In-plane part of all wrenches of a machine that runs freely, its crank angle and rates taken from the solver: the
/// hand solution gives the forces, and that no driver is needed.
void require_free_forces(const std::string& name) {
  const Model model = read(name);
  const Plane plane(model);
  for (const auto& solver : both_solvers(model)) {
    INFO(name << ", " << solver->name());
    std::vector<WrenchAgreement> wrenches(4, WrenchAgreement(plane.L));
    Agreement moments;  // of the crank about A: the sum of what should cancel
    for (const Sample& sample : run(*solver, 0.1, 1e-10, 200).samples) {
      const double theta = sample.state.q[0](0);
      const ByHand exact = solve_by_hand(plane, theta, sample.state.u[0](0), sample.evaluation.bodies[1].omegadot.z());
      const JointWrenchesByHand by_hand(exact);
      for (int k = 0; k < 4; ++k) {
        for (const Side side : {Side::parent, Side::child}) {
          const Wrench& found = sample.evaluation.joints[k].reaction_on(side).in_global;
          wrenches[k].add(
              in_plane(found.force.head<2>(), found.torque.z()),
              k == 0 ? in_plane(by_hand.total[k][index(side)].force.head<2>(), 0.0) : by_hand.total[k][index(side)]);
        }
      }
      const double turning = cross(plane.r * along(theta), exact.B);
      moments.add(turning - exact.tau, turning);
    }
    double worst = moments.digits();
    for (const WrenchAgreement& joint : wrenches) worst = std::min(worst, joint.digits());
    tell(name + ": forces in the plane", *solver, worst);
    for (int k = 0; k < 4; ++k) {
      INFO("joint " << model.joints[k].name);
      CHECK(wrenches[k].digits() >= 12.0);
    }
    CHECK(moments.digits() >= 12.0);
  }
}

}  // namespace

TEST_CASE("Forces of the driven in-line slider-crank are those of Newton and Euler by hand", "[closed form][quick]") {
  const Model model = read("slider_crank_rigid");
  require_driven_forces(model, Mat3::Identity(), "driven slider-crank, as in its file");
}

TEST_CASE("Forces of a driven offset slider-crank in a tilted plane are those of Newton and Euler by hand",
          "[closed form][quick]") {
  const Mat3 Q = rotation_about(Vec3(Vec3(1.0, -2.0, 0.7).normalized()), 0.9);
  require_driven_forces(made_generic(read("slider_crank_rigid")), Q, "driven slider-crank, offset, tilted");
}

TEST_CASE("The free slider-crank obeys Newton and Euler by hand at every state of its own motion",
          "[closed form][quick]") {
  require_free_forces("slider_crank_rigid_free");
}

TEST_CASE("Three parallel hinges leave out-of-plane reactions open and in-plane ones those of Newton and Euler",
          "[closed form][redundant][quick]") {
  require_free_forces("slider_crank_redundant");
}

TEST_CASE("The redundant slider-crank moves and loads its joints in the plane as the one without redundancy does",
          "[redundant][quick]") {
  const Model redundant = read("slider_crank_redundant");
  const Model plain = read("slider_crank_rigid_free");
  const auto solvers = both_solvers(redundant);
  const auto others = both_solvers(plain);
  for (std::size_t s = 0; s < solvers.size(); ++s) {
    INFO(solvers[s]->name());
    const Trajectory one = run(*solvers[s], 0.1, 1e-11, 100);
    const Trajectory two = run(*others[s], 0.1, 1e-11, 100);
    std::vector<WrenchAgreement> wrenches(4, WrenchAgreement(0.3));
    Agreement motion;
    for (std::size_t n = 0; n < one.samples.size(); ++n) {
      for (int k = 0; k < 4; ++k) {
        const Wrench& found = one.samples[n].evaluation.joints[k].total_on(Side::child).in_global;
        const Wrench& expected = two.samples[n].evaluation.joints[k].total_on(Side::child).in_global;
        wrenches[k].add(in_plane(found.force.head<2>(), found.torque.z()),
                        in_plane(expected.force.head<2>(), expected.torque.z()));
      }
      motion.add(one.samples[n].state.bodies[2].omega, two.samples[n].state.bodies[2].omega);
    }
    double worst = motion.digits();
    for (const WrenchAgreement& joint : wrenches) worst = std::min(worst, joint.digits());
    tell("redundant against plain slider-crank", *solvers[s], worst);
    CHECK(worst >= 10.0);
  }
}

TEST_CASE("Both solvers find exactly the force along the hinges and the torques across them not unique",
          "[redundant][quick]") {
  const Model model = read("slider_crank_redundant");
  // In joint frames; the axes of D's are y, z, x of the plane.
  const std::array<bool, 6> hinge{true, true, false, false, false, true};
  const std::array<bool, 6> guide{true, false, true, false, true, false};
  for (const auto& solver : both_solvers(model)) {
    const Trajectory motion = run(*solver, 0.02, 1e-10, 4);
    for (const Sample& sample : motion.samples) {
      INFO(solver->name() << ", t = " << sample.state.t);
      const RankReport report = solver->rank(sample.state);
      CHECK_FALSE(report.undecided);
      CHECK(report.constraints == 20);
      CHECK(report.rank == 17);
      CHECK(report.degrees_of_freedom == 1);
      for (int k = 0; k < 4; ++k) {
        for (const Side side : {Side::parent, Side::child}) {
          CHECK(report.joints[k].unique[index(side)] == (k == 3 ? guide : hinge));
        }
      }
    }
  }
}

}  // namespace concord::verification
