#include "cartesian/bodies/constraints.h"

#include <gtest/gtest.h>

#include <memory>
#include <type_traits>

#include "cartesian/bodies/euler_parameters.h"
#include "common/joints/catalogue.h"
#include "machines.h"

namespace concord::cartesian {
namespace {

using testing::Numbers;

struct Rig {
  Model model;
  Layout layout;
  std::unique_ptr<Constraints> constraints;
  VecX q;
  VecX Y;

  Rig(unsigned seed, const joints::JointType& type, int m_parent, int m_child)
      : Rig(testing::make_pair(seed, type, m_parent, m_child), seed) {}

  Rig(Model stated, unsigned seed)
      : model(std::move(stated)), layout(model), constraints(Constraints::make(model, layout)) {
    Numbers numbers(seed + 1000);
    q = numbers.matrix(layout.n_q(), 1, 0.4);
    layout.normalize(q);
    Y = numbers.matrix(layout.n_Y(), 1, 1.5);
  }

  /// Positions after time t with constant v, omega and adot.
  [[nodiscard]] VecX carried(double t) const {
    VecX moved = q;
    for (const BodyIndex i : layout.moving_bodies()) {
      const Vec3 omega = layout.omega(Y, i);
      layout.r(moved, i) += t * layout.v(Y, i);
      layout.p(moved, i) =
          euler_parameters_of(rotation_about(omega.normalized(), omega.norm() * t) * rotation_of(layout.p(q, i)));
      layout.a(moved, i) += t * layout.adot(Y, i);
    }
    return moved;
  }

  VecX residual(const VecX& at) {
    VecX value(constraints->n_rows());
    constraints->place(at).write_residual(0.3, value);
    return value;
  }
  VecX rate(const VecX& at) {
    VecX value(constraints->n_rows());
    constraints->place(at).move(Y).write_velocity_residual(0.3, value);
    return value;
  }
};

template <class C>
concept GivesARotation = requires(const C& at) {
  at.rotation(BodyIndex(1));
};
template <class C>
concept GivesTheMotionOfAJoint = requires(const C& at) {
  at.joint(JointIndex(0)).motion;
};
template <class C>
concept GivesJacobians = requires(const C& at, const RowBlock& block) {
  at.columns(block);
};
template <class C>
concept GivesResiduals = requires(const C& at, VecX value) {
  at.write_residual(0.0, value);
};
template <class C>
concept GivesRates = requires(const C& at, VecX value) {
  at.write_velocity_residual(0.0, value);
};
template <class C>
concept GivesGamma = requires(const C& at, VecX value) {
  at.write_gamma(0.0, value);
};
template <class C>
concept Moves = requires(C& at, VecX Y) {
  at.move(Y);
};

/// Read too early, rows would be those of a state that was left, of which no test need tell.
TEST(Constraints, AreReadAsFarAsTheyArePlacedAndMoved) {
  using C = Constraints;
  static_assert(!GivesARotation<C> && !GivesTheMotionOfAJoint<C> && !GivesJacobians<C> && !GivesResiduals<C>);
  static_assert(!GivesRates<C> && !GivesGamma<C> && !Moves<C>);
  using Placed = PlacedConstraints;
  static_assert(GivesARotation<Placed> && GivesTheMotionOfAJoint<Placed> && GivesJacobians<Placed>);
  static_assert(GivesResiduals<Placed> && Moves<Placed> && !GivesRates<Placed> && !GivesGamma<Placed>);
  static_assert(GivesResiduals<MovingConstraints> && GivesRates<MovingConstraints> && GivesGamma<MovingConstraints>);
  // Only place() and move() lead on.
  static_assert(!std::is_constructible_v<Placed, const Model&, const Layout&> && !std::is_copy_constructible_v<Placed>);
  static_assert(!std::is_constructible_v<MovingConstraints, const Model&, const Layout&>);
  static_assert(!std::is_convertible_v<C&, Placed&> && !std::is_convertible_v<Placed&, MovingConstraints&>);
}

const joints::JointType& any_two(int k) { return *joints::catalogue()[k]; }

/// Every type between a flexible parent and a flexible child: Jacobian and gamma against differences along a motion in
/// which both bodies turn and deform.
TEST(Constraints, VelocityRowsAndGammaFollowFromTheResidual) {
  for (std::size_t k = 0; k < joints::catalogue().size(); ++k) {
    SCOPED_TRACE(any_two(static_cast<int>(k)).name);
    Rig rig(41 + static_cast<unsigned>(k), any_two(static_cast<int>(k)), 2, 3);
    const double h = 1e-5;
    const VecX velocity = rig.rate(rig.q);
    VecX gamma(rig.constraints->n_rows());
    rig.constraints->place(rig.q).move(rig.Y).write_gamma(0.3, gamma);
    const VecX by_residual = (rig.residual(rig.carried(h)) - rig.residual(rig.carried(-h))) / (2 * h);
    for (int row = 0; row < rig.constraints->n_rows(); ++row) {
      const bool holds_positions = row < any_two(static_cast<int>(k)).rows();
      EXPECT_EQ(rig.constraints->holds_positions(RowIndex(row)), holds_positions);
      EXPECT_NEAR(by_residual(row), holds_positions ? velocity(row) : 0.0, 1e-7 * (1 + velocity.norm()));
    }
    const VecX by_rate = (rig.rate(rig.carried(h)) - rig.rate(rig.carried(-h))) / (2 * h);
    EXPECT_LT((gamma + by_rate).norm(), 1e-6 * (1 + gamma.norm()));
  }
}

TEST(Constraints, JacobianTimesVelocitiesIsTheVelocityResidual) {
  for (const joints::JointType* type : joints::catalogue()) {
    SCOPED_TRACE(type->name);
    Rig rig(53, *type, 3, 2);
    const VecX velocity = rig.rate(rig.q);
    VecX product = VecX::Zero(rig.constraints->n_rows());
    const JointEquations& joint = rig.constraints->place(rig.q).joint(JointIndex(0));
    for (const Side side : {Side::parent, Side::child}) {
      const BodyIndex body = body_of(rig.model.joints[0].on(side));
      const auto Y_i = rig.Y.segment(rig.layout.first_Y(body), rig.layout.size_Y(body));
      for (int row = 0; row < joint.n_rows; ++row)
        product(row) += joint.Phi_Y_transposed[index(side)].col(row).dot(Y_i);
    }
    EXPECT_LT((velocity - product).norm(), 1e-13 * (1 + velocity.norm()));
  }
}

TEST(Constraints, ADriverAddsItsLawToTheRowOfItsCoordinate) {
  Model model = testing::make_pair(61, *joints::find("cylindrical"), 0, 2);
  model.joints[0].drivers = {{1, Harmonic{0.2, 0.5, 3.0, 0.1}}, {0, Polynomial{{0.1, 0.2, -0.4}}}};
  Rig rig(std::move(model), 61);
  EXPECT_EQ(rig.constraints->n_rows(), 6);
  const VecX driven = rig.residual(rig.q);
  const Harmonic turn{0.2, 0.5, 3.0, 0.1};
  const ConstraintRow angle = evaluate_read(*read_of(*rig.model.joints[0].type, 1), 0,
                                            rig.constraints->place(rig.q).joint(JointIndex(0)).motion);
  EXPECT_NEAR(std::sin(driven(4)), std::sin(angle.value - evaluate(turn, 0.3).f), 1e-14);
  EXPECT_LE(std::abs(driven(4)), EIGEN_PI);
}

}  // namespace
}  // namespace concord::cartesian
