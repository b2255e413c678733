#pragma once

#include <array>

#include "cartesian/run/collocation.h"

namespace concord::cartesian {

/// Foretells the rates at the points of a step from those before them, by the polynomial through the last few that are
/// known (C59). How many that are is learned: a motion that is smooth beside the step takes all, one whose fastest
/// part has died out takes few, because a polynomial of high degree magnifies what is left of it.
class RatePredictor {
 public:
  RatePredictor(Eigen::Index size, Eigen::Index n_modes) : error_(size), of_ydot_(size), of_g_(n_modes) {}

  /// Nothing is known of the past, but that rates at all points are about those of now.
  void forget() { has_past_ = false; }
  /// A step from t0 is tried, where the last one began at `last_start` and was `last_length` long [s].
  void begin(double t0, double length, double last_start, double last_length);
  void know_past() { has_past_ = true; }

  /// Writes rates at point m and those after it, from the points before them (C59).
  void predict(int m, const PointRates& last, PointRates& now) const;
  /// What was found at point m is in `now`: which number of points would have foretold it best (C59)?
  void learn(int m, const PointRates& last, const PointRates& now, const Collocation& collocation, const VecX& weights);
  /// The points of a step have all been learned from.
  void choose();

 private:
  [[nodiscard]] int most_before(int m) const { return has_past_ ? kPoints : m; }
  void write_factors(int m, int count, double x, double* factors) const;

  bool has_past_ = false;
  int used_ = kPoints;
  std::array<double, 2 * kPoints> times_{};   // of points of the last step and of this, in parts of this
  std::array<double, kPoints + 1> errors_{};  // by number of points
  VecX error_;
  VecX of_ydot_;
  VecX of_g_;
};

}  // namespace concord::cartesian
