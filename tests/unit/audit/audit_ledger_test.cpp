#include "compare/audit/audit_ledger.h"

#include <gtest/gtest.h>

#include <functional>

#include "common/joints/catalogue.h"
#include "compare/audit/balance.h"
#include "compare/quantities/needs.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

/// One state of a pendulum with its evaluation, by hand from Newton and Euler, and what the audit says of it once
/// something is spoiled: the model that the audit reads, the state, or the evaluation.
struct AuditBench {
  Model model;
  State state;
  Evaluation evaluation;

  explicit AuditBench(const Model& stated) : model(stated) {
    FakePendulum solver(stated, "by hand");
    state = solver.assemble();
    state.t = 0.2;
    evaluation = solver.evaluate(state);
  }

  [[nodiscard]] AuditReport report() const {
    Auditor auditor(model);
    auditor.add(state, evaluation);
    return auditor.report();
  }

  /// Adds a wrench on the child at the hinge, global axes, and the answer on the parent, to both frames of a wrench.
  void add(std::array<SideWrench, 2>& sides, const Wrench& on_child) const {
    for (const Side side : kSides) {
      const double sign = side == Side::child ? 1.0 : -1.0;
      const Attachment& end = model.joints[0].on(side);
      const Mat3 to_C = place(end, state.bodies[end.body]).A_joint.transpose();
      sides[index(side)].in_global += {sign * on_child.force, sign * on_child.torque};
      sides[index(side)].in_C += {sign * (to_C * on_child.force), sign * (to_C * on_child.torque)};
    }
  }

  [[nodiscard]] Vec3 hinge_axis() const { return model.joints[0].sides[0].C.col(2); }
  [[nodiscard]] Vec3 across() const { return model.joints[0].sides[0].C.col(0); }
};

int count_of(const AuditReport& report, AuditRule rule) { return report.rows[static_cast<std::size_t>(rule)]; }

/// The rule, and no other, must be below its need, and the report must say so.
void expect_only(AuditRule rule, const std::string& where, const AuditReport& report) {
  for (const AuditFinding& finding : report.rules) {
    EXPECT_EQ(finding.holds(), finding.rule != rule) << finding.text();
  }
  EXPECT_FALSE(report.holds());
  EXPECT_EQ(report.worst.rule, rule) << report.worst.text();
  EXPECT_EQ(report.worst.where, where) << report.worst.text();
}

TEST(AuditLedger, EveryRuleHasRowsForAllThatItShouldSee) {
  const AuditReport report = AuditBench(sprung_pendulum_model()).report();
  EXPECT_TRUE(report.holds()) << report.worst.text();
  // A hinge, a strut and a bushing with two ends each, and a load with one.
  EXPECT_EQ(count_of(report, AuditRule::free_body), 6);
  EXPECT_EQ(count_of(report, AuditRule::workless), 12 + 1);
  EXPECT_EQ(count_of(report, AuditRule::both_sides), 2 * 6 + 2 * 6);
  EXPECT_EQ(count_of(report, AuditRule::two_frames), 4 * 6 + 3 * 12);
  EXPECT_EQ(count_of(report, AuditRule::drivers), 1 + 6);
  EXPECT_EQ(count_of(report, AuditRule::force_law), 4 + 3 * 12);
  EXPECT_EQ(count_of(report, AuditRule::kinematics), 18);
  EXPECT_EQ(count_of(report, AuditRule::driver_law), 0);
  EXPECT_EQ(count_of(report, AuditRule::derivatives), 0);

  Model more = pendulum_model();
  more.joints[0].drivers = {{0, ConstantSpeed{0.0, 1.0}}};
  more.couplings = {{"belt", {{0, 0, 0, 1.0}, {0, 0, 0, 2.0}}, 0.0, {}}};
  more.joints.push_back(more.joints[0]);
  more.joints[1].type = joints::find("screw");
  const AuditReport with_more = Auditor(more).report();
  EXPECT_EQ(count_of(with_more, AuditRule::driver_law), 3 + 3 + 3);
  EXPECT_EQ(count_of(with_more, AuditRule::derivatives), 6);
}

TEST(AuditLedger, AMassIsSeenByTheFreeBodyAlone) {
  AuditBench bench(sprung_pendulum_model());
  bench.model.bodies[1].mass *= 1.00001;
  expect_only(AuditRule::free_body, "bob", bench.report());
}

TEST(AuditLedger, AReactionAboutTheHingeIsSeenAsWorkAlone) {
  AuditBench bench(sprung_pendulum_model());
  bench.add(bench.evaluation.joints[0].reaction, {Vec3::Zero(), 1e-4 * bench.hinge_axis()});
  expect_only(AuditRule::workless, "A", bench.report());
}

TEST(AuditLedger, AParentThatFeelsAnotherWrenchIsSeenByBothSidesAlone) {
  AuditBench bench(sprung_pendulum_model());
  for (auto* sides : {&bench.evaluation.joints[0].reaction, &bench.evaluation.joints[0].total}) {
    SideWrench& on_parent = (*sides)[0];
    on_parent.in_global.torque += 1e-4 * bench.across();
    on_parent.in_C.torque += 1e-4 * Vec3::UnitX();
  }
  expect_only(AuditRule::both_sides, "A", bench.report());
}

