#include "compare/audit/balance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "common/decompositions.h"
#include "common/joints/catalogue.h"
#include "common/rotation.h"
#include "compare/audit/energy.h"

namespace concord::compare {
namespace {

/// Numbers that are the same in every run.
class Numbers {
 public:
  double operator()() { return uniform_(generator_); }
  Vec3 vector() { return columns(1); }
  VecX vector(int n) { return columns(n).row(0).transpose(); }
  Mat3X columns(int n) {
    return Mat3X::NullaryExpr(3, n, [this] { return (*this)(); });
  }
  Mat3 rotation() {
    const double angle = 2.0 * (*this)();
    return rotation_about(vector().normalized(), angle);
  }

 private:
  std::mt19937 generator_{5};
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

Vec4 euler_parameters(const Mat3& A) {
  const Eigen::Quaterniond quaternion(A);
  return {quaternion.w(), quaternion.x(), quaternion.y(), quaternion.z()};
}

Mat3 turned_by(const Vec3& theta) { return rotation_about(theta.normalized(), theta.norm()); }

/// Vector w of a skew matrix w~, from its skew part.
Vec3 axial(const Mat3& W) { return 0.5 * Vec3(W(2, 1) - W(1, 2), W(0, 2) - W(2, 0), W(1, 0) - W(0, 1)); }

Attachment attach(int body, int n_modes, Numbers& number) {
  Attachment side;
  side.body = body;
  side.point_L = number.vector();
  side.C = number.rotation();
  side.Psi_t_L = 0.3 * number.columns(n_modes);
  side.Psi_r_L = number.columns(n_modes);
  return side;
}

/// Ground - universal - flexible body - cylindrical, driven in its slide - rigid body; all frames tilted.
Model make_machine(Numbers& number) {
  Model model;
  model.gravity = Vec3(1.3, -9.0, 3.1);
  model.bodies.resize(3);
  model.bodies[0].name = "ground";
  Body& flexible = model.bodies[1];
  flexible.name = "arm";
  flexible.modal.emplace();
  for (int k = 0; k < 20; ++k) {
    flexible.modal->mass_points.push_back({1.1 + number(), number.vector(), 0.3 * number.columns(3)});
  }
  const Mat3 root = number.columns(3);
  flexible.modal->stiffness = 300.0 * root * root.transpose();
  flexible.modal->damping = 0.01 * flexible.modal->stiffness;
  Body& rigid = model.bodies[2];
  rigid.name = "slide";
  rigid.mass = 2.3;
  rigid.center_of_mass_L = number.vector();
  const Mat3 axes = number.rotation();
  rigid.inertia_L = axes * Vec3(0.5, 0.8, 1.1).asDiagonal() * axes.transpose();
  model.joints.resize(2);
  model.joints[0].name = "A";
  model.joints[0].type = joints::find("universal");
  model.joints[0].sides = {attach(0, 0, number), attach(1, 3, number)};
  model.joints[1].name = "B";
  model.joints[1].type = joints::find("cylindrical");
  model.joints[1].sides = {attach(1, 3, number), attach(2, 0, number)};
  model.joints[1].drivers = {{0, ConstantSpeed{0.0, 1.0}}};
  return model;
}

/// Place and rotation of a joint frame as functions of a body's pose and modal coordinates, written anew.
struct Frame {
  Vec3 r_P;
  Mat3 A_joint;
};
Frame frame_on(const Attachment& side, const Vec3& r, const Mat3& A, const VecX& a) {
  const Vec3 theta = side.Psi_r_L * a;
  const Mat3 R = theta.norm() > 0.0 ? turned_by(theta) : Mat3(Mat3::Identity());
  return {r + A * (side.point_L + side.Psi_t_L * a), A * R * side.C};
}

/// Change of joint position and orientation for a unit of each of the body's 6 + m virtual displacements, by
/// differences.
MatX frame_directions(const Attachment& side, const Vec3& r, const Mat3& A, const VecX& a) {
  const double step = 1e-6;
  const auto moved = [&](int k, double by) {
    if (k < 3) return frame_on(side, r + by * Vec3::Unit(k), A, a);
    if (k < 6) return frame_on(side, r, turned_by(by * Vec3::Unit(k - 3)) * A, a);
    return frame_on(side, r, A, a + by * VecX::Unit(a.size(), k - 6));
  };
  MatX directions(6, 6 + a.size());
  const Mat3 here = frame_on(side, r, A, a).A_joint;
  for (int k = 0; k < directions.cols(); ++k) {
    const Frame plus = moved(k, step);
    const Frame minus = moved(k, -step);
    const Mat3 turning = (plus.A_joint - minus.A_joint) / (2.0 * step) * here.transpose();
    directions.col(k) << (plus.r_P - minus.r_P) / (2.0 * step), axial(turning);
  }
  return directions;
}

/// A state of the machine with made-up wrenches that are ideal but for the driver, and the accelerations that they
/// cause, found by brute force: virtual work of every mass point and joint frame, displaced by differences.
struct Bench {
  Numbers number;
  Model model = make_machine(number);
  State state;
  Evaluation evaluation;

