#include "compare/quantities/curve_metrics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace concord::compare {

CurveMetrics compare_curves(const std::vector<double>& times, const std::array<std::vector<double>, 2>& curves) {
  CurveMetrics metrics;
  std::array<double, 2> squares{};
  double product = 0.0;
  double difference = 0.0;
  for (std::size_t k = 0; k < times.size(); ++k) {
    for (std::size_t who = 0; who < 2; ++who) {
      const double value = curves[who][k];
      squares[who] += value * value;
      if (std::abs(value) <= metrics.peak[who]) continue;
      metrics.peak[who] = std::abs(value);
      metrics.t_peak[who] = times[k];
    }
    product += curves[0][k] * curves[1][k];
    difference += (curves[0][k] - curves[1][k]) * (curves[0][k] - curves[1][k]);
  }
  if (times.empty()) return metrics;
  const auto [lowest, highest] = std::minmax_element(curves[0].begin(), curves[0].end());
  const double range = *highest > *lowest ? *highest - *lowest : std::max(metrics.peak[0], metrics.peak[1]);
  if (range > 0.0) metrics.rms_over_range = std::sqrt(difference / static_cast<double>(times.size())) / range;
  if (squares[0] == 0.0 || squares[1] == 0.0) return metrics;
  metrics.magnitude = std::sqrt(squares[1] / squares[0]) - 1.0;
  const double cosine = std::clamp(product / std::sqrt(squares[0] * squares[1]), -1.0, 1.0);
  metrics.phase = std::acos(cosine) / std::numbers::pi;
  metrics.combined = std::hypot(metrics.magnitude, metrics.phase);
  return metrics;
}

}  // namespace concord::compare
