#pragma once

#include <array>
#include <vector>

#include "compare/align.h"
#include "compare/observe.h"

/// How far two solvers agree on each quantity over one rung.
namespace concord::compare {

/// A scale is never smaller than this part of the machine's largest of its kind.
inline constexpr double kScaleFloor = 1e-6;

struct Measured {
  double scale = 0.0;    // in the quantity's unit
  bool floored = false;  // the floor acts on the scale
  double difference = 0.0;
  std::size_t worst = 0;  // sample of the largest difference
  double t = 0.0;         // its time [s]
  std::array<double, 2> values{};
  double digits = 16.0;
};

/// One entry for each row of the series. Scale of a force: the joint's peak |F| over the series, the larger of both
/// solvers'; of a torque: max(peak |T|, peak |F| l), l the machine's length; both floored. A force on a
/// joint speed takes the scale of its joint's total wrench, that of a coupling the largest of its joints' divided by
/// their factors; a force element's wrench its own; a body's sum that of the
/// largest wrench in it; an acceleration the body's max(|vdot|, |omegadot| l, |omega|^2 l, g), g because the forces on
/// a body at rest are those that keep it from falling; angular the same over l; modal accelerations the body's largest.
std::vector<Measured> measure(const Layout& layout, const Series& series);

}  // namespace concord::compare