  Bench() {
    make_state();
    make_wrenches();
    evaluation.bodies.resize(3);
    for (int body = 1; body < 3; ++body) accelerate(body);
  }

  Mat3 A(int body) const {
    const Vec4& p = state.bodies[body].p;
    return Eigen::Quaterniond(p(0), p(1), p(2), p(3)).toRotationMatrix();
  }

  Frame frame(const Attachment& side) const {
    const BodyState& body = state.bodies[side.body];
    return frame_on(side, body.r, A(side.body), body.a);
  }

  void make_state() {
    state.t = 0.7;
    state.bodies.resize(3);
    state.bodies[0].a = state.bodies[0].adot = VecX(0);
    for (int body = 1; body < 3; ++body) {
      BodyState& motion = state.bodies[body];
      motion.a = 0.3 * number.vector(model.bodies[body].n_modes());
      motion.adot = number.vector(model.bodies[body].n_modes());
      motion.v = number.vector();
      motion.omega = 2.0 * number.vector();
    }
    put_child(model.joints[0], Vec3::Zero(), rotation_about(Axis::x, 0.7) * rotation_about(Axis::y, -0.5));
    put_child(model.joints[1], Vec3(0.0, 0.0, 0.4), rotation_about(Axis::z, 1.1));
  }

  /// Puts the joint's child where d and R want it.
  void put_child(const Joint& joint, const Vec3& d, const Mat3& R) {
    const Frame parent = frame(joint.on(Side::parent));
    BodyState& child = state.bodies[joint.on(Side::child).body];
    const Frame unplaced = frame_on(joint.on(Side::child), Vec3::Zero(), Mat3::Identity(), child.a);
    const Mat3 A_child = parent.A_joint * R * unplaced.A_joint.transpose();
    child.p = euler_parameters(A_child);
    child.r = parent.r_P + parent.A_joint * d - A_child * unplaced.r_P;
  }

  void make_wrenches() {
    evaluation.joints.resize(2);
    const Frame yoke = frame(model.joints[0].on(Side::parent));
    const Vec3 x = yoke.A_joint.col(0);
    const Vec3 y = frame(model.joints[0].on(Side::child)).A_joint.col(1);
    set_wrenches(0, {20.0 * number.vector(), 7.0 * x.cross(y)}, Wrench{});
    evaluation.joints[0].tau = VecX::Zero(2);
    const Vec3 z = frame(model.joints[1].on(Side::parent)).A_joint.col(2);
    set_wrenches(1, {30.0 * z.cross(number.vector()), 9.0 * z.cross(number.vector())}, {4.0 * z, Vec3::Zero()});
    evaluation.joints[1].tau = Vec3(4.0, 0.0, 0.0).head<2>();
    for (JointWrenches& wrenches : evaluation.joints) wrenches.shares.fill(VecX::Zero(2));
    evaluation.joints[1].shares[index(Actor::driver)] = evaluation.joints[1].tau;
  }

  /// Fills both sides and frames from the reaction and the driver's wrench on the child at P_i, global axes.
  void set_wrenches(int joint, const Wrench& reaction, const Wrench& driver) {
    Wrench total = reaction;
    total += driver;
    JointWrenches& wrenches = evaluation.joints[joint];
    set_sides(joint, reaction, wrenches.reaction);
    set_sides(joint, total, wrenches.total);
  }

