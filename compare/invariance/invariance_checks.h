#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "compare/quantities/agreement.h"
#include "compare/quantities/align.h"
#include "compare/states/branch.h"
#include "compare/verdict/verdict.h"

/// Each solver held against itself: the same machine, described in equivalent ways.
namespace concord::compare::invariance {

/// Digits that a quantity must keep, or all that double precision resolves.
inline constexpr double kNeed = 10.0;

struct InvarianceOptions {
  std::vector<std::string> moves;  // names; empty: all
  /// End of the run whose states are taken [s]; nothing: what the model says, of a flexible one a tenth of it.
  std::optional<double> until;
  int samples = 10;  // intervals of the run
  int random = 5;    // states near those of the run
  std::uint64_t seed = 19971025;
};

/// What is nearest to the need, or misses it most, of all that one solver finds under one move.
struct Nearest {
  Quantity quantity;
  Measured measured;
  std::string variant;  // of the move, "D is cut"; empty if it has one

  /// Digits that double precision resolves; nothing where that is not known.
  [[nodiscard]] std::optional<double> resolvable() const;
};

/// Whether the first one reaches fewer digits: beyond round-off, then at all.
bool is_nearer(const Measured& one, const Measured& other);

/// One solver under one move.
struct MoveRow {
  std::size_t move = 0;
  Who who = Who::cartesian;
  Outcome outcome = Outcome::agree;
  /// Whether the move means anything to the solver.
  bool applies = true;
  std::optional<Nearest> nearest;
  /// How far the starts agree that the solver finds in both descriptions, the second of which names the first as its
  /// guess; the worst over all variants.
  MotionAgreement start;
  int left_out = 0;  // variants that are no description of the machine to this solver
  int judged = 0;    // quantities, over all variants
  int total = 0;
  /// A state or the description that the solver refuses, or what it calls unique in one description only.
  std::vector<std::string> words;
};

struct MoveSummary {
  std::string name;
  std::string about;
  std::string why_not;  // empty if the move applies
  std::vector<std::string> left;
  int variants = 0;
};

struct InvarianceChecks {
  std::string name;  // of the model
  int run_states = 0;
  int random_states = 0;
  std::vector<std::string> notes;
  std::vector<std::string> failures;  // why there is no verdict, before any move
  std::vector<MoveSummary> moves;
  std::vector<MoveRow> rows;  // by move, cartesian first
  Outcome outcome = Outcome::agree;
};

/// Judges a model as it starts (as_it_starts). Throws InputError for a model that the solvers refuse; errors
/// of solvers are failures.
InvarianceChecks check_invariance(Model model, const SolverMakers& makers, const InvarianceOptions& options);

}  // namespace concord::compare::invariance
