#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/solver.h"
#include "compare/audit/machine_size.h"
#include "compare/audit/round_off.h"
#include "compare/quantities/agreement.h"
#include "compare/quantities/align.h"

/// What double precision resolves of each quantity in each state, measured: how far a solver's answer moves when the
/// state moves by round-off, and when the solver closes it again. A difference between the solvers that is no larger
/// than a few resolutions is round-off; one that is larger is not.
namespace concord::compare {

inline constexpr int kDraws = 5;
/// With fewer valid draws the resolution of a state is unknown there.
inline constexpr int kFewestDraws = 3;
/// A closing that moves the state by more than this (relative to the sizes that draws have), and by more than what the
/// round-off of the constraints explains there, found another state.
inline constexpr double kSameClosing = 1e-11;
/// Where accelerations hold round-off of the state more often than this, the places that close are less well known than
/// the numbers of a state, and one closing does not tell how much less.
inline constexpr double kIllConditioned = 30.0;

/// Resolutions of all quantities (rows of the layout) in all states (columns), in each quantity's unit.
struct Resolution {
  /// Of the less resolving solver, with the floor: round-off of the terms that are added up. NaN where it is unknown.
  MatX both;
  /// Of each solver alone, without the floor.
  std::array<MatX, 2> own;
  /// Closings that were left out because they found another state, and states with too few valid draws.
  int closings_left_out = 0;
  int unknown_states = 0;
  /// Of each state why it is singular within round-off, in the words of a solver that refuses a draw as a singular
  /// pose; empty for all others.
  std::vector<std::string> singular;
};

/// The part of three components that is unique though they themselves are not: rows of the layout from `first` on, and
/// the projector on that part.
struct Projection {
  int first = 0;
  Mat3 on_unique = Mat3::Identity();
};
using Projections = std::vector<std::vector<Projection>>;  // by state

/// How far two states are from each other, relative to the sizes of their numbers; modes by how far they move a body,
/// as they may be nothing but round-off; velocities of a machine at rest by one that it hardly would be seen to have.
double distance(const State& one, const State& other, const MachineSize& sizes);

/// `state` with every number moved by at most so many units of round-off of its kind's size, the same for the same
/// seed; by the opposite numbers of units, if they are negative.
State draw_within_roundoff(const State& state, const MachineSize& sizes, std::uint64_t seed, double units = 1.0);

/// Measures the resolution in every state: the largest change over kDraws draws, handed to both solvers, and over a
/// closing by each; near singular poses, over closings from nearby. Over the three components of a force, torque or
/// acceleration the largest of those that are `unique` in the state (rows of the layout, columns: states); plus the
/// floor, a unit of round-off of the larger of the scale (`measured`, one for each quantity) and of the terms. Of
/// components that are not unique, but a part of them is (`parts`), that of the part; empty: there are none.
Resolution measure_resolution(const QuantityLayout& layout, const std::array<Solver*, 2>& solvers,
                              const std::vector<SharedState>& states, const Mask& unique,
                              const std::vector<Measured>& measured, std::uint64_t seed, const Projections& parts = {});

/// The same of one solver alone, without the floor: the largest change of its answers, which stand in the states' place
/// `who`.
MatX measure_own_resolution(const QuantityLayout& layout, Solver& solver, Who who,
                            const std::vector<SharedState>& states, const Mask& unique, std::uint64_t seed);

/// The solver's answers in states that differ from the one asked about by round-off, for its audit. Model and solver
/// must outlive it.
Redraw answers_within_roundoff(const Model& model, Solver& solver, std::uint64_t seed);

/// The resolutions in the samples of a run: of each sample the largest over the states taken from it
/// (SharedState::row), as its state is known after an integration (kUnitsOfARun); NaN where there is none.
MatX resolution_of_run(const Resolution& resolution, const std::vector<SharedState>& states, int samples);

}  // namespace concord::compare
