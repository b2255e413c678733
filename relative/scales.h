#pragma once

#include "relative/closure.h"

/// Units of a machine, so that metres, radians and modal coordinates can be weighed against each other.
namespace concord::relative {

/// The rate of a machine [1/s], by which its speeds are small or not: that of gravity, of
/// the speeds it starts with and of its drivers, which may bring it to rest; else that of its loads and springs; zero
/// if nothing moves it (R64).
double machine_rate(const Model& model);

/// Length of the machine, machine_length [m], and the size of one unit of each speed and closure row.
class Scales {
 public:
  Scales(const Model& model, const Topology& topology);

  [[nodiscard]] double length() const { return length_; }
  /// One for each entry of u: the length for a slide, 1 rad for a turn, for a mode the amplitude at which its largest
  /// displacement is the length.
  [[nodiscard]] const VecX& speeds() const { return speeds_; }
  /// One for each entry of q: the length for a slide, 1 for an angle or an Euler parameter, for a mode as in speeds().
  [[nodiscard]] VecX coordinates(const Model& model, const Topology& topology) const;
  /// Phi_u with rows and columns measured in these units (R63).
  [[nodiscard]] MatX scaled(const MatX& Phi_u, const Closure& closure) const;

 private:
  double length_;
  VecX speeds_;
};

}  // namespace concord::relative