TEST(AuditLedger, AnElementsParentIsSeenByBothSidesAndItsLaw) {
  AuditBench bench(sprung_pendulum_model());
  SideWrench& on_ground = bench.evaluation.elements[0].on[index(Side::parent)];
  const Attachment& end = *end_of(bench.model.elements[0], Side::parent);
  on_ground.in_global.force += Vec3(0.0, 1e-4, 0.0);
  on_ground.in_C.force += end.C.transpose() * Vec3(0.0, 1e-4, 0.0);
  const AuditReport report = bench.report();
  for (const AuditFinding& finding : report.rules) {
    const bool sees = finding.rule == AuditRule::both_sides || finding.rule == AuditRule::force_law;
    EXPECT_EQ(finding.holds(), !sees) << finding.text();
  }
  EXPECT_EQ(report.worst.where, "strut");
  EXPECT_FALSE(report.elements[0].holds());
  EXPECT_TRUE(report.elements[1].holds());
}

TEST(AuditLedger, AFrameIsSeenByTheTwoFramesAlone) {
  AuditBench joint(sprung_pendulum_model());
  joint.evaluation.joints[0].total[1].in_C.force.y() += 1e-4;
  expect_only(AuditRule::two_frames, "A", joint.report());
  AuditBench element(sprung_pendulum_model());
  element.evaluation.elements[1].on[1].in_C.torque.x() += 1e-4;
  expect_only(AuditRule::two_frames, "rubber", element.report());
}

TEST(AuditLedger, WhatIsNoCoordinateWrenchIsSeenByTheDriversAlone) {
  AuditBench bench(sprung_pendulum_model());
  bench.add(bench.evaluation.joints[0].reaction, {Vec3::Zero(), 1e-4 * bench.across()});
  expect_only(AuditRule::drivers, "A", bench.report());
}

TEST(AuditLedger, ALawIsSeenByTheForceLawAlone) {
  AuditBench strut(sprung_pendulum_model());
  std::get<LineSpring>(strut.model.elements[0].what).law.stiffness *= 1.00001;
  expect_only(AuditRule::force_law, "strut", strut.report());
  AuditBench rubber(sprung_pendulum_model());
  std::get<Bushing>(rubber.model.elements[1].what).damping *= 1.0001;
  expect_only(AuditRule::force_law, "rubber", rubber.report());
  AuditBench load(sprung_pendulum_model());
  std::get<Load>(load.model.elements[2].what).law = Harmonic{0, 1, 5, 0.2001};
  expect_only(AuditRule::force_law, "push", load.report());
  AuditBench hinge(sprung_pendulum_model());
  hinge.model.joints[0].springs[0].law.stiffness *= 1.00001;
  expect_only(AuditRule::force_law, "A", hinge.report());
}

TEST(AuditLedger, AVelocityOffTheHingeIsSeenByTheKinematicsAlone) {
  AuditBench bench(pendulum_model());
  bench.state.bodies[1].v += Vec3(1e-5, -1e-5, 1e-5);
  expect_only(AuditRule::kinematics, "A", bench.report());
}

TEST(AuditLedger, AnAccelerationThatADriverDoesNotAskForIsSeenByItsLawAlone) {
  AuditBench bench(pendulum_model());
  // The start has 0.7 rad and 3.1 rad/s: a law that has them at the time of the state, but no acceleration.
  bench.model.joints[0].drivers = {{0, ConstantSpeed{0.7 - 3.1 * 0.2, 3.1}}};
  const AuditReport report = bench.report();
  expect_only(AuditRule::driver_law, "A", report);
  EXPECT_EQ(report.worst.row, "acceleration of turn_z");
}

TEST(AuditLedger, TheWorstIsTheOneFarthestBelowItsOwnNeed) {
  AuditFinding kept;
  keep_worse(kept, {8.0, 1e-8, 1.0, 0.0, AuditRule::kinematics, "A", "place along x"});
  EXPECT_TRUE(kept.holds()) << "needs " << kAuditByDifferences;
  keep_worse(kept, {8.9, 1e-9, 1.0, 0.0, AuditRule::free_body, "bob", "F_x"});
  EXPECT_EQ(kept.where, "bob");
  EXPECT_FALSE(kept.holds());
  keep_worse(kept, {0.0, 0.0, 0.0, 0.0, AuditRule::free_body, "nobody", ""});
  EXPECT_EQ(kept.where, "bob") << "a finding without a row says nothing";
}

TEST(AuditLedger, WhatCarriesNothingIsHeldAgainstTheWeight) {
  // A bob that falls along a guide: its joint carries round-off.
  Model model = pendulum_model();
  model.joints[0].type = joints::find("translational");
  AuditBench bench(pendulum_model());
  bench.model = model;
  for (BodyState& body : bench.state.bodies) body.v.setZero();
  bench.state.bodies[1].omega.setZero();
  bench.state.q = {VecX::Zero(1)};
  const Vec3 along = model.joints[0].sides[0].C.col(2);
  bench.model.gravity = 9.0 * along;
  bench.evaluation.bodies[1].vdot = bench.model.gravity;
  bench.evaluation.bodies[1].omegadot.setZero();
  JointWrenches& wrenches = bench.evaluation.joints[0];
  wrenches.tau = VecX::Zero(1);
  wrenches.shares.fill(wrenches.tau);
  for (auto* sides : {&wrenches.reaction, &wrenches.total}) {
    for (SideWrench& side : *sides) side = {};
  }
  wrenches.reaction[1].in_C.force = Vec3(1e-17, -2e-17, 1e-17);
  const AuditReport report = bench.report();
  for (const AuditRule rule : {AuditRule::free_body, AuditRule::workless, AuditRule::two_frames, AuditRule::drivers}) {
    const AuditFinding& finding = report.rules[static_cast<std::size_t>(rule)];
    EXPECT_TRUE(finding.holds()) << finding.text();
  }
  EXPECT_TRUE(report.rules[static_cast<std::size_t>(AuditRule::two_frames)].floored);
}

}  // namespace
}  // namespace concord::compare
