#pragma once

#include <array>
#include <vector>

/// How two curves of one quantity differ, in the numbers by which simulations are commonly held against each other.
/// They explain a difference; no verdict rests on them.
namespace concord::compare {

struct CurveMetrics {
  /// The largest size of each curve and its time [s].
  std::array<double, 2> peak{};
  std::array<double, 2> t_peak{};
  /// Root of the mean square of the difference, over the range of the first curve; over the larger peak if that
  /// curve is constant.
  double rms_over_range = 0.0;
  /// Sprague and Geers: how much larger the second curve is, how much it is shifted (1 is half a period), and both.
  double magnitude = 0.0;
  double phase = 0.0;
  double combined = 0.0;
};

/// Of two curves at the same times, evenly spaced; the first one counts as the measure. Curves that are zero throughout
/// have no magnitude and no phase: 0.
CurveMetrics compare_curves(const std::vector<double>& times, const std::array<std::vector<double>, 2>& curves);

}  // namespace concord::compare
