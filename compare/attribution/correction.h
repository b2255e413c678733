#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>

#include "common/solver.h"
#include "compare/attribution/attribution.h"

/// Is a guess right? The solver that is blamed is asked again, with what the blamed place is wrong by put back as loads
/// in its model, at the same states: if the guess is right, the difference between the solvers closes.
namespace concord::compare {

/// Makes a solver of one kind for a model, which must outlive it.
using SolverMaker = std::function<std::unique_ptr<Solver>(const Model&)>;

/// What came of it.
struct Trial {
  /// By how many digits the difference closed, in the state where it did so least.
  double digits = 0.0;
  /// "body hub", "body hub and 2 others", "force element strut": where loads were added.
  std::string where;

  [[nodiscard]] bool confirms() const { return digits >= 2.0; }
};

/// Tries a guess that forces can put right: a body that is out of balance, whatever term is to blame, or a force
/// element that does not follow its law. First the place that is named, then all of its kind. Nothing for all others:
/// what is wrong with joints' motions and with reports no load changes; and where a solver does not answer any more.
/// `maker`: of the solver that is blamed.
std::optional<Trial> try_correction(const Evidence& evidence, const Attribution& blame, const SolverMaker& maker);

/// The first guess that a trial confirms; else the first that none can try; else the first. Where bodies move alike it
/// is the report that differs, which no load changes: then the first. `makers`: of both solvers.
std::optional<Attribution> find_confirmed_cause(const Evidence& evidence, const std::array<SolverMaker, 2>& makers);

/// "; put right by loads on body hub the difference closes by 9.3 digits", or that it does not.
std::string describe(const Trial& trial);

}  // namespace concord::compare
