#include "compare/resolution/resolution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "common/reading/model_file.h"
#include "compare/resolution/term_sizes.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();

/// A number in [-1, 1) that any change of `x` changes: what round-off does to an ill-conditioned answer.
double noise_from(double x) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &x, sizeof bits);
  bits = (bits ^ (bits >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  bits = (bits ^ (bits >> 27U)) * 0x94d049bb133111ebULL;
  return std::ldexp(static_cast<double>(bits >> 11U), -52) - 1.0;
}

class ResolutionTest : public ::testing::Test {
 protected:
  ResolutionTest() {
    const Trajectory run = cartesian_.integrate({0.2, 1e-11, 8, ""}, [](double) {});
    for (std::size_t k = 0; k < run.samples.size(); ++k) {
      const State& state = run.samples[k].state;
      states_.push_back({state, {cartesian_.evaluate(state), relative_.evaluate(state)}, static_cast<int>(k)});
    }
  }

  Resolution measure_all() {
    for (SharedState& one : states_) one.evaluations[1] = relative_.evaluate(one.state);
    Mask unique = Mask::Constant(static_cast<Eigen::Index>(layout_.quantities().size()),
                                 static_cast<Eigen::Index>(states_.size()), true);
    if (not_unique_) unique.row(*not_unique_).setConstant(false);
    return measure_resolution(layout_, {&cartesian_, &relative_}, states_, unique,
                              measure(layout_, align(layout_, states_)), 7);
  }

  [[nodiscard]] int row(int component) const { return layout_.row_of({Kind::reaction, 0, Side::child, component}); }

  Model model_ = pendulum_model();
  QuantityLayout layout_{model_};
  FakePendulum cartesian_{model_, "cartesian"};
  FakePendulum relative_{model_, "relative"};
  std::vector<SharedState> states_;
  std::optional<int> not_unique_;  // row
};

TEST_F(ResolutionTest, DrawsMoveEveryNumberByRoundOffOfItsKindAndRepeat) {
  const State& state = states_[3].state;
  const MachineSize sizes(model_, state);
  const State drawn = draw_within_roundoff(state, sizes, 11);
  const BodyState& before = state.bodies[1];
  const BodyState& after = drawn.bodies[1];
  EXPECT_LE((after.r - before.r).cwiseAbs().maxCoeff(), 1.01 * kEps * sizes.place);
  EXPECT_LE((after.omega - before.omega).cwiseAbs().maxCoeff(), 2.0 * kEps * sizes.turning);
  EXPECT_GT((after.p - before.p).norm(), 0.0);
  EXPECT_GT((after.v - before.v).norm(), 0.0);
  EXPECT_TRUE(after.v == draw_within_roundoff(state, sizes, 11).bodies[1].v);
  EXPECT_FALSE(after.v == draw_within_roundoff(state, sizes, 12).bodies[1].v);
}

TEST_F(ResolutionTest, ZeroesAreMovedToo) {
  State state = states_[0].state;
  state.bodies[1].v(1) = 0.0;
  EXPECT_NE(draw_within_roundoff(state, {model_, state}, 3).bodies[1].v(1), 0.0);
}

TEST_F(ResolutionTest, AWellConditionedMachineResolvesNearlyAllDigits) {
  const Resolution resolution = measure_all();
  EXPECT_EQ(resolution.unknown_states, 0);
  EXPECT_EQ(resolution.closings_left_out, 0);
  const double force = states_[0].evaluations[0].joints[0].total_on(Side::child).in_C.force.norm();
  EXPECT_TRUE((resolution.both.array() > 0.0).all());
  EXPECT_LT(resolution.both.row(row(0)).maxCoeff(), 1e-13 * force);
}

TEST_F(ResolutionTest, AnAnswerThatIsNoiseIsResolvedToThatNoiseInItsWholeForce) {
  relative_.spoil = [](const State& state, Evaluation& evaluation) {
    evaluation.joints[0].reaction[index(Side::child)].in_C.force(1) += 1e-7 * noise_from(state.bodies[1].omega(2));
  };
  const Resolution resolution = measure_all();
  for (Eigen::Index k = 0; k < resolution.both.cols(); ++k) {
    EXPECT_GT(resolution.both(row(1), k), 1e-9);
    EXPECT_LT(resolution.both(row(1), k), 3e-7);
    EXPECT_EQ(resolution.own[1](row(0), k), resolution.own[1](row(1), k)) << "one force, one resolution";
    EXPECT_LT(resolution.own[0](row(1), k), 1e-12) << "the other solver's own is its own";
  }
}

TEST_F(ResolutionTest, AComponentThatIsNotUniqueSaysNothingOfItsNeighbours) {
  relative_.spoil = [](const State& state, Evaluation& evaluation) {
    evaluation.joints[0].reaction[index(Side::child)].in_C.force(1) += noise_from(state.bodies[1].omega(2));
  };
  not_unique_ = row(1);
  const Resolution resolution = measure_all();
  EXPECT_LT(resolution.both.row(row(0)).maxCoeff(), 1e-12);
  EXPECT_GT(resolution.both.row(row(1)).maxCoeff(), 1e-3);
}

TEST_F(ResolutionTest, AnErrorThatDoesNotMoveBuysNoTolerance) {
  relative_.spoil = [](const State&, Evaluation& evaluation) {
    evaluation.joints[0].reaction[index(Side::child)].in_C.force(1) += 1e-7;
  };
  EXPECT_LT(measure_all().both.row(row(1)).maxCoeff(), 1e-12);
}

TEST_F(ResolutionTest, TermsThatCancelCountThoughNothingIsLeft) {
  // Hinge force along an axis that carries nothing: the floor is round-off of what was added up.
  const VecX terms = term_sizes(layout_, states_[2]);
  const double weight = 1.7 * pendulum_model().gravity.norm();
  for (int c = 0; c < 6; ++c) EXPECT_GE(terms(row(c)), 0.3 * weight);
  EXPECT_GT(terms(layout_.first_row(Kind::acceleration, 1)), 5.0);
}

/// All that the terms look at, at rest in the origin and without any force.
SharedState state_at_rest(const Model& model) {
  SharedState shared;
  shared.state.bodies.resize(model.bodies.size());
  for (const Joint& joint : model.joints) {
    shared.state.q.emplace_back(VecX::Zero(joint.type->n_q()));
    shared.state.u.emplace_back(VecX::Zero(joint.type->n_u()));
  }
  for (Evaluation& evaluation : shared.evaluations) {
    evaluation.bodies.resize(model.bodies.size());
    evaluation.joints.resize(model.joints.size());
    evaluation.elements.resize(model.elements.size());
    for (std::size_t k = 0; k < model.joints.size(); ++k) evaluation.joints[k].tau = shared.state.u[k];
    evaluation.couplings.assign(model.couplings.size(), 0.0);
  }
  return shared;
}

TEST(ResolutionTerms, OfABodysSumTakeTheRoundOffOfAJointsForceByItsLever) {
  // It falls: its joint passes next to nothing, but whoever finds that adds up its weight.
  const Model model = parse_model(R"(
    format = 1
    gravity = [0, 0, -9.5]
    [[body]]
    name = "stone"
    mass = 0.8
    inertia = [0.04, 0.04, 0.04]
    [[joint]]
    name = "air"
    type = "free"
    parent = "ground"
    child = { body = "stone", point = [0.4, 0, 0] }
  )",
                                  "falling.toml");
  const QuantityLayout layout(model);
  const VecX terms = term_sizes(layout, state_at_rest(model));
  EXPECT_NEAR(terms(layout.row_of({Kind::body_sum, 1, Side::child, 4})), 0.8 * 9.5 * 0.4, 1e-12);
}

