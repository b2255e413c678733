#include "relative/run/adams.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <utility>

#include "common/error.h"

namespace concord::relative {

namespace test {
long allocations_so_far();  // of the test program: equations_test.cpp
}

namespace {

/// y' = f(t, y) to a tolerance; modes differ from f by what `S` and `D` say at a time.
struct TestSystem : IntegratedSystem {
  std::function<VecX(double, const VecX&)> f;
  double tolerance = 1e-10;
  std::function<void(double, MatX&, MatX&)> modes = [](double, MatX&, MatX&) {};
  std::function<void(Eigen::Ref<VecX>)> onto_manifold = [](Eigen::Ref<VecX>) {};
  double undefined_beyond = HUGE_VAL;  // of y_0
  long evaluations = 0;
  long renewals = 0;

  void evaluate(double t, const Eigen::Ref<const VecX>& y, Eigen::Ref<VecX> ydot) override {
    ++evaluations;
    if (y(0) > undefined_beyond) throw SolverError("there is nothing beyond");
    ydot = f(t, y);
  }
  void weigh(const Eigen::Ref<const VecX>& /*y*/, Eigen::Ref<VecX> weights) const override {
    weights.setConstant(1.0 / tolerance);
  }
  void project(double /*t*/, Eigen::Ref<VecX> y) override { onto_manifold(y); }
  void differentiate(double, const Eigen::Ref<const VecX>&, const Eigen::Ref<const VecX>&, Eigen::Ref<MatX>) override {}
  void differentiate_modes(double t, const Eigen::Ref<const VecX>& /*y*/, const Eigen::Ref<const VecX>& /*ydot*/,
                           Eigen::Ref<MatX> S, Eigen::Ref<MatX> D) override {
    ++renewals;
    MatX stiffness = S;
    MatX damping = D;
    modes(t, stiffness, damping);
    S = stiffness;
    D = damping;
  }
};

ModalOscillators no_modes() { return {{}, {}, VecX()}; }
constexpr Adams::Lengths kLengths{1e-3, 0.5};

VecX at_end(Adams& adams, double t_end) {
  while (adams.t() < t_end) adams.step(t_end);
  return adams.y();
}

/// A driven pendulum.
TestSystem pendulum(double tolerance) {
  TestSystem system;
  system.tolerance = tolerance;
  system.f = [](double t, const VecX& y) {
    return VecX(Eigen::Vector2d(y(1), -std::sin(y(0)) + 0.3 * std::cos(1.7 * t)));
  };
  return system;
}

VecX pendulum_at(double t, double tolerance, long* evaluations = nullptr) {
  TestSystem system = pendulum(tolerance);
  Adams adams(system, no_modes(), Eigen::Vector2d(1.1, 0.4), kLengths);
  const VecX y = at_end(adams, t);
  if (evaluations != nullptr) *evaluations = system.evaluations;
  return y;
}

TEST(Adams, GainsDigitsWithTheTolerance) {
  const VecX exact = pendulum_at(20.0, 1e-14);
  std::vector<double> errors;
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
    long evaluations = 0;
    errors.push_back((pendulum_at(20.0, tolerance, &evaluations) - exact).norm());
    EXPECT_LT(errors.back(), 100.0 * tolerance) << tolerance;
    EXPECT_LT(evaluations, 1000) << tolerance;
  }
  EXPECT_GT(std::log10(errors.front() / errors.back()) / 8.0, 0.85);
}

/// Rates that are a polynomial of degree 11 in time are integrated exactly from twelve past times of any distances.
TEST(Adams, IsOfOrderTwelve) {
  const auto rate = [](double t) { return std::pow(t - 1.0, 11) + 3.0 * t; };
  const auto integral = [](double t) { return std::pow(t - 1.0, 12) / 12.0 + 1.5 * t * t; };
  const ModalOscillators none = no_modes();
  PastRates past(1, 0);
  PastRates then(1, 0);
  double t = 0.0;
  past.begin(VecX::Constant(1, rate(t)), VecX(), none);
  for (const double h : {0.1, 0.12, 0.2, 0.15, 0.1, 0.05, 0.07, 0.2, 0.2, 0.2, 0.1}) {
    std::swap(past, then);
    t += h;
    past.follow(then, h, VecX::Constant(1, rate(t)), VecX(), none);
  }
  ASSERT_EQ(past.n, 12);
  StepWeights weights(0);
  VecX y(1);
  for (const double h : {0.03, 0.1, 0.2}) {
    weights.integrate(0.0, h, past.ages, 12, none);
    weights.advance(VecX::Zero(1), past, 12, none, y);
    EXPECT_NEAR(y(0), integral(t + h) - integral(t), 1e-12) << h;
    weights.advance(VecX::Zero(1), past, 11, none, y);
    EXPECT_GT(std::abs(y(0) - (integral(t + h) - integral(t))), 1e-9) << h;
  }
}

TEST(Adams, ClimbsToOrderTwelve) {
  TestSystem system = pendulum(1e-13);
  Adams adams(system, no_modes(), Eigen::Vector2d(1.1, 0.4), kLengths);
  int highest = 0;
  while (adams.t() < 20.0) {
    adams.step(20.0);
    highest = std::max(highest, adams.order());
  }
  EXPECT_EQ(highest, 12);
}

/// Free and forced oscillators, coupled by stiffness and damping in other coordinates than their own.
struct Oscillators {
  MatX S, D;
  VecX force;  // constant