  void set_sides(int joint, const Wrench& on_child, std::array<SideWrench, 2>& sides) const {
    const Frame parent = frame(model.joints[joint].on(Side::parent));
    const Frame child = frame(model.joints[joint].on(Side::child));
    const Vec3 shifted = on_child.torque + (child.r_P - parent.r_P).cross(on_child.force);
    sides[0].in_global = {-on_child.force, -shifted};
    sides[1].in_global = on_child;
    sides[0].in_C = {parent.A_joint.transpose() * sides[0].in_global.force,
                     parent.A_joint.transpose() * sides[0].in_global.torque};
    sides[1].in_C = {child.A_joint.transpose() * on_child.force, child.A_joint.transpose() * on_child.torque};
  }

  /// Mass points of either kind of body; a rigid one as a cloud that is not the auditor's: eight points at the corners
  /// of a box.
  std::vector<MassPoint> cloud(int body) const {
    const Body& inertia = model.bodies[body];
    if (inertia.modal) return inertia.modal->mass_points;
    const Eigen::SelfAdjointEigenSolver<Mat3> principal(inertia.inertia_L);
    const Vec3& I = principal.eigenvalues();
    const Vec3 squares = (0.5 * I.sum() - I.array()) / inertia.mass;
    std::vector<MassPoint> points;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 signs(corner & 1 ? 1.0 : -1.0, corner & 2 ? 1.0 : -1.0, corner & 4 ? 1.0 : -1.0);
      const Vec3 from_center = principal.eigenvectors() * signs.cwiseProduct(squares.cwiseSqrt());
      points.push_back({inertia.mass / 8.0, inertia.center_of_mass_L + from_center, Mat3X(3, 0)});
    }
    return points;
  }

  /// Solves the direct sum over the mass points for the body's accelerations.
  void accelerate(int body) {
    const BodyState& motion = state.bodies[body];
    const int size = 6 + static_cast<int>(motion.a.size());
    VecX Y(size);
    Y << motion.v, motion.omega, motion.adot;
    MatX mass = MatX::Zero(size, size);
    VecX force = VecX::Zero(size);
    for (const MassPoint& point : cloud(body)) {
      Attachment place;
      place.point_L = point.s0_L;
      place.Psi_t_L = point.Psi_t_L;
      place.Psi_r_L = Mat3X::Zero(3, size - 6);
      // At constant Y = [v; omega; adot] a mass point accelerates by Bdot Y: second difference of its path.
      const auto path = [&](double t) {
        const Mat3 turned = turned_by(t * motion.omega) * A(body);
        return Vec3(t * motion.v + turned * (place.point_L + place.Psi_t_L * (motion.a + t * motion.adot)));
      };
      const double step = 1e-4;
      const Vec3 bias = (path(step) - 2.0 * path(0.0) + path(-step)) / (step * step);
      const MatX B = frame_directions(place, motion.r, A(body), motion.a).topRows(3);
      mass += point.mass * B.transpose() * B;
      force += point.mass * B.transpose() * (model.gravity - bias);
    }
    for (int joint = 0; joint < 2; ++joint) {
      for (const Side side : {Side::parent, Side::child}) {
        const Attachment& attachment = model.joints[joint].on(side);
        if (attachment.body != body) continue;
        const MatX directions = frame_directions(attachment, motion.r, A(body), motion.a);
        force += directions.transpose() * evaluation.joints[joint].total_on(side).in_global.vector();
      }
    }
    if (model.bodies[body].modal) {
      const ModalData& modal = *model.bodies[body].modal;
      force.tail(size - 6) -= modal.stiffness * motion.a + modal.damping * motion.adot;
    }
    const VecX Ydot = solve_square(mass, force);
    evaluation.bodies[body] = {Ydot.head<3>(), Ydot.segment<3>(3), Ydot.tail(size - 6)};
  }

