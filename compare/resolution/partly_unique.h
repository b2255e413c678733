#pragma once

#include <vector>

#include "compare/resolution/weighed_states.h"

/// Forces and torques of joints of which a part is unique that no axis of the joint's frame shows: two bearings on one
/// axle share the thrust in any way, and each carries a radial load that is determined.
namespace concord::compare {

struct PartlyUnique {
  Quantity of;  // a reaction; component 0: the force, 3: the torque
  /// The directions left out: orthonormal columns in the axes of the body on that side, in the first state of the run.
  Mat3X left_out;
  bool is_fixed = true;              // whether they stay there in the run
  double t = 0.0;                    // of that state [s]
  double peak = 0.0;                 // the largest size of the part in the states of the run, by cartesian [N, N m]
  double t_peak = 0.0;               // the first time within 1e-6 of it [s]
  int samples = 0;                   // states in which it is judged
  double digits = 16.0;              // of the largest difference in the same state, by the scale of the reaction
  double unexplained_digits = 16.0;  // of the largest that round-off does not explain: this is judged
  [[nodiscard]] bool holds(double need) const { return unexplained_digits >= need; }
};

/// All of a machine, held between the solvers as vectors: the difference is projected on the unique part and its size
/// divided by the scale of the components. A state counts where as many directions are open as in most states of the
/// run; where more or fewer are, axes line up. Nothing of one that is known in less than half of these states.
/// `measured` has an entry for each quantity of the layout.
std::vector<PartlyUnique> partly_unique(const QuantityLayout& layout, const WeighedStates& weighed,
                                        const std::vector<Measured>& measured);

/// Those loops that are planar in all states of the run in which open directions are known; `normal` is that of the
/// first. Nothing if they are not, or not the same.
std::optional<PlanarLoops> planar_loops(const Model& model, const WeighedStates& weighed);

}  // namespace concord::compare