  [[nodiscard]] TestSystem system(double tolerance) const {
    TestSystem made;
    made.tolerance = tolerance;
    made.f = [*this](double /*t*/, const VecX& y) {
      const Eigen::Index m = S.cols();
      VecX ydot(2 * m);
      ydot << y.tail(m), force - S * y.head(m) - D * y.tail(m);
      return ydot;
    };
    made.modes = [*this](double /*t*/, MatX& stiffness, MatX& damping) {
      stiffness = S;
      damping = D;
    };
    return made;
  }
  /// One step of h from the state y, by the exponential of the doubled matrix in small parts.
  [[nodiscard]] VecX exact(const VecX& y, double t) const {
    const Eigen::Index m = S.cols();
    MatX A = MatX::Zero(2 * m + 1, 2 * m + 1);
    A.block(0, m, m, m).setIdentity();
    A.block(m, 0, m, m) = -S;
    A.block(m, m, m, m) = -D;
    A.block(m, 2 * m, m, 1) = force;
    constexpr int kHalvings = 24;
    A *= t / std::pow(2.0, kHalvings);
    const MatX one = MatX::Identity(A.rows(), A.cols());
    MatX less = A * (one + A / 2.0 * (one + A / 3.0 * (one + A / 4.0)));  // exp(A) - 1
    for (int k = 0; k < kHalvings; ++k) less = (less * less + 2.0 * less).eval();
    VecX extended(2 * m + 1);
    extended << y, 1.0;
    return (extended + less * extended).head(2 * m);
  }
};

ModalOscillators modes_of(Eigen::Index m) {
  std::vector<int> a;
  std::vector<int> adot;
  VecX sizes(m);
  for (int k = 0; k < m; ++k) {
    a.push_back(k);
    adot.push_back(static_cast<int>(m) + k);
    sizes(k) = std::pow(10.0, k);
  }
  return {a, adot, sizes};
}

/// Proportional damping of one pair of oscillators that are coupled.
Oscillators coupled(double first, double second, double damping_first, double damping_second) {
  MatX V(2, 2);
  V << 1.0, 0.4, -2.0, 3.0;
  const MatX inverse = V.inverse();
  return {V * Eigen::Vector2d(first, second).asDiagonal() * inverse,
          V * Eigen::Vector2d(damping_first, damping_second).asDiagonal() * inverse, Eigen::Vector2d(0.7, -3.0)};
}

/// Ringing, critically damped, overdamped, drifting, growing, unstable: one step is as exact as many, at any length.
TEST(Adams, IntegratesOscillatorsExactlyInOneStepOfAnyLength) {
  const std::vector<Oscillators> all{coupled(400.0, 9e4, 0.0, 0.0),    coupled(400.0, 9e4, 3.0, 30.0),
                                     coupled(100.0, 25.0, 20.0, 10.0), coupled(1.0, 4.0, 20.0, 300.0),
                                     coupled(0.0, 0.5, 5.0, 0.0),      coupled(-4.0, 9.0, 0.0, -0.5),
                                     coupled(0.0, 50.0, 0.0, 1.0)};
  const Eigen::Vector4d start(0.3, -1.2, 2.0, 0.5);
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (const double t : {1e-3, 0.06, 0.5}) {
      TestSystem system = all[i].system(1e-6);
      Adams adams(system, modes_of(2), start, {t, t});
      adams.step(1000.0 * t);
      ASSERT_EQ(adams.t(), t);
      const VecX exact = all[i].exact(start, t);
      EXPECT_LT((adams.y() - exact).norm(), 2e-10 * exact.norm() + 1e-12) << "oscillators " << i << ", step " << t;
    }
  }
}

