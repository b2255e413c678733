#include "relative/run/step_weights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace concord::relative {

namespace {

constexpr int kNodes = 16;

/// Gauss' rule on [0, 1], by Newton's method on the Legendre polynomial.
struct GaussRule {
  std::array<double, kNodes> at{}, weight{};

  GaussRule() {
    for (int i = 0; i < kNodes; ++i) {
      double x = std::cos(std::numbers::pi * (i + 0.75) / (kNodes + 0.5));
      double slope = 1.0;
      for (int round = 0; round < 10; ++round) {
        double value = x;
        double before = 1.0;
        for (int n = 2; n <= kNodes; ++n) {
          const double next = ((2 * n - 1) * x * value - (n - 1) * before) / n;
          before = value;
          value = next;
        }
        slope = kNodes * (x * value - before) / (x * x - 1.0);
        x -= value / slope;
      }
      at[i] = 0.5 * (1.0 - x);
      weight[i] = 1.0 / ((1.0 - x * x) * slope * slope);
    }
  }
};

const GaussRule& gauss_rule() {
  static const GaussRule rule;
  return rule;
}

}  // namespace

StepWeights::StepWeights(Eigen::Index n_modes)
    : integrals_(VecX::Zero(kMostTimes)),
      polynomials_(VecX::Zero(kMostTimes)),
      to_x_(MatX::Zero(n_modes, kMostTimes)),
      to_v_(MatX::Zero(n_modes, kMostTimes)),
      propagators_(n_modes),
      z_(VecX::Zero(2 * n_modes)),
      x_(VecX::Zero(n_modes)),
      v_(VecX::Zero(n_modes)) {}

void StepWeights::write_polynomials(double tau) {  // (R84)
  double value = 1.0;
  for (int j = 0; j <= last_; ++j) {
    polynomials_(j) = value;
    value *= tau + ages_[j];
  }
}

void StepWeights::add_node(double tau, double weight, const ModalOscillators& modes) {
  write_polynomials(tau);
  const auto weighted = weight * polynomials_.head(last_ + 1);
  integrals_.head(last_ + 1) += weighted;
  for (Eigen::Index k = 0; k < modes.size(); ++k) {
    const Propagator response = propagator(modes.stiffness()(k), modes.damping()(k), upper_ - tau);
    to_x_.row(k).head(last_ + 1) += response.xv * weighted.transpose();
    to_v_.row(k).head(last_ + 1) += response.vv * weighted.transpose();
  }
}

/// Gauss' rule is exact for the polynomials. Oscillators respond within each part by few radians or decay times, which
/// it follows to round-off.
void StepWeights::integrate(double lower, double upper, const Ages& ages, int last, const ModalOscillators& modes) {
  constexpr double kOfOnePart = 8.0;
  const bool is_same = lower == lower_ && upper == upper_ && last == last_ &&
                       std::equal(ages.begin(), ages.begin() + last + 1, ages_.begin());
  if (is_same) return;
  lower_ = lower;
  upper_ = upper;
  last_ = last;
  ages_ = ages;
  integrals_.setZero();
  to_x_.setZero();
  to_v_.setZero();
  const int parts = 1 + static_cast<int>(modes.fastest() * (upper - lower) / kOfOnePart);
  const double length = (upper - lower) / parts;
  for (int part = 0; part < parts; ++part) {
    for (int node = 0; node < kNodes; ++node) {
      add_node(lower + (part + gauss_rule().at[node]) * length, gauss_rule().weight[node] * length, modes);
    }
  }
  write_polynomials(upper);
  for (Eigen::Index k = 0; k < modes.size(); ++k) {
    propagators_[k] = propagator(modes.stiffness()(k), modes.damping()(k), upper - lower);
  }
}

void StepWeights::advance(const VecX& y_lower, const PastRates& past, int n, const ModalOscillators& modes,
                          Eigen::Ref<VecX> y) {  // (R86)
  const Eigen::Index m = modes.size();
  y = y_lower;
  y.noalias() += past.f.leftCols(n) * integrals_.head(n);
  if (m == 0) return;
  modes.gather(y_lower, z_);
  modes.to_oscillators(z_.head(m), x_);
  modes.to_oscillators(z_.tail(m), v_);
  for (Eigen::Index k = 0; k < m; ++k) {
    const Propagator& free = propagators_[k];
    const double x = free.change_of_xx * x_(k) + free.xv * v_(k);
    const double v = free.vx * x_(k) + free.change_of_vv * v_(k);
    const auto remainders = past.g.row(k).head(n);
    x_(k) = x + to_x_.row(k).head(n).dot(remainders);
    v_(k) = v + to_v_.row(k).head(n).dot(remainders);
  }
  // Changes alone go through V: round-off of the whole would be magnified by it in every step.
  modes.scatter(x_, v_, y);
  modes.add(z_, y);
}

void StepWeights::write_change(int j, double back, const VecX& f, const VecX& g, const ModalOscillators& modes,
                               Eigen::Ref<VecX> change) {
  const auto part = [&](const auto& of) { return back == 0.0 ? of(j) : of(j) - back * of(j - 1); };
  change = part([&](int i) { return integrals_(i); }) * f;
  if (modes.size() == 0) return;
  for (Eigen::Index k = 0; k < modes.size(); ++k) {
    x_(k) = part([&](int i) { return to_x_(k, i); }) * g(k);
    v_(k) = part([&](int i) { return to_v_(k, i); }) * g(k);
  }
  modes.scatter(x_, v_, change);
}

}  // namespace concord::relative
