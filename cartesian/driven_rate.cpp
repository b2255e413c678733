#include "cartesian/driven_rate.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "common/joints/facts.h"

namespace concord::cartesian {

namespace {

/// The steepest mean slope of a law in its coordinate's unit, per `unit` of it [1/s].
struct SlopeOfLaw {
  double unit;

  double operator()(const ConstantSpeed& law) const { return std::abs(law.speed) / unit; }

  double operator()(const Harmonic& law) const { return std::abs(law.amplitude * law.frequency) / unit; }

  double operator()(const SmoothStep& law) const { return std::abs(law.to - law.from) / (law.t1 - law.t0) / unit; }

  /// A power of time has no steepest slope: of c_k t^k the rate at which its k-th derivative alone would take it by the
  /// unit.
  double operator()(const Polynomial& law) const {
    double largest = 0.0;
    double derivative = 1.0;  // k-th of t^k
    for (std::size_t k = 1; k < law.coefficients.size(); ++k) {
      derivative *= static_cast<double>(k);
      const double in_units = derivative * std::abs(law.coefficients[k]) / unit;
      largest = std::max(largest, std::pow(in_units, 1.0 / static_cast<double>(k)));
    }
    return largest;
  }

  double operator()(const SplineTable& law) const {
    double steepest = 0.0;
    for (std::size_t k = 0; k + 1 < law.times().size(); ++k) {
      const double chord = (law.values()[k + 1] - law.values()[k]) / (law.times()[k + 1] - law.times()[k]);
      steepest = std::max(steepest, std::abs(chord));
    }
    return steepest / unit;
  }
};

}  // namespace

double rate_of_drivers(const Model& model) {
  const double length = model.length_scale();
  double largest = 0.0;
  for (const Joint& joint : model.joints) {
    for (const Driver& driver : joint.drivers) {
      const bool slides = joints::is_length(joint.type->permits[driver.word], driver.component);
      largest = std::max(largest, std::visit(SlopeOfLaw{slides ? length : 1.0}, driver.law));
    }
  }
  return largest;
}

}  // namespace concord::cartesian
