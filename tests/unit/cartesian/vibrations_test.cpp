#include "cartesian/run/vibrations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

#include "cartesian/run/collocation.h"
#include "cartesian/run/gauss_rule.h"
#include "cartesian/run/stepper.h"
#include "common/joints/catalogue.h"
#include "machines.h"

namespace concord::cartesian {
namespace {

struct Kind {
  double lambda;
  double twice_delta;
};
/// Undamped, damped, critical and beside it, overdamped, without stiffness, unstable, driven by negative damping.
const std::vector<Kind> kKinds{{9.0, 0.0}, {9.0, 0.6},  {9.0, 6.0},  {9.0, 6.000001}, {9.0, 200.0}, {0.0, 0.0},
                               {0.0, 5.0}, {-4.0, 0.0}, {-4.0, 3.0}, {9.0, -0.5},     {-4.0, -3.0}, {9.0, -6.0}};

/// x'' + 2 delta x' + lambda x = 0 goes on from any time as from the start.
TEST(Vibrations, AResponseGoesOnFromAnyTime) {
  for (const Kind& kind : kKinds) {
    for (const double first : {1e-3, 0.02, 0.4}) {
      for (const double second : {5e-4, 0.01, 0.7}) {
        const Response one = response(kind.lambda, kind.twice_delta, first);
        const Response two = response(kind.lambda, kind.twice_delta, second);
        const Response both = response(kind.lambda, kind.twice_delta, first + second);
        const double size = std::hypot(both.place, both.rate) + 1e-3;
        EXPECT_NEAR(both.place, (two.rate + kind.twice_delta * two.place) * one.place + two.place * one.rate,
                    2e-14 * size)
            << kind.lambda << " " << kind.twice_delta;
        EXPECT_NEAR(both.rate, -kind.lambda * two.place * one.place + two.rate * one.rate, 1e-13 * size)
            << kind.lambda << " " << kind.twice_delta;
      }
    }
  }
}

TEST(Vibrations, AResponseBeginsAsItsEquationSays) {
  for (const Kind& kind : kKinds) {
    const double t = 1e-4 / (1.0 + std::abs(kind.twice_delta));
    const Response left = response(kind.lambda, kind.twice_delta, t);
    const double delta = 0.5 * kind.twice_delta;
    const double third = 4.0 * delta * delta - kind.lambda;
    EXPECT_NEAR(left.place, t - delta * t * t + third / 6.0 * t * t * t, 1e-12 * t);
    EXPECT_NEAR(left.rate, 1.0 - kind.twice_delta * t + third / 2.0 * t * t, 1e-11);
  }
}

TEST(GaussRule, IntegratesPolynomialsOfItsDegree) {
  const GaussRule& rule = gauss_rule();
  for (int power = 0; power < 2 * kPoints; ++power) {
    double sum = 0.0;
    for (int i = 0; i < kPoints; ++i) sum += rule.weights[i] * std::pow(rule.points[i], power);
    EXPECT_NEAR(sum, 1.0 / (power + 1), 1e-15) << power;
  }
  for (int power = 0; power < kPoints; ++power) {
    double sum = 0.0;
    for (int i = 0; i < kPoints; ++i) sum += integral_to(0.3)(i) * std::pow(rule.points[i], power);
    EXPECT_NEAR(sum, std::pow(0.3, power + 1) / (power + 1), 1e-15) << power;
  }
}

TEST(GaussRule, TellsLegendreCoefficients) {
  PointRow values;  // 2 P_3 - P_7 on [0, 1]
  for (int i = 0; i < kPoints; ++i) {
    const double x = 2.0 * gauss_rule().points[i] - 1.0;
    values(i) = 2.0 * std::legendre(3, x) - std::legendre(7, x);
  }
  const PointRow found = (legendre_coefficients() * values.transpose()).transpose();
  for (int k = 0; k < kPoints; ++k) EXPECT_NEAR(found(k), k == 3 ? 2.0 : k == 7 ? -1.0 : 0.0, 1e-14) << k;
}

/// A flexible body whose frame is held fast: nothing but M a'' + D a' + K a = 0, full matrices.
struct HeldBody {
  Model model;
  Equations equations;
  Dynamics dynamics;
  MotionState start;