TEST(ResolutionTerms, OfABalancedRotorAreThoseOfItsTurningAndReachWhatIsCoupledWithIt) {
  // The first disc stands, the second turns.
  const Model model = parse_model(R"(
    format = 1
    [[body]]
    name = "light"
    mass = 0.1
    inertia = [1e-6, 1e-6, 1e-6]
    [[body]]
    name = "heavy"
    mass = 7.0
    inertia = [0.4, 0.5, 0.6]
    [[joint]]
    name = "A"
    type = "revolute"
    parent = "ground"
    child = "light"
    drive.turn_z = { law = "constant_speed", speed = 0 }
    [[joint]]
    name = "B"
    type = "revolute"
    parent = { body = "ground", point = [0.2, 0, 0] }
    child = "heavy"
    [[coupling]]
    name = "gears"
    terms = [
      { joint = "A", coordinate = "turn_z", factor = 3 }, { joint = "B", coordinate = "turn_z", factor = -5 }]
  )",
                                  "discs.toml");
  SharedState shared = state_at_rest(model);
  shared.state.bodies[2].omega = Vec3(0.0, 0.0, 4.0);
  const QuantityLayout layout(model);
  const VecX terms = term_sizes(layout, shared);
  const double of_heavy = terms(layout.row_of({Kind::tau, 1, Side::child, 0}));
  EXPECT_NEAR(of_heavy, 0.6 * 4.0 * 4.0, 1e-12);
  EXPECT_DOUBLE_EQ(terms(layout.row_of({Kind::coupling, 0, Side::child, 0})), of_heavy / 5.0);
  EXPECT_EQ(terms(layout.row_of({Kind::tau, 0, Side::child, 0})), 0.0) << "the other disc has loads of its own";
}

