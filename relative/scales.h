#pragma once

#include "relative/closure.h"

/// Units of a machine, so that metres, radians and modal coordinates can be weighed against each other.
namespace concord::relative {

/// Length of the machine, Model::length_scale [m], and the size of one unit of each speed and closure row.
class Scales {
 public:
  Scales(const Model& model, const Topology& topology);

  [[nodiscard]] double length() const { return length_; }
  /// One for each entry of u: the length for a slide, 1 rad for a turn, for a mode the amplitude at which its largest
  /// displacement is the length.
  [[nodiscard]] const VecX& speeds() const { return speeds_; }
  /// One for each row of a closure: the length for a displacement, 1 for a rotation.
  [[nodiscard]] VecX rows(const Closure& closure) const;
  /// Phi_u with rows and columns measured in these units.
  [[nodiscard]] MatX scaled(const MatX& Phi_u, const Closure& closure) const;

 private:
  double length_;
  VecX speeds_;
};

}  // namespace concord::relative