  HeldBody(double damping, double stiffness_of_last)
      : model(make(damping, stiffness_of_last)), equations(model), dynamics(equations) {
    const Layout& layout = equations.layout();
    start.q = VecX::Zero(layout.n_q());
    start.Y = VecX::Zero(layout.n_Y());
    start.q(3) = 1.0;
    layout.a(start.q, BodyIndex(1)) << 0.01, -0.02, 0.015;
    layout.adot(start.Y, BodyIndex(1)) << 0.3, 0.1, -0.2;
    equations.update(0.0, start.q, start.Y);
  }

  static Model make(double damping, double stiffness_of_last) {
    testing::Numbers numbers(77);
    Model model;
    model.name = "held";
    model.file = "held.toml";
    model.gravity.setZero();
    model.bodies.resize(1);
    model.bodies.push_back(testing::make_body(numbers, "beam", 3));
    ModalData& modal = *model.bodies[1].modal;
    modal.stiffness *= 1e4;
    modal.stiffness.row(2) *= stiffness_of_last;
    modal.stiffness.col(2) *= stiffness_of_last;
    modal.damping = damping * modal.stiffness;
    Joint weld = testing::make_joint(numbers, model, *joints::find("weld"), kGround, 1);
    weld.sides = {testing::rigid(kGround, Vec3::Zero(), Mat3::Identity()),
                  testing::rigid(1, Vec3::Zero(), Mat3::Identity())};
    weld.sides[1].Psi_t_L = weld.sides[1].Psi_r_L = Mat3X::Zero(3, 3);
    model.joints.push_back(weld);
    return model;
  }

  /// [a; adot] at t.
  [[nodiscard]] VecX exact(double t) const {
    const ModalData& modal = *model.bodies[1].modal;
    const MatX inverse = equations.inertia(BodyIndex(1)).modal_mass().inverse();
    MatX A = MatX::Zero(6, 6);
    A.topRightCorner(3, 3).setIdentity();
    A.bottomLeftCorner(3, 3) = -inverse * modal.stiffness;
    A.bottomRightCorner(3, 3) = -inverse * modal.damping;
    return (A * t).exp() * modes_of(start);
  }

  [[nodiscard]] VecX modes_of(const MotionState& motion) const {
    VecX modes(6);
    modes << equations.layout().a(motion.q, BodyIndex(1)), equations.layout().adot(motion.Y, BodyIndex(1));
    return modes;
  }
};

/// However many periods a step holds: 24 steps for up to a hundred periods. Evaluations between steps are as exact as
/// 1e-12, of which the phase adds up 600 times.
TEST(Vibrations, AreIntegratedExactlyWhereNothingElseActs) {
  for (const double damping : {0.0, 1e-5, 1e-3, 1e-2}) {
    for (const double stiffness_of_last : {1.0, 0.0}) {
      HeldBody held(damping, stiffness_of_last);
      const auto stepper = make_collocation_stepper(held.dynamics, held.start, {1e-12, 0.3});
      for (const double t : {0.1, 0.3}) {
        for (double reached = 0.0; reached < t;) reached = stepper->step(t, 0.3);
        const VecX exact = held.exact(t);
        const VecX found = held.modes_of(stepper->motion());
        EXPECT_LT((found - exact).head(3).norm(), 1e-9 * held.start.q.tail(3).norm()) << damping << " " << t;
        EXPECT_LT((found - exact).tail(3).norm(), 1e-9 * 1e3 * held.start.q.tail(3).norm()) << damping << " " << t;
      }
      if (damping == 0.0) EXPECT_LT(stepper->steps(), 40);  // else the work rings, too
    }
  }
}

}  // namespace
}  // namespace concord::cartesian
