#pragma once

#include <optional>
#include <string>

#include "common/results.h"

namespace concord {

/// What a run is asked for.
struct RunOptions {
  double until = 1.0;   // s
  double rtol = 1e-11;  // relative tolerance of the integrator; absolute ones follow from it and the machine's scales
  int samples = 300;    // equal intervals of the output grid; samples + 1 rows, t = 0 and t = until among them
  std::string integrator;  // empty: the solver's default for this model
  /// A closed state at t = 0 to start from instead of the model's start.
  std::optional<State> start = std::nullopt;
  /// How many evaluations the whole run may take, whatever the integrator makes of them: a run that takes more ends as
  /// EvaluationsSpent.
  std::optional<long> most_evaluations = std::nullopt;
  /// Whether it ends so already where, after a tenth of these, it would take more than twice as many at its pace. A run
  /// whose start is harder than the rest may then end that would have been given enough.
  bool foresees_end = false;
};

}  // namespace concord
