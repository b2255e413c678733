#pragma once

#include <array>
#include <vector>

#include "compare/analyses/linearize.h"
#include "compare/equilibrium/stiffness.h"
#include "compare/verdict/chart.h"

/// Eigenvalues and shapes of a linearized machine, from its matrices.
namespace concord::compare::analyses {

/// deltaddot = A delta + B deltadot.
struct MotionMatrices {
  MatX A;
  MatX B;
};

/// What the search for modes of a machine takes as given, whatever the errors of its matrices are.
struct ModeSearch {
  const Chart& chart;
  AccelerationScale scale;
  /// Nothing is damped: eigenvalues are the roots of those of A alone.
  bool is_undamped = false;
  double frequency = 1.0;   // the unit of rates [1/s]
  double strictness = 1.0;  // of what counts as stiffness, see StiffnessSplit
};

/// What modes a machine has.
struct FoundModes {
  /// Those that meet a stiffness or a damping, in no order and without words for their motion.
  std::vector<Mode> moving;
  /// Orthonormal columns: motions without stiffness, and rates of these that no damping holds either.
  MatX free_places;
  MatX free_rates;
  double resolution = 0.0;  // Linearization::resolution
  double slowest = 0.0;     // Linearization::slowest

  [[nodiscard]] int count_free() const;
};

/// `errors`: what the numbers of the matrices may be wrong by.
FoundModes find_modes(const ModeSearch& search, const MotionMatrices& matrices, const MotionMatrices& errors);

/// By how much eigenvalues and shapes move when every number of the matrices is changed by up to what it may be wrong
/// by, over a few draws: written into the modes. A mode that a draw loses is not resolved.
void measure_mode_resolution(const ModeSearch& search, const MotionMatrices& matrices, const MotionMatrices& errors,
                             std::vector<Mode>& modes);

/// Asks for a thirtieth of what otherwise counts as stiffness, and for thirty times as much: the fewest and the most
/// modes that are free then. Where that decides otherwise on one motion, the others follow: by how much they move is
/// written into them too.
std::array<int, 2> weigh_decisions_on_free(ModeSearch search, const MotionMatrices& matrices,
                                           const MotionMatrices& errors, FoundModes& found);

/// Near critical damping round-off decides whether two eigenvalues are real or a conjugate pair: a pair whose imaginary
/// part is not resolved becomes two real ones. After measure_mode_resolution().
void split_unresolved_pairs(std::vector<Mode>& modes);

/// The velocities of a mode with these coordinates, in SI units and in those of the machine, written into it.
void set_shape(const Chart& chart, const Eigen::VectorXcd& coordinates, Mode& mode);

}  // namespace concord::compare::analyses
