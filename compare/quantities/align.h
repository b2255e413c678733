#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/results.h"
#include "compare/quantities/observe.h"

/// Two solvers' results brought side by side.
namespace concord::compare {

/// The two solvers, in the order of every pair of values.
enum class Who { cartesian = 0, relative = 1 };

constexpr int index(Who who) { return static_cast<int>(who); }

inline constexpr std::array kBothSolvers{Who::cartesian, Who::relative};
inline constexpr std::array kSolverNames{"cartesian", "relative"};

/// What both solvers say at the same times: `values[who]` has a row for each quantity of the layout and a column for
/// each time. `spin` is each body's largest angular speed over all of them [rad/s].
struct Series {
  std::vector<double> times;
  std::array<MatX, 2> values;
  std::vector<double> spin;
};

/// Puts two trajectories on their common grid. Throws IncompleteResult if either has other than `samples` samples, if
/// the times differ, or if a number is missing or not finite.
Series align(const QuantityLayout& layout, const std::array<const Trajectory*, 2>& trajectories, int samples);

/// One state, evaluated by both solvers. `row`: the sample of the run that it is taken from, or -1.
struct SharedState {
  State state;
  std::array<Evaluation, 2> evaluations;
  int row = -1;
};

/// Evaluations of the same states side by side. Throws IncompleteResult like the other one.
Series align(const QuantityLayout& layout, const std::vector<SharedState>& states);

}  // namespace concord::compare