  AuditReport audit() const {
    Auditor auditor(model);
    auditor.add(state, evaluation);
    return auditor.report();
  }
};

double digits(const AuditReport& report, AuditRule rule) { return report.rules[static_cast<std::size_t>(rule)].digits; }

TEST(Balance, BruteForceStateBalances) {
  const AuditReport report = Bench().audit();
  // The differences of the brute force are good for seven digits; everything else is exact.
  EXPECT_GT(digits(report, AuditRule::free_body), 7.0) << report.worst.text();
  EXPECT_GT(digits(report, AuditRule::workless), 14.0);
  EXPECT_GT(digits(report, AuditRule::both_sides), 14.0);
  EXPECT_GT(digits(report, AuditRule::two_frames), 14.0);
  EXPECT_GT(digits(report, AuditRule::drivers), 14.0);
  EXPECT_EQ(report.states, 1);
  ASSERT_EQ(report.bodies.size(), 3U);
  ASSERT_EQ(report.joints.size(), 2U);
  EXPECT_EQ(report.bodies[kGround].digits, 16.0);
}

/// A seeded error must be seen, by the rule that is there for it, at the body or joint where it was planted.
void expect_seen(const Bench& bench, AuditRule rule, const std::string& where, double at_most = 4.0) {
  const AuditReport report = bench.audit();
  const AuditFinding& finding = report.rules[static_cast<std::size_t>(rule)];
  EXPECT_LT(finding.digits, at_most) << finding.text();
  EXPECT_EQ(finding.where, where) << finding.text();
  EXPECT_LE(report.digits(), finding.digits);
}

TEST(Balance, SeesAMissingGyroscopicTerm) {
  Bench bench;
  const BodyState& motion = bench.state.bodies[2];
  const Mat3 I = bench.A(2) * bench.model.bodies[2].inertia_L * bench.A(2).transpose();
  bench.evaluation.bodies[2].omegadot += I.inverse() * motion.omega.cross(I * motion.omega);
  expect_seen(bench, AuditRule::free_body, "slide", 2.0);
}

TEST(Balance, SeesAMassThatIsOffByATenthOfAPercent) {
  Bench bench;
  bench.model.bodies[2].mass *= 1.001;
  expect_seen(bench, AuditRule::free_body, "slide");
}

TEST(Balance, SeesAWrongInertia) {
  Bench bench;
  bench.model.bodies[2].inertia_L *= 1.001;
  expect_seen(bench, AuditRule::free_body, "slide", 5.0);
}

TEST(Balance, SeesAForgottenModalAcceleration) {
  Bench bench;
  bench.evaluation.bodies[1].addot(2) *= 1.01;
  expect_seen(bench, AuditRule::free_body, "arm");
}

TEST(Balance, SeesAForgottenModalDamping) {
  Bench bench;
  bench.model.bodies[1].modal->damping.setZero();
  expect_seen(bench, AuditRule::free_body, "arm");
}

TEST(Balance, SeesRotationRowsThatAreOffByAPercent) {
  Bench bench;
  bench.model.joints[1].sides[0].Psi_r_L.row(1) *= 1.01;
  expect_seen(bench, AuditRule::free_body, "arm");
}

TEST(Balance, SeesAWrenchAtTheUndeformedPoint) {
  Bench bench;
  const Attachment& side = bench.model.joints[0].on(Side::child);
  const Vec3 slip = bench.A(1) * side.Psi_t_L * bench.state.bodies[1].a;
  const Wrench& now = bench.evaluation.joints[0].reaction_on(Side::child).in_global;
  bench.set_wrenches(0, {now.force, now.torque + slip.cross(now.force)}, Wrench{});
  expect_seen(bench, AuditRule::free_body, "arm", 3.0);
  expect_seen(bench, AuditRule::workless, "A", 2.0);
}

TEST(Balance, SeesAReactionAlongAHinge) {
  Bench bench;
  bench.evaluation.joints[0].reaction[1].in_C.torque.y() += 1e-3;
  expect_seen(bench, AuditRule::workless, "A", 5.0);
}

TEST(Balance, SeesTheParentsWrenchTakenAtTheChildsPoint) {
  Bench bench;
  for (auto* sides : {&bench.evaluation.joints[1].reaction, &bench.evaluation.joints[1].total}) {
    (*sides)[0].in_global.torque = -(*sides)[1].in_global.torque;
  }
  expect_seen(bench, AuditRule::both_sides, "B", 2.0);
}

TEST(Balance, SeesTheParentsWrenchWithTheChildsSign) {
  Bench bench;
  bench.evaluation.joints[0].reaction[0] = bench.evaluation.joints[0].reaction[1];
  expect_seen(bench, AuditRule::both_sides, "A", 1.0);
}

TEST(Balance, SeesATransposedJointFrame) {
  Bench bench;
  const Frame child = bench.frame(bench.model.joints[1].on(Side::child));
  Wrench& in_C = bench.evaluation.joints[1].total[1].in_C;
  in_C.torque = child.A_joint * bench.evaluation.joints[1].total[1].in_global.torque;
  expect_seen(bench, AuditRule::two_frames, "B", 2.0);
}

TEST(Balance, SeesADriverForceThatIsNotInTheWrench) {
  Bench bench;
  bench.evaluation.joints[1].tau(0) = -4.0;
  expect_seen(bench, AuditRule::drivers, "B", 2.0);
}

TEST(Balance, SeesANumberThatIsNone) {
  Bench bench;
  Auditor auditor(bench.model);
  Evaluation broken = bench.evaluation;
  broken.bodies[2].vdot.x() = std::nan("");
  auditor.add(bench.state, broken);
  auditor.add(bench.state, bench.evaluation);
  EXPECT_EQ(auditor.report().bodies[2].digits, 0.0);
  EXPECT_EQ(auditor.report().digits(), 0.0);
}

TEST(Balance, AJointIsAsGoodAsTheBodiesThatItJoins) {
  Bench bench;
  bench.model.bodies[2].mass *= 1.001;
  const AuditReport report = bench.audit();
  EXPECT_GT(report.bodies[1].digits, 7.0);
  EXPECT_EQ(report.bodies[2].rule, AuditRule::free_body);
  // The made-up motions of the bench do not obey its joints; what is left once they are put aside is the body's fault.
  EXPECT_LE(report.joints[1].digits, report.bodies[2].digits);
  bench.model.joints[0].type = bench.model.joints[1].type = joints::find("free");
  bench.evaluation.joints[0].tau = bench.evaluation.joints[1].tau = VecX::Zero(6);
  for (JointWrenches& wrenches : bench.evaluation.joints) wrenches.shares.fill(VecX::Zero(6));
  bench.model.joints[1].drivers.clear();
  for (JointWrenches& wrenches : bench.evaluation.joints) wrenches.reaction = wrenches.total = {};
  const AuditReport free = bench.audit();
  EXPECT_EQ(free.joints[1].digits, free.bodies[2].digits);
  EXPECT_EQ(free.joints[1].where, "slide");
}

TEST(Balance, FindingsSayWhereAndWhen) {
  Bench bench;
  bench.evaluation.joints[1].tau(0) = bench.evaluation.joints[1].shares[index(Actor::driver)](0) = -4.0;
  EXPECT_THAT(bench.audit().worst.text(),
              ::testing::StartsWith("drivers: B, tau, t = 0.7 s: residual 8.00e+00, scale"));
}

TEST(Balance, AShareThatALawDoesNotGiveIsFound) {
  for (const auto& [actor, name] : {std::pair{Actor::driver, "tau"}, std::pair{Actor::motor, "motor"},
                                    std::pair{Actor::spring, "spring"}, std::pair{Actor::damper, "damper"}}) {
    Bench bench;
    bench.evaluation.joints[1].shares[index(actor)](0) += 0.5;
    if (actor != Actor::driver) bench.evaluation.joints[1].shares[index(Actor::driver)](0) -= 0.5;
    EXPECT_THAT(bench.audit().worst.text(),
                ::testing::StartsWith(std::string("force law: B, ") + name + ", t = 0.7 s: residual 5.00e-01"));
  }
}

TEST(Balance, ScalesArePeaksOverAllStates) {
  Bench bench;
  Auditor auditor(bench.model);
  auditor.add(bench.state, bench.evaluation);
  // At rest nothing but gravity acts; an error that is small beside the peak counts little.
  State other = bench.state;
  other.t = 0.9;
  Evaluation error = bench.evaluation;
  error.bodies[2].vdot.x() += 1e-4;
  auditor.add(other, error);
  const AuditFinding finding = auditor.report().bodies[2];
  EXPECT_DOUBLE_EQ(finding.t, 0.9);
  EXPECT_EQ(finding.row.substr(0, 1), "F");
  EXPECT_NEAR(finding.residual, 2.3e-4, 1e-6);
}

/// A symmetric top in free fall, turning steadily about its angular momentum: Omega n + s e, with the spin s that makes
/// it free of torque; the body's origin is not its centre of mass.
struct FreeTop {
  Model model;
  Vec3 n = Vec3(0.2, 0.5, 0.9).normalized();
  double Omega = 3.1;

