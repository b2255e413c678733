#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "common/solver.h"
#include "compare/states/branch.h"
#include "compare/states/states.h"
#include "compare/verdict/progress.h"
#include "compare/verdict/verdict.h"

/// Two solvers, one model, one verdict.
namespace concord::compare {

inline constexpr double kRigidRtol = 1e-11;
inline constexpr double kFlexibleRtol = 1e-9;
inline constexpr int kSamples = 300;

struct VerifyOptions {
  /// What is missing comes from the model, then from the defaults above.
  std::optional<double> until;  // s
  std::optional<double> rtol;
  std::optional<int> samples;
  /// States of the run that are handed to both solvers, at least, and a quarter as many near them; fewer than the
  /// default kTrajectoryStates blunt the verdict: for many machines in little time.
  std::optional<int> states;
  /// Seed of the random states, and of the draws within round-off.
  std::uint64_t seed = kSeed;
  /// Whether runs are made. Without them the checks are rank, same state and audit: of the starts, of what both solvers
  /// come to a short step later, and of perturbed states.
  bool integrates = true;
  /// Whether the refined check is taken: both runs again at a tighter tolerance, half of a verdict's cost or more.
  bool refines = true;
  /// Whether a difference is told apart: who is to blame, and whether motions or equations differ.
  bool explains = true;
  /// Makes solvers for the model: with corrections, by which a guess at who is to blame is tried, and such by which the
  /// refined runs are made beside the others; null: none is tried, and the solvers make one run after the other. Must
  /// outlive the verification.
  const SolverMakers* makers = nullptr;
  /// Whether runs at looser tolerances are made to tell how each solver converges.
  bool orders = false;
  /// Empty: each solver's own default.
  std::array<std::string, 2> integrators;
  /// Another program that is asked in the states of the same state check; null: none. Must outlive the verification.
  ThirdOpinion* third = nullptr;
  /// Called from several threads, never at the same time. Empty: nobody listens.
  TellProgress progress;
};

/// Settings of a run: the options, else the model's, else the defaults.
RunOptions run_options(const Model& model, const VerifyOptions& options);

/// The name of the integrator that runs: `asked`, or the solver's default if empty. Throws InputError if the solver
/// does not know it.
std::string chosen_integrator(const Model& model, const Solver& solver, const std::string& asked);

/// Takes every check (compare/README) and returns all findings. An error of a solver is a failure in the verdict;
/// InputError passes through.
Verdict verify(const Model& model, Solver& cartesian, Solver& relative, const VerifyOptions& options);

}  // namespace concord::compare
