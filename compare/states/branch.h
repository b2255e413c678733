#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "common/solver.h"

/// Loops close in more than one way. Both solvers start in the same one, or the model is refused.
namespace concord::compare {

/// Makes a solver of each kind for a model.
struct SolverMakers {
  std::function<std::unique_ptr<Solver>(const Model&)> cartesian;
  std::function<std::unique_ptr<Solver>(const Model&)> relative;
};

using Solvers = std::array<std::unique_ptr<Solver>, 2>;  // by Who

/// The model with the places and modal coordinates of a state as its start: kept coordinates keep those of the state,
/// the others are guesses near it. Speeds stay what the model says.
Model started_at(const Model& model, const State& state);

/// Whether a start has the coordinates that the model keeps or drives. One that has not is a solver's mistake: branches
/// differ in what is guessed.
bool obeys_the_model(const Model& model, const State& state);

/// Both solvers for a model. Where they assemble different branches from its guesses, or where one of them finds none,
/// `model` gets the better start as its guess, and both are made anew: the branch that is nearer to the guesses, and if
/// those do not tell, nearer to zero in the coordinates of which nothing is said. `note` then says so. Starts whose
/// coordinates differ by whole turns alone that change nothing are one branch: both solvers then count the turns of one
/// of them, and nothing is said. Throws InputError if the model is wrong for both, or if they still part. All stays as
/// it was given where a start has not the coordinates that are kept or driven, and where one refuses the other's start,
/// too, whose assemble() then throws. `model` must outlive the solvers.
Solvers make_solvers_on_one_branch(Model& model, const SolverMakers& makers, std::string& note);

/// Whether whole turns of a coordinate of joint `joint` change neither a pose nor a force: it is an angle about an
/// axis, and nothing reads the angle itself: no driver, no coupling, and no spring or stop of the joint.
bool whole_turns_change_nothing(const Model& model, std::size_t joint, int word, int component);

/// The angle that differs from `angle` by whole turns and is nearest to `near` [rad].
double with_turns_of(double near, double angle);

}  // namespace concord::compare