/// A bob of 2 kg hangs from a yoke, which is attached by a ball from a slide.
Model bob_on_a_chain() {
  return parse_model(R"(
    format = 1
    gravity = [0, 0, -10]
    [[body]]
    name = "slide"
    mass = 1
    inertia = [1, 1, 1]
    [[body]]
    name = "yoke"
    mass = 1
    inertia = [1, 1, 1]
    [[body]]
    name = "bob"
    mass = 2
    inertia = [0.1, 0.1, 0.1]
    [[joint]]
    name = "rail"
    type = "translational"
    parent = "ground"
    child = "slide"
    [[joint]]
    name = "ball"
    type = "spherical"
    parent = "slide"
    child = "yoke"
    [[joint]]
    name = "hook"
    type = "revolute"
    parent = { body = "bob", point = [0, 0.3, 0.4] }
    child = "yoke"
    [[line_spring]]
    name = "rubber"
    parent = "ground"
    child = { body = "bob", point = [0.1, 0, 0] }
    stiffness = 100
    free = 0.1
  )",
                     "chain.toml");
}

TEST(ResolutionTerms, OfABodyWithoutMassAreThoseOfWhatItIsJoinedToThroughTheChain) {
  Model model = bob_on_a_chain();
  for (const int massless : {1, 2}) {
    model.bodies[massless].mass = 0.0;
    model.bodies[massless].inertia_L.setZero();
  }
  const QuantityLayout layout(model);
  const VecX terms = term_sizes(layout, state_at_rest(model));
  const double of_bob = terms(layout.row_of({Kind::acceleration, 3, Side::child, 0}));
  EXPECT_NEAR(of_bob, 10.0, 1e-12);
  for (const int massless : {1, 2}) {
    for (int c = 0; c < 6; ++c) {
      EXPECT_EQ(terms(layout.row_of({Kind::acceleration, massless, Side::child, c})),
                terms(layout.row_of({Kind::acceleration, 3, Side::child, c})));
    }
  }
}

