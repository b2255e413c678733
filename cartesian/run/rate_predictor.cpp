#include "cartesian/run/rate_predictor.h"

#include <algorithm>

namespace concord::cartesian {

void RatePredictor::begin(double t0, double length, double last_start, double last_length) {
  for (int m = 0; m < kPoints; ++m) {
    times_[m] = (last_start - t0 + gauss_rule().points[m] * last_length) / length;
    times_[kPoints + m] = gauss_rule().points[m];
  }
  errors_.fill(0.0);
}

void RatePredictor::write_factors(int m, int count, double x, double* factors) const {
  write_interpolation(times_.data() + kPoints + m - count, count, x, factors);
}

void RatePredictor::predict(int m, const PointRates& last, PointRates& now) const {
  const int count = std::min(used_, most_before(m));
  if (count == 0) return;
  const PointRates& known = now;
  std::array<double, kPoints> factors;
  for (int to = m; to < kPoints; ++to) {
    write_factors(m, count, gauss_rule().points[to], factors.data());
    auto ydot = now.ydot.col(to);
    auto g = now.g.col(to);
    ydot.setZero();
    g.setZero();
    for (int j = 0; j < count; ++j) {
      const int from = m - count + j;
      ydot += factors[j] * (from < 0 ? last.ydot.col(kPoints + from) : known.ydot.col(from));
      g += factors[j] * (from < 0 ? last.g.col(kPoints + from) : known.g.col(from));
    }
  }
}

void RatePredictor::learn(int m, const PointRates& last, const PointRates& now, const Collocation& collocation,
                          const VecX& weights) {
  constexpr int kEvery = 3;  // points: the others tell the same
  if (!has_past_ || m % kEvery != 1) return;
  std::array<double, kPoints> factors;
  for (int count = 1; count <= kPoints; ++count) {
    write_factors(m, count, gauss_rule().points[m], factors.data());
    of_ydot_ = -now.ydot.col(m);
    of_g_ = -now.g.col(m);
    for (int j = 0; j < count; ++j) {
      const int from = m - count + j;
      of_ydot_ += factors[j] * (from < 0 ? last.ydot.col(kPoints + from) : now.ydot.col(from));
      of_g_ += factors[j] * (from < 0 ? last.g.col(kPoints + from) : now.g.col(from));
    }
    collocation.write_change(of_ydot_, of_g_, error_);
    errors_[count] = std::max(errors_[count], error_.cwiseProduct(weights).cwiseAbs().maxCoeff());
  }
}

void RatePredictor::choose() {
  constexpr double kBetter = 0.7;  // another point must make the error so much smaller
  if (!has_past_) return;
  used_ = 1;
  for (int count = 2; count <= kPoints; ++count) {
    if (errors_[count] < kBetter * errors_[used_]) used_ = count;
  }
}

}  // namespace concord::cartesian
