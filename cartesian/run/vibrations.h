#pragma once

#include <vector>

#include "cartesian/dynamics/dynamics.h"

namespace concord::cartesian {

/// The modal coordinates a of all bodies, taken apart into vibrations of the machine as its joints hold it at one pose:
///   a = E xi,   xi'' + 2 delta xi' + lambda xi = g                                                             (C56)
/// with lambda and delta of the bodies' stiffness and damping. g is all the rest. lambda may be zero or negative, delta
/// of any size.
class Vibrations {
 public:
  explicit Vibrations(const Equations& equations);

  [[nodiscard]] Eigen::Index size() const { return lambda_.size(); }
  /// Where the modal coordinates stand in q, and their rates in Y.
  [[nodiscard]] const std::vector<int>& places_in_q() const { return in_q_; }
  [[nodiscard]] const std::vector<int>& places_in_Y() const { return in_Y_; }

  /// Takes E, lambda and delta at the last solution.
  void renew(Dynamics& dynamics);
  /// How often that was done.
  [[nodiscard]] int version() const { return version_; }

  [[nodiscard]] const MatX& E() const { return E_; }
  [[nodiscard]] const MatX& inverse_E() const { return inverse_E_; }
  [[nodiscard]] const VecX& lambda() const { return lambda_; }            // 1/s^2
  [[nodiscard]] const VecX& twice_delta() const { return twice_delta_; }  // 1/s
  /// The largest rate of change of a vibration without g [1/s].
  [[nodiscard]] double fastest() const { return fastest_; }

 private:
  void measure_compliance(Dynamics& dynamics);

  std::vector<int> in_q_;
  std::vector<int> in_Y_;
  MatX stiffness_;   // of all bodies, block by block
  MatX damping_;     // likewise
  VecX unit_;        // of free modes of mass m: 1 / sqrt(m)
  MatX compliance_;  // P: accelerations of modal coordinates by modal forces
  MatX E_;
  MatX inverse_E_;
  VecX lambda_;
  VecX twice_delta_;
  VecX force_;         // n_Y rows
  VecX acceleration_;  // n_Y rows
  double fastest_ = 0.0;
  int version_ = 0;
};

/// s(t) [s] and s'(t) of s'' + 2 delta s' + lambda s = 0, s(0) = 0, s'(0) = 1: what a blow leaves of a vibration.
struct Response {
  double place;
  double rate;
};
Response response(double lambda, double twice_delta, double t);  // (C57)

}  // namespace concord::cartesian