  FreeTop() {
    model.gravity = Vec3(0.4, -9.8, 1.0);
    model.bodies.resize(2);
    Body& top = model.bodies[1];
    top.name = "top";
    top.mass = 1.7;
    top.center_of_mass_L = Vec3(0.3, -0.2, 0.5);
    top.inertia_L = Vec3(0.4, 0.4, 0.7).asDiagonal();
    model.joints.resize(1);
    model.joints[0].name = "free";
    model.joints[0].type = joints::find("free");
    model.joints[0].sides[1].body = 1;
  }

  Sample at(double t) const {
    const Mat3 A0 = rotation_about(Vec3(1.0, 0.3, -0.4).normalized(), 0.8);
    const double cosine = n.dot(A0.col(2));
    const double s = Omega * cosine * (0.4 - 0.7) / 0.7;
    const Mat3 A = rotation_about(n, Omega * t) * A0 * rotation_about(Axis::z, s * t);
    const Vec3 e = A.col(2);
    Sample sample;
    sample.state.t = t;
    sample.state.bodies.resize(2);
    sample.state.bodies[0].a = sample.state.bodies[0].adot = VecX(0);
    BodyState& top = sample.state.bodies[1];
    const Vec3 c = A * model.bodies[1].center_of_mass_L;
    top.a = top.adot = VecX(0);
    top.p = euler_parameters(A);
    top.omega = Omega * n + s * e;
    const Vec3 omegadot = Omega * s * n.cross(e);
    top.r = Vec3(1.0, 2.0, 3.0) * t + 0.5 * t * t * model.gravity - c;
    top.v = Vec3(1.0, 2.0, 3.0) + t * model.gravity - top.omega.cross(c);
    sample.evaluation.bodies.resize(2);
    sample.evaluation.bodies[1] = {model.gravity - omegadot.cross(c) - top.omega.cross(top.omega.cross(c)), omegadot,
                                   VecX(0)};
    sample.evaluation.joints.resize(1);
    sample.evaluation.joints[0].tau = VecX::Zero(6);
    sample.evaluation.joints[0].shares.fill(VecX::Zero(6));
    return sample;
  }

