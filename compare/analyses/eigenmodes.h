#pragma once

#include <array>
#include <vector>

#include "compare/analyses/linearize.h"
#include "compare/equilibrium/stiffness.h"
#include "compare/states/chart.h"

/// Eigenvalues and shapes of a linearized machine, from its matrices.
namespace concord::compare::analyses {

/// deltaddot = A delta + B deltadot.
struct MotionMatrices {
  MatX A;
  MatX B;
};

/// What the search for modes is given beside the matrices and their errors.
struct ModeSearch {
  const Chart& chart;
  AccelerationScale scale;
  /// Without damping the eigenvalues are square roots of those of A.
  bool is_undamped = false;
  double frequency = 1.0;   // the unit of rates [1/s]
  double strictness = 1.0;  // factor on the limit below which a stiffness counts as none, see StiffnessSplit
};

/// What modes a machine has.
struct FoundModes {
  /// Modes with stiffness or damping, unsorted; their motions are not yet named.
  std::vector<Mode> moving;
  /// Orthonormal columns: motions without stiffness; and those of them without damping.
  MatX free_places;
  MatX free_rates;
  double resolution = 0.0;  // Linearization::resolution
  double slowest = 0.0;     // Linearization::slowest

  [[nodiscard]] int count_free() const;
};

/// Finds the modes of the matrices. `errors` bounds the error of each number in them.
FoundModes find_modes(const ModeSearch& search, const MotionMatrices& matrices, const MotionMatrices& errors);

/// Measures how well modes are known, and writes it into them: the largest change of eigenvalue and shape over a few
/// draws, each of which changes every number of the matrices within its error. A mode that is not found again in a draw
/// is not resolved.
void measure_mode_resolution(const ModeSearch& search, const MotionMatrices& matrices, const MotionMatrices& errors,
                             std::vector<Mode>& modes);

/// Repeats the search with a limit of stiffness thirty times lower and thirty times higher. Returns the fewest and the
/// most free modes that result. If these differ, the changes of the other modes are written into them too.
std::array<int, 2> weigh_decisions_on_free(ModeSearch search, const MotionMatrices& matrices,
                                           const MotionMatrices& errors, FoundModes& found);

/// Turns each conjugate pair whose imaginary part is not resolved into two real eigenvalues: near critical damping
/// round-off decides which of the two is found. Call it after measure_mode_resolution().
void split_unresolved_pairs(std::vector<Mode>& modes);

/// Writes the velocities of a mode with these coordinates into it, in SI units and in units of the machine.
void set_shape(const Chart& chart, const Eigen::VectorXcd& coordinates, Mode& mode);

/// Brings modes that are hardly faster than what differences tell from zero, and that the search for eigenvalues has
/// left open, to where they solve their equations. One that clearly does not solve them, or does so where another one
/// does, is not resolved: that is written into it.
void refine_slow_modes(const Chart& chart, const MotionMatrices& matrices, FoundModes& found);

}  // namespace concord::compare::analyses
