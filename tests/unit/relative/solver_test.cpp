#include "relative/solver.h"

#include <gtest/gtest.h>

#include <cmath>

#include "machines.h"

namespace concord::relative {
namespace {

/// A body on one hinge with horizontal axis, everything tilted and offset.
TEST(Solver, CompoundPendulumMovesAndPullsAsInTheBook) {
  Model model;
  model.file = "pendulum.toml";
  model.gravity = Vec3(1.1, -9.0, 2.3);
  test::Numbers numbers(2);
  model.bodies = {test::ground(), test::rigid_body("bob", numbers)};
  model.joints = {test::joint(model, "hinge", "revolute", 0, 1, numbers)};
  const std::unique_ptr<Solver> solver = make_solver(model);
  const State state = solver->assemble();
  const Evaluation evaluation = solver->evaluate(state);

  const Body& bob = model.bodies[1];
  const Attachment& child = model.joints[0].on(Side::child);
  const Mat3 A = test::rotation_of(state.bodies[1]);
  const Vec3 axis = model.joints[0].on(Side::parent).C.col(2);
  const Vec3 arm = A * (bob.center_of_mass_L - child.point_L);  // from hinge to centre of mass
  const Mat3 I_c = A * bob.inertia_L * A.transpose();
  const double speed = state.u[0](0);
  const double inertia = axis.dot(I_c * axis) + bob.mass * (arm.squaredNorm() - std::pow(axis.dot(arm), 2));
  const double angular = axis.dot(arm.cross(bob.mass * model.gravity)) / inertia;
  EXPECT_NEAR(axis.dot(evaluation.bodies[1].omegadot), angular, 1e-12 * std::abs(angular));
  const Vec3 omega = speed * axis;
  const Vec3 force = bob.mass * (angular * axis.cross(arm) + omega.cross(omega.cross(arm)) - model.gravity);
  const Vec3 torque = I_c * (angular * axis) + omega.cross(I_c * omega) + arm.cross(force);
  const SideWrench& on_bob = evaluation.joints[0].reaction_on(Side::child);
  EXPECT_LT((on_bob.in_global.force - force).norm(), 1e-12);
  EXPECT_LT((on_bob.in_global.torque - torque).norm(), 1e-12);
  EXPECT_LT((on_bob.in_C.force - (A * child.C).transpose() * force).norm(), 1e-12);
  EXPECT_LT((on_bob.in_C.torque - (A * child.C).transpose() * torque).norm(), 1e-12);
}

/// Steady precession: m g l = Omega (I_3 omega_3 - I_1 Omega cos theta) with omega_3 the spin along the top's axis.
TEST(Solver, TopPrecessesSteadilyAtTheBooksRate) {
  Model model;
  model.file = "top.toml";
  model.gravity = Vec3(0, 0, -9.81);
  test::Numbers numbers(6);
  Body top = test::rigid_body("top", numbers);
  const double length = 0.12;
  const double I_1 = 0.0031 + top.mass * length * length;
  const double I_3 = 0.0019;
  top.center_of_mass_L = Vec3(0, 0, length);
  top.inertia_L = Vec3(0.0031, 0.0031, I_3).asDiagonal();
  model.bodies = {test::ground(), top};
  model.joints = {test::joint(model, "support", "spherical", 0, 1, numbers)};
  Joint& support = model.joints[0];
  support.sides[0].C.setIdentity();
  support.sides[1].C.setIdentity();
  support.sides[1].point_L.setZero();
  const double tilt = 0.6;
  const double precession = 1.7;
  const double omega_3 = (top.mass * 9.81 * length / precession + I_1 * precession * std::cos(tilt)) / I_3;
  const Mat3 R = rotation_about(Axis::z, 0.4) * rotation_about(Axis::x, tilt);
  const Eigen::Quaterniond p(R);
  support.start[0].q << p.w(), p.x(), p.y(), p.z();
  // Spin so that the component of omega along the top's axis is omega_3.
  support.start[0].u = Vec3(0, 0, precession) + (omega_3 - precession * std::cos(tilt)) * R.col(2);

  RunOptions options;
  options.until = 1.0;
  options.samples = 10;
  const Trajectory run = make_solver(model)->integrate(options, {});
  for (const Sample& sample : run.samples) {
    const Vec3 axis = test::rotation_of(sample.state.bodies[1]).col(2);
    const Vec3 expected = rotation_about(Axis::z, precession * sample.state.t) * R.col(2);
    EXPECT_LT((axis - expected).norm(), 1e-8) << sample.state.t;
  }
}

TEST(Solver, RefusesAStateThatIsNotClosed) {
  const Model model = test::spatial_slider_crank(true);
  const std::unique_ptr<Solver> solver = make_solver(model);
  State state = solver->assemble();
  EXPECT_NO_THROW((void)solver->evaluate(state));
  state.bodies[1].r += Vec3(0, 0, 1e-9);
  try {
    (void)solver->evaluate(state);
    FAIL() << "a state with a gap of 1e-9 m was accepted";
  } catch (const SolverError& error) {
    EXPECT_STREQ(error.what(),
                 "relative: at t = 0 s the state is not closed: residual 1.3e-09 at joint 'B', allowed 1e-12: close it "
                 "first");
  }
}

TEST(Solver, ClosesGuessesOrSaysThatItCannot) {
  const Model model = test::spatial_slider_crank(true);
  const std::unique_ptr<Solver> solver = make_solver(model);
  State guess = solver->assemble();
  guess.bodies[1].r += Vec3(0.001, -0.002, 0.001);
  guess.bodies[3].v += Vec3(0.05, 0.02, -0.03);
  const std::optional<State> closed = solver->close(guess);
  ASSERT_TRUE(closed.has_value());
  EXPECT_NO_THROW((void)solver->evaluate(*closed));
  EXPECT_EQ(closed->bodies[2].a, guess.bodies[2].a);
  EXPECT_LT((closed->bodies[1].r - guess.bodies[1].r).norm(), 0.01);

  Model driven = test::spatial_slider_crank(true);
  test::release(driven.joints[0]);
  driven.joints[3].drivers.push_back({0, ConstantSpeed{driven.joints[3].start[0].q(0), 9.0}});
  const std::unique_ptr<Solver> out_of_reach = make_solver(driven);
  State later = out_of_reach->assemble();
  later.t = 1.0;
  EXPECT_FALSE(out_of_reach->close(later).has_value());
}

TEST(Solver, TellsItsNameAndItsCuts) {
  Model model = test::spatial_slider_crank(false);
  EXPECT_EQ(make_solver(model)->name(), "relative");
  EXPECT_EQ(make_solver(model)->cut_joints(), std::vector<std::string>{"B"});
  model.joints[3].named_as_cut = true;
  EXPECT_EQ(make_solver(model)->cut_joints(), std::vector<std::string>{"D"});
}

/// Every type between two bodies that otherwise move freely: as cut joint and as tree joint, from either side, the same
/// accelerations and wrenches, in balance with the mass points.
class EveryJointType : public ::testing::TestWithParam<std::tuple<const joints::JointType*, int>> {
 protected:
  static Model machine() { return test::pair(*std::get<0>(GetParam()), std::get<1>(GetParam())); }
};

TEST_P(EveryJointType, IsTheSameInTheTreeAndCut) {
  Model in_tree = machine();
  in_tree.joints[1].named_as_cut = true;
  Model cut = machine();
  cut.joints[2].named_as_cut = true;
  const std::unique_ptr<Solver> one = make_solver(in_tree);
  const std::unique_ptr<Solver> other = make_solver(cut);
  const State state = one->assemble();
  const Evaluation by_tree = one->evaluate(state);
  const Evaluation by_cut = other->evaluate(state);
  double size = 1.0;
  for (const SideWrench& side : by_tree.joints[2].total) size = std::max(size, side.in_C.vector().norm());
  for (const Side side : {Side::parent, Side::child}) {
    const Vec6 difference =
        by_tree.joints[2].reaction_on(side).in_C.vector() - by_cut.joints[2].reaction_on(side).in_C.vector();
    EXPECT_LT(difference.norm(), 1e-11 * size);
  }
  for (int i = 1; i < 3; ++i) {
    const double fast = 1.0 + by_tree.bodies[i].vdot.norm() + by_tree.bodies[i].omegadot.norm();
    EXPECT_LT((by_tree.bodies[i].vdot - by_cut.bodies[i].vdot).norm(), 1e-11 * fast);
    EXPECT_LT((by_tree.bodies[i].omegadot - by_cut.bodies[i].omegadot).norm(), 1e-11 * fast);
  }
  for (const Evaluation* evaluation : {&by_tree, &by_cut}) {
    const test::Imbalance left_over = test::imbalance(in_tree, state, *evaluation);
    EXPECT_LT(left_over.force + left_over.torque + left_over.modal, 1e-11 * size);
  }
}

std::string refusal_of(const Model& model, const State& state) {
  try {
    (void)make_solver(model)->evaluate(state);
  } catch (const SolverError& error) {
    return error.what();
  }
  return "no refusal";
}

/// A rod that points along the parent's x has lost one of its turns.
TEST(Solver, NamesALinkWhoseCoordinatesAreSingular) {
  for (const int named : {1, 2}) {  // the rod in the tree, the rod cut
    Model model = test::pair(*joints::find("distance"), 0);
    model.joints[named].named_as_cut = true;
    const State sound = make_solver(model)->assemble();
    EXPECT_NO_THROW((void)make_solver(model)->evaluate(sound));
    State singular = sound;
    const Attachment& on_parent = model.joints[2].on(Side::parent);
    const Attachment& on_child = model.joints[2].on(Side::child);
    const BodyState& parent = sound.bodies[1];
    singular.bodies[2].r = parent.r + test::rotation_of(parent) * (on_parent.point_L + 0.4 * on_parent.C.col(0)) -
                           test::rotation_of(sound.bodies[2]) * on_child.point_L;
    EXPECT_NE(refusal_of(model, singular).find("its coordinates are singular"), std::string::npos);
    model.joints[2].start[1].q(0) = M_PI / 2.0;
    test::fit_child_side(model, model.joints[2]);
    try {
      (void)make_solver(model)->assemble();
      FAIL() << "a start in a singular pose was accepted";
    } catch (const SolverError& error) {
      EXPECT_STREQ(
          error.what(),
          "relative: joint 'J' (distance): its coordinates are singular in this pose, where two of its motions "
          "are one: turn its frame on the parent, so that the machine stays away from there");
    }
  }
}

std::string pair_name(const ::testing::TestParamInfo<std::tuple<const joints::JointType*, int>>& tested) {
  const std::vector<std::string> bodies{"rigid_rigid", "flexible_rigid", "rigid_flexible", "flexible_flexible"};
  return std::get<0>(tested.param)->name + "_" + bodies[std::get<1>(tested.param)];
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryJointType,
                         ::testing::Combine(::testing::ValuesIn(test::all_types()), ::testing::Range(0, 4)), pair_name);

TEST(Solver, EvaluatesARedundantMachineWithUniqueMotion) {
  // Whatever the cut, accelerations and unique components agree; the flags say which these are.
  Model model = test::four_bar();
  const State state = make_solver(model)->assemble();
  const Evaluation reference = make_solver(model)->evaluate(state);
  const RankReport report = make_solver(model)->rank(state);
  for (int cut = 0; cut < 4; ++cut) {
    for (int k = 0; k < 4; ++k) model.joints[k].named_as_cut = k == cut;
    const Evaluation other = make_solver(model)->evaluate(state);
    for (int i = 1; i < 4; ++i) {
      EXPECT_LT((other.bodies[i].vdot - reference.bodies[i].vdot).norm(), 1e-12);
      EXPECT_LT((other.bodies[i].omegadot - reference.bodies[i].omegadot).norm(), 1e-12);
    }
    const test::Imbalance left_over = test::imbalance(model, state, other);
    EXPECT_LT(left_over.force + left_over.torque, 1e-12);
    for (int k = 0; k < 4; ++k) {
      const Vec6 difference = other.joints[k].reaction_on(Side::child).in_C.vector() -
                              reference.joints[k].reaction_on(Side::child).in_C.vector();
      for (int c = 0; c < 6; ++c) {
        if (!report.joints[k].unique[1][c]) continue;
        EXPECT_LT(std::abs(difference(c)), 1e-12) << k << " " << c;
      }
    }
  }
}

/// The rigid slider-crank in other units of length, mass and time.
Model in_other_units(double length, double mass, double time) {
  Model model = test::spatial_slider_crank(false);
  model.gravity *= length / (time * time);
  for (Body& body : model.bodies) {
    body.mass *= mass;
    body.center_of_mass_L *= length;
    body.inertia_L *= mass * length * length;
    if (body.pose_guess) body.pose_guess->r *= length;
  }
  for (Joint& joint : model.joints) {
    for (Attachment& side : joint.sides) side.point_L *= length;
    for (std::size_t word = 0; word < joint.start.size(); ++word) {
      const bool slides = std::holds_alternative<joints::Slide>(joint.type->permits[word]);
      joint.start[word].q *= slides ? length : 1.0;
      joint.start[word].u *= (slides ? length : 1.0) / time;
    }
  }
  return model;
}

TEST(Solver, GivesTheSameDigitsInUnitsThatArePowersOfTwo) {
  const double length = std::ldexp(1.0, 20);
  const double mass = std::ldexp(1.0, -18);
  const double time = std::ldexp(1.0, -17);
  const double force = mass * length / (time * time);
  const auto plain = make_solver(in_other_units(1.0, 1.0, 1.0));
  const auto scaled = make_solver(in_other_units(length, mass, time));
  const Evaluation one = plain->evaluate(plain->assemble());
  const Evaluation other = scaled->evaluate(scaled->assemble());
  for (std::size_t k = 0; k < one.joints.size(); ++k) {
    for (const Side side : {Side::parent, Side::child}) {
      EXPECT_EQ(Vec3(force * one.joints[k].reaction_on(side).in_C.force), other.joints[k].reaction_on(side).in_C.force);
      EXPECT_EQ(Vec3(force * length * one.joints[k].reaction_on(side).in_C.torque),
                other.joints[k].reaction_on(side).in_C.torque);
    }
  }
}

TEST(Solver, RunsAlikeOverTwelveDecades) {
  for (const double unit : {1e-6, 1e6}) {
    for (int which = 0; which < 3; ++which) {
      const double time = which == 2 ? unit : 1.0;
      RunOptions options;
      options.until = 0.1 * time;
      options.samples = 2;
      options.rtol = 1e-9;
      const Model model = in_other_units(which == 0 ? unit : 1.0, which == 1 ? unit : 1.0, time);
      const Trajectory run = make_solver(model)->integrate(options, {});
      options.until = 0.1;
      const Trajectory plain = make_solver(in_other_units(1.0, 1.0, 1.0))->integrate(options, {});
      EXPECT_LT((run.samples.back().state.q[0] - plain.samples.back().state.q[0]).norm(), 1e-9) << unit << which;
      EXPECT_LT(run.statistics.max_constraint, 1e-13);
    }
  }
}

TEST(Solver, RefusesAFrameThatIsNoRotation) {
  Model model = test::spatial_slider_crank(false);
  model.joints[1].sides[0].C.col(2).setZero();
  model.joints[1].where = {"slider_crank.toml", 21, 1};
  try {
    (void)make_solver(model);
    FAIL() << "a frame without a third axis was accepted";
  } catch (const InputError& error) {
    EXPECT_TRUE(std::string(error.what())
                    .starts_with("slider_crank.toml:21:1: error: joint 'B': the frame of one of "
                                 "its ends is no rotation"))
        << error.what();
  }
}

}  // namespace
}  // namespace concord::relative