/// Of two modes that are damped by each other, only the diagonal of damping in the basis of stiffness is exact; the
/// rest is left to the polynomials.
TEST(Adams, FollowsOscillatorsWhoseDampingCouplesThem) {
  Oscillators pair = coupled(400.0, 9e4, 1.0, 1.0);
  pair.D << 4.0, -3.0, 12.0, 60.0;
  const Eigen::Vector4d start(0.3, -1.2, 2.0, 0.5);
  TestSystem system = pair.system(1e-11);
  Adams adams(system, modes_of(2), start, kLengths);
  EXPECT_LT((at_end(adams, 1.0) - pair.exact(start, 1.0)).norm(), 1e-9);
}

/// A mode whose stiffness changes with time: L is renewed again and again, and the remainders of past times with it.
/// What was wrong there would be an error of the first order.
TEST(Adams, StaysAccurateWhenTheLinearPartIsRenewed) {
  const auto run = [](bool is_exponential, double tolerance, long& evaluations, long& renewals) {
    TestSystem system;
    system.tolerance = tolerance;
    const auto stiffness = [](double t) { return 1e4 * (1.0 + 0.3 * std::sin(2.0 * t)); };
    system.f = [=](double t, const VecX& y) {
      return VecX(Eigen::Vector3d(y(1), -stiffness(t) * y(0) - 0.4 * y(1) + std::cos(3.0 * t) * y(2), -y(2) * y(2)));
    };
    system.modes = [=](double t, MatX& S, MatX& D) {
      S(0, 0) = stiffness(t);
      D(0, 0) = 0.4;
    };
    Adams adams(system, is_exponential ? ModalOscillators({0}, {1}, VecX::Ones(1)) : no_modes(),
                Eigen::Vector3d(0.01, 0.5, 1.0), kLengths);
    const VecX y = at_end(adams, 6.0);
    evaluations = system.evaluations;
    renewals = system.renewals;
    return y;
  };
  long evaluations = 0;
  long evaluations_plain = 0;
  long renewals = 0;
  long none = 0;
  const VecX exponential = run(true, 1e-11, evaluations, renewals);
  const VecX plain = run(false, 1e-13, evaluations_plain, none);
  EXPECT_LT((exponential - plain).cwiseQuotient(Eigen::Vector3d(0.01, 1.0, 1.0)).norm(), 1e-8);
  EXPECT_GT(renewals, 20);
  run(false, 1e-11, evaluations_plain, none);
  EXPECT_LT(evaluations, 0.75 * evaluations_plain);
}

/// Anywhere within a step the state is as accurate as at its end.
TEST(Adams, InterpolatesAsAccuratelyAsItSteps) {
  const Oscillators pair = coupled(400.0, 9e4, 3.0, 30.0);
  const Eigen::Vector4d start(0.3, -1.2, 2.0, 0.5);
  TestSystem ringing = pair.system(1e-10);
  Adams of_modes(ringing, modes_of(2), start, {1e-3, 0.02});
  TestSystem swinging = pendulum(1e-11);
  Adams of_pendulum(swinging, no_modes(), Eigen::Vector2d(1.1, 0.4), kLengths);
  VecX y(4);
  VecX q(2);
  double t_modes = 0.0;
  for (double t_before = 0.0; of_modes.t() < 0.5; t_before = of_modes.t()) {
    of_modes.step(0.5);
    for (const double part : {0.0, 0.3, 0.9, 1.0}) {
      t_modes = t_before + part * (of_modes.t() - t_before);
      of_modes.interpolate(t_modes, y);
      ASSERT_LT((y - pair.exact(start, t_modes)).norm(), 1e-8) << t_modes;
    }
  }
  for (double t_before = 0.0; of_pendulum.t() < 3.0; t_before = of_pendulum.t()) {
    of_pendulum.step(3.0);
    const double t = t_before + 0.4 * (of_pendulum.t() - t_before);
    of_pendulum.interpolate(t, q);
    ASSERT_LT((q - pendulum_at(t, 1e-13)).norm(), 1e-9) << t;
  }
}

