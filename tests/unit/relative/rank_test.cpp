#include "relative/rank/rank.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "machines.h"
#include "relative/rank/row_rank.h"
#include "relative/solver.h"
#include "relative/start/assembly.h"

namespace concord::relative {
namespace {

RankReport report_of(const Model& model) {
  Equations equations(model);
  Assembly assembly(equations);
  const Coordinates start = assembly.start();
  return analyze_rank(assembly.scaled(), start);
}

std::string flags(const JointUniqueness& joint, Side side) {
  std::string text;
  for (const bool unique : joint.unique[index(side)]) text += unique ? 'u' : '-';
  return text;
}

TEST(Rank, OfAFullLoopIsComplete) {
  for (const bool flexible : {false, true}) {
    const RankReport report = report_of(test::spatial_slider_crank(flexible));
    EXPECT_EQ(report.constraints, 17);
    EXPECT_EQ(report.rank, 17);
    EXPECT_EQ(report.degrees_of_freedom, flexible ? 4 : 1);
    EXPECT_FALSE(report.undecided);
    for (const JointUniqueness& joint : report.joints) EXPECT_EQ(flags(joint, Side::child), "uuuuuu");
  }
}

/// Loop by loop as by all rows at once.
TEST(Rank, OfClearLoopsIsThatOfTheirRows) {
  for (const Model& model : {test::ladder(false, 8), test::spatial_slider_crank(true)}) {
    Equations equations(model);
    Assembly assembly(equations);
    const RankReport report = analyze_rank(assembly.scaled(), assembly.start());
    const std::vector<int>& columns = assembly.scaled().free_columns();
    const MatX Phi = assembly.scaled().rows(columns);
    EXPECT_EQ(report.constraints - report.rank, Phi.rows() - RowRank(Phi).rank());
    EXPECT_EQ(report.degrees_of_freedom, static_cast<int>(columns.size()) - RowRank(Phi).rank());
    const double kept = RowRank(Phi).relative_singular_value(static_cast<int>(Phi.rows()));
    EXPECT_NEAR(report.smallest_kept, kept, 0.02 * kept);
    EXPECT_EQ(report.largest_dropped, 0.0);
    EXPECT_FALSE(report.undecided);
  }
}

TEST(Rank, OfAFourBarLacksThreeAndLeavesThePlaneUnique) {
  Model model = test::four_bar();
  for (int cut = -1; cut < 4; ++cut) {
    for (int k = 0; k < 4; ++k) model.joints[k].named_as_cut = k == cut;
    const RankReport report = report_of(model);
    EXPECT_EQ(report.constraints, 20);
    EXPECT_EQ(report.rank, 17);
    EXPECT_EQ(report.degrees_of_freedom, 1);
    EXPECT_FALSE(report.undecided);
    EXPECT_GT(report.smallest_kept, 1e-3);
    EXPECT_LT(report.largest_dropped, 1e-14);
    for (const JointUniqueness& joint : report.joints) {
      // The hinge axis is z: forces in the plane are unique, and the torque about the hinge, which is zero.
      EXPECT_EQ(flags(joint, Side::child), "uu---u") << cut;
      EXPECT_EQ(flags(joint, Side::parent), "uu---u") << cut;
    }
  }
}

TEST(Rank, CountsDriversWithTheConstraints) {
  for (const int driven : {0, 3}) {
    Model model = test::spatial_slider_crank(false);
    test::release(model.joints[0]);
    const double q = model.joints[driven].start[0].q(0);
    model.joints[driven].drivers.push_back({0, ConstantSpeed{q, 0.3}});
    const RankReport report = report_of(model);
    EXPECT_EQ(report.constraints, 18);
    EXPECT_EQ(report.rank, 18);
    EXPECT_EQ(report.degrees_of_freedom, 0);
    const std::unique_ptr<Solver> solver = make_solver(model);
    EXPECT_EQ(solver->tangent(solver->assemble()).cols(), 0);
  }
}

TEST(Rank, OfATreeIsComplete) {
  const Model model = test::tree_of_all_joints(true);
  const RankReport report = report_of(model);
  EXPECT_EQ(report.rank, report.constraints);
  EXPECT_EQ(report.constraints, 5 + 5 + 4 + 3 + 4 + 0 + 6 + 5);
  int modes = 0;
  for (const Body& body : model.bodies) modes += body.n_modes();
  EXPECT_EQ(report.degrees_of_freedom, 8 * 6 - report.constraints + modes);
}

/// Gives every body the velocities of one column, v in units of the length.
void set_velocities(const Model& model, const VecX& column, double length, State& state) {
  Eigen::Index row = 0;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    BodyState& body = state.bodies[i];
    body.v = length * column.segment<3>(row);
    body.omega = column.segment<3>(row + 3);
    body.adot = column.segment(row + 6, body.adot.size());
    row += 6 + body.adot.size();
  }
}

class PermittedVelocities : public ::testing::TestWithParam<int> {
 protected:
  static Model machine() {
    if (GetParam() == 0) return test::tree_of_all_joints(true);
    if (GetParam() == 1) return test::four_bar();
    if (GetParam() == 2) return test::pair(*test::type_named("spiral"), 3);
    Model model = test::spatial_slider_crank(true);
    if (GetParam() == 4) {
      test::release(model.joints[0]);
      model.joints[0].drivers.push_back({0, ConstantSpeed{model.joints[0].start[0].q(0), 3.0}});
    }
    return model;
  }
};

TEST_P(PermittedVelocities, AreAsManyAsTheFreedomsAndStrainNoJoint) {
  const Model model = machine();
  const std::unique_ptr<Solver> solver = make_solver(model);
  State state = solver->assemble();
  const MatX V = solver->tangent(state);
  ASSERT_EQ(V.cols(), solver->rank(state).degrees_of_freedom);
  Kinematics kinematics(model);
  MatX in_units = V;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const Span& modes = kinematics.topology().modes[BodyIndex(i)];
    in_units.middleRows(kinematics.first_row(BodyIndex(i)) + 6, modes.n_u).array().colwise() /=
        kinematics.size().speeds().segment(modes.first_u, modes.n_u).array();
  }
  EXPECT_LT((in_units.transpose() * in_units - MatX::Identity(V.cols(), V.cols())).norm(), 1e-13);
  const PrescribedMask driven = driven_speeds(model, kinematics.topology());
  for (Eigen::Index c = 0; c < V.cols(); ++c) {
    set_velocities(model, V.col(c), model.length_scale(), state);
    kinematics.place(state.bodies);
    for (const JointIndex k : upward<JointIndex>(model.joints.size())) {
      const Span& span = kinematics.topology().joints[k];
      JointMeasure measure(kinematics.mobilizer(k), driven.data() + span.first_u);
      VecX q = state.q[k];
      VecX u = VecX::Zero(span.n_u);
      measure.find_q(kinematics.point(k, Side::parent), kinematics.point(k, Side::child), q.data(),
                     JointMeasure::Restart::never);
      measure.find_u(kinematics.point(k, Side::parent), kinematics.point(k, Side::child), q.data(), u.data());
      EXPECT_LT(measure.velocity_residual().norm(), 1e-12) << model.joints[k].name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Machines, PermittedVelocities, ::testing::Range(0, 5));

/// Two couplings that say the same, one of them in other units, share a force that neither has alone; a third stands by
/// itself. Reactions of the tree are unique all the same.
TEST(Rank, DecidesTheForceOfEachCoupling) {
  Model model = test::tree_of_all_joints(false);
  const auto couple = [&](const std::string& name, double factor, int first, int second) {
    Coupling coupling;
    coupling.name = name;
    coupling.terms = {{first, 0, 0, factor}, {second, 0, 0, -1.7 * factor}};
    const double q_first = model.joints[first].start[0].q(0);
    coupling.offset = factor * (q_first - 1.7 * model.joints[second].start[0].q(0));
    model.couplings.push_back(coupling);
  };
  couple("one", 1.0, 0, 7);
  couple("alone", 0.6, 2, 4);
  couple("again", -3.0, 0, 7);
  Equations equations(model);
  Coordinates pose{0.0, equations.home(), VecX::Zero(equations.topology().n_u)};
  const RankReport report = analyze_rank(ScaledClosure(equations), pose);
  EXPECT_EQ(report.unique_coupling, (std::vector<bool>{false, true, false}));
  EXPECT_EQ(report.decided_coupling, (std::vector<bool>{true, true, true}));
  for (const JointUniqueness& joint : report.joints) EXPECT_EQ(flags(joint, Side::child), "uuuuuu");
  EXPECT_EQ(report.constraints - report.rank, 1);
}

/// A second hinge on the axis of a first, tilted by less than any need notices and more than round-off: which torques
/// are unique depends on where the line is drawn, and the report says so. Well tilted or not at all, it is decided.
TEST(Rank, SaysWhereAFlagDependsOnTheThreshold) {
  const auto report_with = [](double tilt) {
    Model model = test::four_bar();
    Equations parallel(model);
    const Coordinates pose = Assembly(parallel).start();
    Model tilted = model;
    tilted.joints[3].sides[1].C = model.joints[3].sides[1].C * rotation_about(Axis::x, tilt);
    Equations equations(tilted);
    return analyze_rank(ScaledClosure(equations), pose);
  };
  const auto n_undecided = [](const RankReport& report) {
    int n = 0;
    for (const JointUniqueness& joint : report.decided) {
      for (const auto& side : joint.unique) n += static_cast<int>(std::count(side.begin(), side.end(), false));
    }
    return n;
  };
  EXPECT_EQ(n_undecided(report_with(0.0)), 0);
  EXPECT_GT(n_undecided(report_with(1e-9)), 0);
}

}  // namespace
}  // namespace concord::relative
