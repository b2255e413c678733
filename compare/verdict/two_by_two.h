#pragma once

#include <array>
#include <optional>
#include <string>

#include "compare/quantities/curve_metrics.h"

namespace concord {
class Solver;
struct Model;
}  // namespace concord

/// Does a difference of two runs come from the formulation or from the integration?
namespace concord::compare {

struct Verdict;

/// A difference told apart: each solver's equations evaluated on each solver's motion, for the component that differs
/// most [the component's unit]. Index: whose motion, or whose equations.
struct TwoByTwo {
  std::string of;
  std::string unit;
  int samples = 0;
  std::array<double, 2> formulation{};  // between both equations on one motion
  std::array<double, 2> integration{};  // by one solver's equations between both motions
  /// Each solver's equations on its own motion, cartesian's as the measure.
  CurveMetrics curves;
};

/// Evaluates each solver's algebra on each solver's run at up to kTableSamples common samples, for the row of the
/// verdict that differs most. Nothing if a run is missing, no row differs, or no solver accepts the other one's states.
std::optional<TwoByTwo> two_by_two(const Model& model, const std::array<Solver*, 2>& solvers, const Verdict& verdict);

/// "joint C on coupler, F_y, largest over 41 samples: formulation 3.10e-13 N on cartesian's motion, ...".
std::string describe(const TwoByTwo& table);

}  // namespace concord::compare