/// Rates that jump at a time at which the method begins anew cost no accuracy; a step made anew leaves nothing of the
/// one before.
TEST(Adams, BeginsAnewAndMakesStepsAnew) {
  TestSystem system = pendulum(1e-11);
  const auto smooth = system.f;
  double jump = 0.0;
  system.f = [&](double t, const VecX& y) { return VecX(smooth(t, y) + Eigen::Vector2d(0.0, jump)); };
  Adams adams(system, no_modes(), Eigen::Vector2d(1.1, 0.4), kLengths);
  while (adams.t() < 1.0) adams.step(5.0);
  for (const double h : {0.01, 0.02, 0.015}) adams.step_exactly(h);
  const double t = adams.t();
  const VecX y = adams.y();
  EXPECT_LT((y - pendulum_at(t, 1e-13)).norm(), 1e-9);
  jump = 2.0;
  adams.restart(0.1);
  const VecX end = at_end(adams, 3.0);

  TestSystem second = pendulum(1e-13);
  second.f = [&](double time, const VecX& at) { return VecX(smooth(t + time, at) + Eigen::Vector2d(0.0, jump)); };
  Adams reference(second, no_modes(), y, kLengths);
  EXPECT_LT((end - at_end(reference, 3.0 - t)).norm(), 1e-9);
}

/// What steps lose of time by rounding is kept: laws are asked at the time that the state has gone.
/// A turning state is the clock here; the third number adds up the angle between it and the time.
TEST(Adams, AddsUpNoRoundOffOfTime) {
  TestSystem system;
  system.tolerance = 1e-16;
  system.f = [](double t, const VecX& y) {
    return VecX(Eigen::Vector3d(-y(1), y(0), y(0) * std::sin(t) - y(1) * std::cos(t)));
  };
  Adams adams(system, no_modes(), Eigen::Vector3d(1.0, 0.0, 0.0), {1e-4, 1e-4});
  EXPECT_NEAR(at_end(adams, 10.0)(2), 0.0, 5e-12);
  EXPECT_GT(adams.steps(), 90000);
}

/// Rates that are the same at both ends of what is asked for, and nowhere between, are seen.
TEST(Adams, DoesNotStepOverWhatIsTheSameAtBothEnds) {
  TestSystem system;
  system.f = [](double t, const VecX& /*y*/) { return VecX(VecX::Constant(1, 30.0 * t * t * std::pow(1.0 - t, 2))); };
  Adams adams(system, no_modes(), VecX::Zero(1), {10.0, 10.0});
  EXPECT_NEAR(at_end(adams, 1.0)(0), 1.0, 1e-8);
}

/// A state that takes another name, as one that is whole turns less, goes on as it was.
TEST(Adams, GoesOnUnderAnotherName) {
  TestSystem system = pendulum(1e-11);
  Adams adams(system, no_modes(), Eigen::Vector2d(1.1, 0.4), kLengths);
  while (adams.t() < 2.0) adams.step(5.0);
  const double turn = 2.0 * M_PI;
  const double t = adams.t();
  const long evaluations = system.evaluations;
  adams.rename(adams.y() - Eigen::Vector2d(turn, 0.0));
  VecX within(2);
  adams.interpolate(t - 1e-3, within);
  EXPECT_LT((within + Eigen::Vector2d(turn, 0.0) - pendulum_at(t - 1e-3, 1e-13)).norm(), 1e-9);
  adams.step(5.0);
  EXPECT_EQ(system.evaluations, evaluations + 2);
  EXPECT_LT((at_end(adams, 5.0) + Eigen::Vector2d(turn, 0.0) - pendulum_at(5.0, 1e-13)).norm(), 1e-9);
}

