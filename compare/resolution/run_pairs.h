#pragma once

#include <array>
#include <optional>
#include <string>

#include "common/solver.h"
#include "compare/quantities/agreement.h"
#include "compare/quantities/align.h"
#include "compare/quantities/motions.h"

/// Runs of both solvers at one tolerance, and what two tolerances tell of each solver's own runs.
namespace concord::compare {

/// Both solvers' runs at one tolerance, side by side.
struct RunPair {
  RunOptions run;  // of the tighter run, if one solver goes on with a looser one
  std::array<std::optional<Trajectory>, 2> trajectories;
  Series series;
  std::vector<Measured> measured;
  MotionAgreement motion;
  /// Who made the runs, by Who.
  std::array<std::string, 2> integrators = {};
  /// Whether one solver goes on with a run at a looser tolerance.
  bool is_mixed = false;

  [[nodiscard]] bool is_complete() const { return trajectories[0] && trajectories[1]; }
};

/// The same runs up to a sample, `samples` of them; not measured.
RunPair first_samples(const QuantityLayout& layout, const RunPair& pair, int samples);

/// By how many digits the motions of each solver's own run agree at both tolerances.
std::array<double, 2> own_motion_digits(const Model& model, const RunPair& looser, const RunPair& tighter);

/// Whether a solver's run is the same at both tolerances.
bool is_the_same_run(const Model& model, const RunPair& looser, const RunPair& tighter, std::size_t who);

/// The solver whose run is the same at both tolerances though one is tighter: its integrator holds its steps no tighter
/// than a limit of its own, and what tolerance changes is not seen between these two. Of both the first.
std::optional<std::size_t> run_that_stands(const Model& model, const RunPair& looser, const RunPair& tighter);

/// What to do about it: the end of a sentence on runs that do not converge, and of one on what a run loses.
std::string advice_on_integrator(const RunPair& pair, std::size_t who);
std::string advice_on_standing(const RunPair& pair, std::size_t who);

}  // namespace concord::compare
