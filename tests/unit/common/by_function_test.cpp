#include "common/joints/by_function.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "common/rotation.h"

namespace concord::joints {
namespace {

// Jets ---------------------------------------------------------------------------------------------------------------

/// A function of two numbers, on jets and on doubles.
struct TwoFacedFunction {
  std::string name;
  std::function<Jet(const Jet&, const Jet&)> on_jets;
  std::function<double(double, double)> on_numbers;
};

#define TWO_FACED(expression)                                                                      \
  TwoFacedFunction {                                                                               \
#expression, [](const Jet& x, const Jet& y) -> Jet { (void)y; return expression; },              \
        [](double x, double y) -> double { (void)y; return expression; } \
  }

std::vector<TwoFacedFunction> functions_of_two_numbers() {
  return {TWO_FACED(x * y - 3.0 * x + y),
          TWO_FACED((x + 2.0) / (y * y)),
          TWO_FACED(1.0 / (2.0 * x + y)),
          TWO_FACED(sin(x * y)),
          TWO_FACED(cos(x - 2.0 * y)),
          TWO_FACED(tan(x)),
          TWO_FACED(asin(0.5 * x * y)),
          TWO_FACED(acos(0.7 * x)),
          TWO_FACED(atan(3.0 * x + y)),
          TWO_FACED(sinh(x) * cosh(y)),
          TWO_FACED(tanh(2.0 * x)),
          TWO_FACED(exp(-x) * log(1.0 + y * y)),
          TWO_FACED(sqrt(1.0 + x * x + y)),
          TWO_FACED(pow(y, 2.7) - pow(-x, 3)),
          TWO_FACED(abs(x - y)),
          TWO_FACED(hypot(x, y)),
          TWO_FACED(atan2(y, x)),
          TWO_FACED(atan2(-x, -y))};
}

TEST(Jet, DerivativesOfEveryFunctionAreThoseByDifferences) {
  constexpr double kStep = 1e-3;
  const double x0 = 0.6, xdot = -1.3, xddot = 0.9, y0 = 1.1, ydot = 0.7, yddot = -2.1;
  const Jet x(x0, Vec6::Unit(1), xdot, xddot);
  const Jet y(y0, Vec6::Unit(4), ydot, yddot);
  for (const TwoFacedFunction& f : functions_of_two_numbers()) {
    SCOPED_TRACE(f.name);
    const Jet jet = f.on_jets(x, y);
    EXPECT_NEAR(jet.value, f.on_numbers(x0, y0), 1e-15);
    /// Central differences extrapolated to a vanishing step.
    const auto slope = [&](const std::function<double(double)>& along) {
      const double coarse = (along(2 * kStep) - along(-2 * kStep)) / (4 * kStep);
      const double fine = (along(kStep) - along(-kStep)) / (2 * kStep);
      return (4 * fine - coarse) / 3;
    };
    const auto curvature = [&](const std::function<double(double)>& along) {
      const double coarse = (along(2 * kStep) - 2 * along(0) + along(-2 * kStep)) / (4 * kStep * kStep);
      const double fine = (along(kStep) - 2 * along(0) + along(-kStep)) / (kStep * kStep);
      return (4 * fine - coarse) / 3;
    };
    const auto on_the_way = [&](double t) {
      return f.on_numbers(x0 + t * xdot + 0.5 * t * t * xddot, y0 + t * ydot + 0.5 * t * t * yddot);
    };
    EXPECT_NEAR(jet.gradient(1), slope([&](double h) { return f.on_numbers(x0 + h, y0); }), 1e-9);
    EXPECT_NEAR(jet.gradient(4), slope([&](double h) { return f.on_numbers(x0, y0 + h); }), 1e-9);
    EXPECT_NEAR(jet.rate, slope(on_the_way), 1e-9);
    EXPECT_NEAR(jet.rate_of_rate, curvature(on_the_way), 1e-7);
    EXPECT_EQ(jet.gradient(0), 0.0);
  }
}

TEST(Jet, GoesThroughAssignmentAndComparison) {
  Jet x(2.0, Vec6::Unit(0), 1.0, 0.0);
  x *= x;
  x -= 1.0;
  x /= 3.0;
  x += x;
  EXPECT_DOUBLE_EQ(x.value, 2.0);
  EXPECT_DOUBLE_EQ(x.rate, 8.0 / 3.0);
  EXPECT_DOUBLE_EQ(x.rate_of_rate, 4.0 / 3.0);
  EXPECT_TRUE(x > 1.5 && x >= 2.0 && x < 2.5 && x <= 2.0 && x == 2.0 && x != 2.5);
}

// Functions of the placement -----------------------------------------------------------------------------------------

const Placement kPlacement{Vec3(0.31, -0.47, 0.22), rotation_about(Vec3(Vec3(2, -1, 3).normalized()), 0.8)};
const Vec6 kMotion = (Vec6() << 0.7, -1.1, 0.4, 0.9, 0.3, -1.6).finished();

/// The placement after `time` with constant ddot and angular velocity.
Placement later(const Placement& at, const Vec6& v_rel, double time) {
  const Vec3 omega = v_rel.tail<3>();
  return {at.d + time * v_rel.head<3>(), rotation_about(Vec3(omega.normalized()), time * omega.norm()) * at.R};
}

TEST(FunctionOfPlacement, HasTheDerivativesThatHandGives) {
  const auto f = function_of_placement([]<class T>(const Vec3Of<T>& d, const Mat3Of<T>& R) {
    return VectorOf<T, 3>(d.dot(d), R(0, 1), d.dot(R.col(2)));
  });
  ASSERT_EQ(f->n(), 3);
  FunctionOfPlacement::Rows rows;
  f->evaluate(kPlacement, kMotion, rows);
  const Vec3& d = kPlacement.d;
  const Vec3 ddot = kMotion.head<3>();
  const Vec3 omega = kMotion.tail<3>();
  const Vec3 y = kPlacement.R.col(1);
  const Vec3 z = kPlacement.R.col(2);
  EXPECT_EQ(rows.n, 3);
  EXPECT_NEAR(rows.value(0), d.squaredNorm(), 1e-15);
  EXPECT_NEAR(rows.value(1), y.x(), 1e-15);
  EXPECT_NEAR(rows.value(2), d.dot(z), 1e-15);
  EXPECT_LE((rows.gradient.col(0) - (Vec6() << 2 * d, Vec3::Zero()).finished()).norm(), 1e-15);
  EXPECT_LE((rows.gradient.col(1) - (Vec6() << Vec3::Zero(), y.cross(Vec3::UnitX())).finished()).norm(), 1e-15);
  EXPECT_LE((rows.gradient.col(2) - (Vec6() << z, z.cross(d)).finished()).norm(), 1e-15);
  EXPECT_NEAR(rows.bias(0), 2 * ddot.squaredNorm(), 1e-14);
  EXPECT_NEAR(rows.bias(1), omega.cross(omega.cross(y)).x(), 1e-14);
  EXPECT_NEAR(rows.bias(2), 2 * ddot.dot(omega.cross(z)) + d.dot(omega.cross(omega.cross(z))), 1e-14);
}

/// Something that no page would want: every entry of (d, R) takes part in it.
struct Tangled {
  template <class T>
  VectorOf<T, 2> operator()(const Vec3Of<T>& d, const Mat3Of<T>& R) const {
    const Vec3Of<T> turned = R * d;
    return {sin(d.x() * R(1, 2)) + turned.norm() * exp(R(2, 0)), atan2(turned.y(), R(0, 0)) * d.cross(turned).z()};
  }
};

TEST(FunctionOfPlacement, HasTheDerivativesThatDifferencesGive) {
  constexpr double kStep = 1e-4;
  const auto f = function_of_placement(Tangled{});
  const auto value = [](const Placement& at) { return Eigen::Vector2d(Tangled{}(at.d, at.R)); };
  FunctionOfPlacement::Rows rows;
  f->evaluate(kPlacement, kMotion, rows);
  EXPECT_EQ(rows.value.head<2>(), value(kPlacement));
  for (int k = 0; k < 6; ++k) {
    const Eigen::Vector2d slope =
        (value(later(kPlacement, Vec6::Unit(k), kStep)) - value(later(kPlacement, Vec6::Unit(k), -kStep))) /
        (2 * kStep);
    EXPECT_LE((rows.gradient.row(k).head<2>().transpose() - slope).norm(), 1e-7) << k;
  }
  const Eigen::Vector2d curvature =
      (value(later(kPlacement, kMotion, kStep)) - 2 * value(kPlacement) + value(later(kPlacement, kMotion, -kStep))) /
      (kStep * kStep);
  EXPECT_LE((rows.bias.head<2>() - curvature).norm(), 1e-6);
}

// Motions ------------------------------------------------------------------------------------------------------------

/// A tilting carriage on a helix: two coordinates that do not commute.
struct Carriage {
  template <class T>
  PlacementOf<T> operator()(const VectorOf<T, 2>& q) const {
    const Vec3Of<T> d(0.3 * cos(q(0)), 0.3 * sin(q(0)), 0.05 * q(0) * q(1));
    return {d, rotation_by(Axis::z, q(0)) * rotation_by(Axis::x, q(1)) * rotation_by(Axis::y, T(0.4))};
  }
};

FunctionOfCoordinates::Motion carriage_at(const Eigen::Vector2d& q, const Eigen::Vector2d& u) {
  FunctionOfCoordinates::Motion motion;
  function_of_coordinates<2>(Carriage{})->evaluate(q.data(), u.data(), motion);
  return motion;
}

TEST(FunctionOfCoordinates, HasTheDerivativesThatHandGives) {
  const Eigen::Vector2d q(0.7, -1.2);
  const Eigen::Vector2d u(1.9, 0.6);
  const FunctionOfCoordinates::Motion motion = carriage_at(q, u);
  const double s = std::sin(q(0));
  const double c = std::cos(q(0));
  const Mat3 R = rotation_about(Axis::z, q(0)) * rotation_about(Axis::x, q(1)) * rotation_about(Axis::y, 0.4);
  const Vec3 tilt_axis(c, s, 0.0);
  EXPECT_LE((motion.placement.d - Vec3(0.3 * c, 0.3 * s, 0.05 * q(0) * q(1))).norm(), 1e-15);
  EXPECT_LE((motion.placement.R - R).norm(), 1e-15);
  EXPECT_LE((motion.S.col(0) - (Vec6() << -0.3 * s, 0.3 * c, 0.05 * q(1), Vec3::UnitZ()).finished()).norm(), 1e-15);
  EXPECT_LE((motion.S.col(1) - (Vec6() << 0.0, 0.0, 0.05 * q(0), tilt_axis).finished()).norm(), 1e-15);
  EXPECT_TRUE(motion.S.rightCols<4>().isZero(0.0));
  Vec6 Sdot_u;
  Sdot_u << -0.3 * c * u(0) * u(0), -0.3 * s * u(0) * u(0), 0.1 * u(0) * u(1),
      u(0) * u(1) * Vec3::UnitZ().cross(tilt_axis);
  EXPECT_LE((motion.Sdot_u - Sdot_u).norm(), 1e-14);
}

TEST(FunctionOfCoordinates, RatesOfSpeedsAreThoseByDifferences) {
  constexpr double kStep = 1e-5;
  const Eigen::Vector2d q(-2.3, 0.8);
  const Eigen::Vector2d u(0.8, -1.4);
  const Vec6 before = carriage_at(q - kStep * u, u).S.leftCols<2>() * u;
  const Vec6 after = carriage_at(q + kStep * u, u).S.leftCols<2>() * u;
  EXPECT_LE((carriage_at(q, u).Sdot_u - (after - before) / (2 * kStep)).norm(), 1e-9);
}

}  // namespace
}  // namespace concord::joints
