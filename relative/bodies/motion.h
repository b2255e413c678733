#pragma once

#include "common/types.h"
#include "relative/bodies/topology.h"

namespace concord::relative {

/// Internal coordinates and speeds, in the order of Topology.
struct Coordinates {
  double t = 0.0;
  VecX q;
  VecX u;
};

/// A machine in a pose: its coordinates and speeds, completed by the laws of drivers and by what is measured at cut
/// joints.
class Motion {
 public:
  [[nodiscard]] double t() const { return at_.t; }
  [[nodiscard]] const VecX& q() const { return at_.q; }
  [[nodiscard]] const VecX& u() const { return at_.u; }

 private:
  friend class Equations;
  explicit Motion(const Topology& topology) : at_{0.0, VecX::Zero(topology.n_q), VecX::Zero(topology.n_u)} {}

  Coordinates at_;
  long number_ = 0;  // of motions so far
};

}  // namespace concord::relative
