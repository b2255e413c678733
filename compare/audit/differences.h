#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "common/types.h"

/// Derivatives of the third opinion's own functions, by difference quotients.
namespace concord::compare {

/// The slope of a function at 0 that comes nearest to an expected one.
struct SlopeMisfit {
  VecX slope;
  /// The largest entry of slope minus the expected one, over its scale.
  double size = std::numeric_limits<double>::infinity();
  /// What the quotients themselves leave open in each entry: by how much the two quotients across 0 of neighbouring
  /// steps that agree best differ, and at least what is good enough.
  VecX doubt;
};

/// Compares the slope of f at 0 with `expected` (entries over `scales`, positive; NaN: anything is right; infinity: not
/// known here, but wanted as exactly as quotients tell it: where two that follow each other differ least). Quotients of
/// sixth order across 0, and of fourth order on either side of it, are taken with `step` and with steps that shrink to
/// a hundred thousandth: a jump of a higher derivative spoils those that reach over it, a short wave those with long
/// steps, and round-off those with short ones. The best of them counts; the search ends at one as good as `enough`.
template <class Function>
SlopeMisfit slope_misfit(const Function& f, const VecX& expected, const VecX& scales, double step, double enough) {
  constexpr int kSteps = 11;
  constexpr double kShrink = 0.31622776601683794;  // the root of a tenth
  SlopeMisfit best;
  const Eigen::Array<bool, Eigen::Dynamic, 1> is_wanted = expected.array().isInf();
  VecX wanted = expected;
  VecX wanted_doubt = is_wanted.select(VecX::Constant(expected.size(), HUGE_VAL), VecX::Zero(expected.size()));
  using Values = typename std::decay_t<decltype(f(0.0))>::PlainObject;
  const auto take = [&](const Values& slope) {
    const auto misfit = (slope - expected).cwiseQuotient(scales).cwiseAbs().eval();
    const double size = expected.array().isFinite().select(misfit.array(), 0.0).maxCoeff();
    if (size < best.size || best.slope.size() == 0) {
      best.slope = slope;
      best.size = size;
    }
  };
  Values before;
  best.doubt = enough * scales;
  double least_doubt = std::numeric_limits<double>::infinity();
  double h = step;
  const auto is_good = [&] { return best.size <= enough && (wanted_doubt.array() <= enough * scales.array()).all(); };
  for (int k = 0; k < kSteps && !is_good(); ++k, h *= kShrink) {
    const Values f1 = f(h), f2 = f(2.0 * h), f3 = f(3.0 * h), b1 = f(-h), b2 = f(-2.0 * h), b3 = f(-3.0 * h);
    const Values across = (45.0 * (f1 - b1) - 9.0 * (f2 - b2) + (f3 - b3)) / (60.0 * h);
    take(across);
    if (is_good()) break;
    if (before.size() > 0) {
      const Values doubt = (across - before).cwiseAbs();
      for (Eigen::Index c = 0; c < doubt.size(); ++c) {
        if (!is_wanted(c) || !(doubt(c) < wanted_doubt(c))) continue;
        wanted(c) = across(c);
        wanted_doubt(c) = doubt(c);
      }
      const double size = doubt.cwiseQuotient(scales).maxCoeff();
      if (size < least_doubt) {
        least_doubt = size;
        best.doubt = doubt.cwiseMax(enough * scales);
      }
    }
    before = across;
    const Values here = f(0.0);
    take((-25.0 * here + 48.0 * f1 - 36.0 * f2 + 16.0 * f3 - 3.0 * f(4.0 * h)) / (12.0 * h));
    take((25.0 * here - 48.0 * b1 + 36.0 * b2 - 16.0 * b3 + 3.0 * f(-4.0 * h)) / (12.0 * h));
  }
  best.slope = is_wanted.select(wanted, best.slope);
  best.doubt = is_wanted.select(wanted_doubt.cwiseMax(enough * scales), best.doubt);
  return best;
}

}  // namespace concord::compare
