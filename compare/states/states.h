#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/solver.h"
#include "compare/audit/machine_size.h"
#include "compare/quantities/align.h"
#include "compare/states/draws.h"

/// The states at which both solvers are asked the same question.
namespace concord::compare {

inline constexpr int kTrajectoryStates = 200;  // at least
inline constexpr int kRandomStates = 50;
inline constexpr int kRedraws = 5;

/// A state, and the solver that closed it; `row`: the sample of a run that it is taken from, or -1.
struct OwnedState {
  State state;
  Who owner = Who::cartesian;
  int row = -1;
};

/// States of a run from both trajectories in turn (the first from cartesian), t = 0 among them; both of each row if
/// there are fewer rows than `least`. A missing trajectory (nullptr) leaves its turns to the other one.
std::vector<OwnedState> run_states(const std::array<const Trajectory*, 2>& trajectories, int least = kTrajectoryStates);

/// Makes generic neighbours of the states of a run, the same ones for the same seed.
class StatePerturbation {
 public:
  StatePerturbation(const Model& model, const std::vector<OwnedState>& run, std::uint64_t seed);

  /// `state` with every body moved, turned and set in motion, and with modal coordinates and rates drawn anew within
  /// the largest of the run; not closed. Amplitude 1: a twentieth of the machine's length, 0.1 rad, and a tenth of the
  /// run's largest speeds.
  State perturb(const State& state, double amplitude);

  /// The same along what a machine permits: for machines whose loops tie modes to each other, so that modes drawn anew
  /// cannot be closed. Nothing if the solver closes none.
  std::optional<State> perturb_along(const Model& model, Solver& solver, const State& state, double amplitude);

 private:
  Vec3 uniform3();
  VecX within(const VecX& largest);

  Draws draws_;
  MachineSize sizes_;
};

/// A guess of the state h seconds on, to the second order; hints of coordinates move on with their speeds.
State predict(const Model& model, const Sample& now, double h);

/// What a solver finds in a state; nothing if it refuses the state, as where a spring's ends meet or a frame has turned
/// by half a turn: who can go elsewhere, does.
std::optional<Evaluation> evaluation_unless_refused(Solver& solver, const State& state);

/// Whether the solver's own evaluation accepts a state: it may be open to its equations, or lie on another branch.
bool accepts(Solver& solver, const State& state);

/// A state that one solver closed and the other one does not accept, in the latter's words.
struct RefusedState {
  OwnedState state;
  std::string why;
};

/// States evaluated by both solvers, and what stood in the way.
struct SharedStates {
  std::vector<SharedState> states;
  /// A solver does not accept a state that the other one closed: a difference.
  std::vector<RefusedState> refusals;
  /// A solver does not accept its own state, or finds none: no verdict.
  std::vector<std::string> failures;
  /// A solver calls the pose singular, in its words.
  std::vector<std::string> singular;
  /// Perturbed states that were drawn anew: singular poses, and states that mean another turn or branch to the other
  /// solver.
  int drawn_anew = 0;
  /// Perturbed states that were given up because neither solver closes there.
  int left_open = 0;
};

/// The states of a run, each handed once to both solvers.
SharedStates share(const std::array<Solver*, 2>& solvers, const std::vector<OwnedState>& run);

/// `count` consistent states near those of a run, closed by the solvers in turn and handed once to both. A state
/// that the other solver does not accept may be another turn or branch of the same joints: it is drawn anew, up to
/// kRedraws times; if none of them is accepted, the closures differ.
SharedStates share_random(const Model& model, const std::array<Solver*, 2>& solvers, const std::vector<OwnedState>& run,
                          std::uint64_t seed, int count = kRandomStates);

}  // namespace concord::compare