/// A step into a place that is not defined is tried again, shorter; a run into one ends with its reason.
TEST(Adams, ComesNearToWhatIsNotDefinedAndSaysWhy) {
  TestSystem system = pendulum(1e-8);
  system.f = [](double /*t*/, const VecX& y) { return VecX(VecX::Constant(1, 1.0 / std::sqrt(1.0 - y(0)))); };
  system.undefined_beyond = 0.99;
  Adams adams(system, no_modes(), VecX::Zero(1), kLengths);
  try {
    at_end(adams, 2.0);
    FAIL() << "it has gone on to " << adams.t();
  } catch (const SolverError& error) {
    EXPECT_STREQ(error.what(), "there is nothing beyond");
  }
  EXPECT_NEAR(adams.t(), 2.0 / 3.0 * (1.0 - 1e-3), 1e-6);
}

/// The last evaluation follows the projection: rates at the next step's begin are those of the manifold.
TEST(Adams, StaysOnTheManifold) {
  TestSystem system;
  system.tolerance = 1e-9;
  system.f = [](double /*t*/, const VecX& y) { return VecX(Eigen::Vector2d(-y(1), y(0))); };
  system.onto_manifold = [](Eigen::Ref<VecX> y) { y /= y.norm(); };
  Adams adams(system, no_modes(), Eigen::Vector2d(1.0, 0.0), kLengths);
  const VecX y = at_end(adams, 50.0);
  EXPECT_NEAR(y.norm(), 1.0, 1e-15);
  EXPECT_LT((y - Eigen::Vector2d(std::cos(50.0), std::sin(50.0))).norm(), 1e-7);
}

#if !defined(CONCORD_SANITIZED)
/// Two modes and a pendulum.
struct SteadySystem : TestSystem {
  void evaluate(double t, const Eigen::Ref<const VecX>& y, Eigen::Ref<VecX> ydot) override {
    ydot(0) = y(2);
    ydot(1) = y(3);
    ydot(2) = -400.0 * y(0) + 30.0 * y(1);
    ydot(3) = 20.0 * y(0) - 900.0 * y(1) - 0.3 * y(3) + std::cos(t);
  }
  void differentiate_modes(double /*t*/, const Eigen::Ref<const VecX>& /*y*/, const Eigen::Ref<const VecX>& /*ydot*/,
                           Eigen::Ref<MatX> S, Eigen::Ref<MatX> D) override {
    ++renewals;
    S << 400.0, -30.0, -20.0, 900.0;
    D << 0.0, 0.0, 0.0, 0.3;
  }
};

TEST(Adams, AllocatesNothingInAStep) {
  SteadySystem system;
  system.tolerance = 1e-12;
  Adams adams(system, modes_of(2), Eigen::Vector4d(0.3, -1.2, 2.0, 0.5), {1e-3, 0.02});
  VecX within(4);
  for (int k = 0; k < 60; ++k) adams.step(100.0);
  const long renewals = system.renewals;
  const long before = test::allocations_so_far();
  for (int k = 0; k < 30; ++k) {
    adams.step(100.0);
    adams.interpolate(adams.t() - 1e-3, within);
  }
  EXPECT_EQ(test::allocations_so_far() - before, 0);
  EXPECT_EQ(system.renewals, renewals);
}
#endif

TEST(ModalOscillators, RespondAlikeWhereverTheClosedFormChanges) {
  for (const double damping : {0.0, 3.0, 40.0}) {
    const double critical = 0.25 * damping * damping;
    for (const double beside : {-1e-9, 0.0, 1e-9}) {
      const Propagator at = propagator(critical, damping, 0.7);
      const Propagator near = propagator(critical + beside, damping, 0.7);
      EXPECT_NEAR(near.xx, at.xx, 1e-8);
      EXPECT_NEAR(near.xv, at.xv, 1e-8);
      EXPECT_NEAR(near.vx, at.vx, 1e-8);
      EXPECT_NEAR(near.vv, at.vv, 1e-8);
    }
  }
  const Propagator stiff = propagator(1.0, 1e6, 10.0);
  EXPECT_NEAR(stiff.xx, std::exp(-1e-5), 1e-9);
  EXPECT_TRUE(std::isfinite(stiff.vv));
}

}  // namespace
}  // namespace concord::relative