TEST(ResolutionTerms, OfAForceElementAreWhatLeversMakeOfItsForce) {
  const Model model = bob_on_a_chain();
  const QuantityLayout layout(model);
  SharedState shared = state_at_rest(model);
  shared.evaluations[1].elements[0].on[0].in_C.force = Vec3(0.0, 3.0, 4.0);
  const VecX terms = term_sizes(layout, shared);
  for (const Side side : kSides) {
    EXPECT_EQ(terms(layout.row_of({Kind::element, 0, side, 0})), 0.0);
    EXPECT_DOUBLE_EQ(terms(layout.row_of({Kind::element, 0, side, 3})), 5.0 * model.length_scale());
  }
}

TEST(ResolutionTerms, OfAModeAreItsStrainOverItsMass) {
  Model model = pendulum_model();
  Body& bob = model.bodies[1];
  ModalData modal;
  MassPoint point;
  point.mass = bob.mass;
  point.Psi_t_L = Mat3X::Zero(3, 1);
  point.Psi_t_L(2, 0) = 2.0;
  modal.mass_points = {point};
  modal.G = MatX::Zero(7, 7);
  modal.G(0, 0) = bob.mass;
  modal.G(6, 6) = 4.0 * bob.mass;
  modal.stiffness = MatX::Constant(1, 1, 1e5);
  modal.damping = MatX::Zero(1, 1);
  bob.modal = modal;
  for (Attachment& side : model.joints[0].sides) {
    if (side.body != 1) continue;
    side.Psi_t_L = side.Psi_r_L = Mat3X::Zero(3, 1);
  }
  SharedState shared = state_at_rest(model);
  shared.state.bodies[1].a = VecX::Constant(1, 0.3);
  shared.state.bodies[1].adot = VecX::Zero(1);
  for (Evaluation& evaluation : shared.evaluations) evaluation.bodies[1].addot = VecX::Zero(1);
  const QuantityLayout layout(model);
  const VecX terms = term_sizes(layout, shared);
  EXPECT_DOUBLE_EQ(terms(layout.row_of({Kind::acceleration, 1, Side::child, 6})), 3e4 / (4.0 * bob.mass));
}

TEST_F(ResolutionTest, StatesThatNoDrawIsAcceptedInAreUnknown) {
  const double t = states_[4].state.t;
  const Resolution before = measure_all();
  relative_.spoil = [t, calls = 0](const State& state, Evaluation&) mutable {
    if (state.t == t && calls++ > 0) throw SolverError("relative: not closed");
  };
  const Resolution resolution = measure_all();
  EXPECT_EQ(resolution.unknown_states, 1);
  EXPECT_TRUE(std::isnan(resolution.both(row(0), 4)));
  EXPECT_FALSE(std::isnan(resolution.both(row(0), 5)));
  EXPECT_FALSE(std::isnan(before.both(row(0), 4)));
}

TEST_F(ResolutionTest, AStateIsSingularWhereADrawIsRefusedAsASingularPose) {
  const double t = states_[4].state.t;
  relative_.spoil = [t, calls = 0](const State& state, Evaluation&) mutable {
    if (state.t == t && calls++ == 2) throw SingularPose("relative: the loop of joint 'A' is singular");
  };
  const Resolution resolution = measure_all();
  ASSERT_EQ(resolution.singular.size(), states_.size());
  for (std::size_t k = 0; k < states_.size(); ++k) {
    EXPECT_EQ(resolution.singular[k], k == 4 ? "relative: the loop of joint 'A' is singular" : "") << k;
  }
}

TEST_F(ResolutionTest, OfARunTakesTheLargestOfTheStatesOfEachSample) {
  Resolution resolution;
  resolution.both = MatX::Constant(2, 3, 1.0);
  resolution.both(0, 1) = 4.0;
  std::vector<SharedState> states(3);
  states[0].row = 0;
  states[1].row = 0;
  states[2].row = 2;
  const MatX of_run = resolution_of_run(resolution, states, 3);
  EXPECT_EQ(of_run(0, 0), 4.0 * kUnitsOfARun);
  EXPECT_TRUE(std::isnan(of_run(0, 1)));
  EXPECT_EQ(of_run(1, 2), kUnitsOfARun);
}

}  // namespace
}  // namespace concord::compare