  Trajectory run() const {
    Trajectory trajectory;
    for (int k = 0; k <= 20; ++k) trajectory.samples.push_back(at(0.1 * k));
    return trajectory;
  }
};

TEST(Balance, AFreeTopBalances) {
  const FreeTop top;
  Auditor auditor(top.model);
  for (const Sample& sample : top.run().samples) auditor.add(sample.state, sample.evaluation);
  EXPECT_GT(auditor.report().digits(), 14.5) << auditor.report().worst.text();
  EXPECT_EQ(auditor.report().states, 21);
}

TEST(MechanicalEnergy, OfARigidBodyIsKoenigs) {
  const FreeTop top;
  const Sample sample = top.at(0.9);
  const BodyState& body = sample.state.bodies[1];
  const Mat3 A = Eigen::Quaterniond(body.p(0), body.p(1), body.p(2), body.p(3)).toRotationMatrix();
  const Vec3 c = A * top.model.bodies[1].center_of_mass_L;
  const Vec3 omega_L = A.transpose() * body.omega;
  const double kinetic = 0.5 * 1.7 * (body.v + body.omega.cross(c)).squaredNorm() +
                         0.5 * omega_L.dot(top.model.bodies[1].inertia_L * omega_L);
  const double potential = -1.7 * top.model.gravity.dot(body.r + c);
  EXPECT_NEAR(mechanical_energy(top.model, sample.state), kinetic + potential, 1e-13 * kinetic);
}

TEST(MechanicalEnergy, CountsModesOnce) {
  const Bench bench;
  State shifted = bench.state;
  shifted.bodies[1].adot.setZero();
  shifted.bodies[1].v.setZero();
  shifted.bodies[1].omega.setZero();
  State straight = shifted;
  straight.bodies[1].a.setZero();
  const ModalData& modal = *bench.model.bodies[1].modal;
  const VecX& a = shifted.bodies[1].a;
  double lifted = 0.0;
  for (const MassPoint& point : modal.mass_points) {
    lifted -= point.mass * bench.model.gravity.dot(bench.A(1) * point.Psi_t_L * a);
  }
  const double gained = mechanical_energy(bench.model, shifted) - mechanical_energy(bench.model, straight);
  EXPECT_NEAR(gained, lifted + 0.5 * a.dot(modal.stiffness * a), 1e-11);
}

TEST(AuditEnergy, OfAFreeTopIsKept) {
  const FreeTop top;
  const EnergyReport report = audit_energy(top.model, top.run());
  EXPECT_LT(report.relative(), 1e-14);
  EXPECT_GT(report.scale, 1.0);
}

Model body_in_gravity() {
  Model model;
  model.gravity = {0.0, 0.0, -9.81};
  model.bodies.resize(2);
  model.bodies[1].mass = 1.3;
  model.bodies[1].inertia_L = Mat3::Identity();
  return model;
}

/// That body at time t, at a height and a speed upwards.
Sample at_height(double t, double height, double speed) {
  Sample sample;
  sample.state.t = t;
  sample.state.bodies.resize(2);
  sample.state.bodies[1].r.z() = height;
  sample.state.bodies[1].v.z() = speed;
  return sample;
}

TEST(AuditEnergy, AFallFromFarUpIsKeptAsFarAsItsHeightResolves) {
  const Model model = body_in_gravity();
  Trajectory trajectory;
  for (const double t : {0.0, 1e-3, 2e-3}) {
    trajectory.samples.push_back(at_height(t, 1.7e6 - 0.5 * 9.81 * t * t, -9.81 * t));
  }
  EXPECT_LT(audit_energy(model, trajectory).relative(), 1e-8);
  trajectory.samples.back().state.bodies[1].v.z() *= 1.01;
  EXPECT_GT(audit_energy(model, trajectory).relative(), 1e-3);
}

/// A body that stands 3 m above the origin: what it may lose by round-off, and what is more than that.
TEST(AuditEnergy, AStandingBodyMayLoseARoundingInEachStep) {
  const Model model = body_in_gravity();
  Trajectory trajectory;
  trajectory.statistics.steps = 400;
  for (const double t : {0.0, 0.5, 1.0}) {
    trajectory.samples.push_back(at_height(t, 3.0, 0.0));
  }
  const double terms = 1.3 * 9.81 * 3.0;
  trajectory.samples.back().work = 400.0 * 1e-16 * terms;
  const EnergyReport standing = audit_energy(model, trajectory);
  EXPECT_EQ(standing.error, 0.0);
  EXPECT_DOUBLE_EQ(standing.drift, 400.0 * 1e-16 * terms) << "what is told is the drift itself";
  EXPECT_EQ(standing.t_drift, 1.0);
  EXPECT_GT(standing.round_off, standing.drift);
  EXPECT_EQ(drift_text({.error = 0.0, .scale = 20.0, .drift = 1.5e-12, .t_drift = 0.25, .round_off = 3e-10}, 1e-11),
            "1.5e-12 J at t = 0.25 s, allowed 5.0e-10 J");
  trajectory.samples.back().work = 400.0 * 4e-16 * terms;
  EXPECT_GT(audit_energy(model, trajectory).error, 0.0);
  trajectory.samples.back().work = 400.0 * 1e-16 * terms;
  for (Sample& sample : trajectory.samples) sample.state.bodies[1].v.z() = 0.1;
  EXPECT_GT(audit_energy(model, trajectory).error, 0.0) << "what moves is rounded either way";
}

TEST(AuditEnergy, SeesEnergyThatNobodyGave) {
  const FreeTop top;
  Trajectory trajectory = top.run();
  trajectory.samples[7].state.bodies[1].v *= 1.0 + 1e-6;
  const EnergyReport report = audit_energy(top.model, trajectory);
  EXPECT_GT(report.relative(), 1e-7);
  EXPECT_DOUBLE_EQ(report.t, 0.7);
  trajectory = top.run();
  trajectory.samples[3].work = 0.5;
  EXPECT_NEAR(audit_energy(top.model, trajectory).error, 0.5, 1e-12);
}

}  // namespace
}  // namespace concord::compare
