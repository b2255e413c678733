#pragma once

#include <string>

#include "cartesian/dynamics/equations.h"

/// How large motions, forces and residuals of constraints are in a state, over the machine's scales (MachineScales).
namespace concord::cartesian {

/// By what factor the round-off in the residuals of constraint rows exceeds that of a row of unit terms, at some
/// positions: far from the origin, or after many turns.
struct RoundOffShares {
  explicit RoundOffShares(const Constraints& constraints)
      : terms(VecX::Ones(constraints.n_rows())), reaches(VecX::Ones(constraints.n_rows())) {}

  /// By row: 1, or of rows that read places the distance from the origin in lengths of the machine, or the row's own
  /// terms (many turns) by its size.
  VecX terms;
  /// By row: the distance alone, 1 of rows that read orientations.
  VecX reaches;
  /// The farthest that anything stands from the origin or its body's origin, in lengths of the machine; at least 1.
  double reach = 1.0;
};
/// RoundOffShares::reach at the last update, which was at positions q.
double reach_of(const Equations& equations, const Eigen::Ref<const VecX>& q);
/// At the last update, which was at time t and positions q, or for positions q that are as near as round-off.
void measure_round_off(const Equations& equations, double t, const Eigen::Ref<const VecX>& q, RoundOffShares& shares);

/// The largest residual of positions, or of velocities [1/s], by row sizes and, with `shares` given, by these: terms
/// for positions (C45); reaches for velocities of a state that is handed over, where round-off of places stands between
/// the points of a joint and turns with them.
double largest_residual(const Equations& equations, const VecX& residual, const VecX* shares = nullptr);
/// The joint or coupling of the largest of these residuals by row sizes.
std::string name_of_largest(const Equations& equations, const VecX& residual);

/// The rate that the forces, and torques as forces at the machine's length, would bring about over that length [1/s]:
/// sqrt(acceleration / L), the largest of all bodies (C46).
double natural_rate(const Equations& equations);
/// The largest speed Y in the machine's units [1/s], that of laws of drivers at time t included; at least a millionth
/// of the natural rate, and of that of the drivers, which may bring the machine to rest.
double largest_rate(const Equations& equations, double t, const Eigen::Ref<const VecX>& Y);
/// The largest of what gravity, speeds and forces cause, and of these accelerations, in the machine's units [1/s^2].
double largest_acceleration(const Equations& equations, const Eigen::Ref<const VecX>& Ydot);

/// Sizes of [q; Y; work] of a motion that starts so and goes on for `until` [s], what tolerances are parts of: lengths
/// by the machine's, speeds by that which it starts with or would fall with, modal coordinates by the vibration at that
/// speed (C63). A machine that starts at rest without gravity has the speed that its forces bring about over its
/// length, or at least its length in the time of the run. At the last update.
VecX motion_sizes(const Equations& equations, const VecX& q, const VecX& Y, double until);

}  // namespace concord::cartesian
