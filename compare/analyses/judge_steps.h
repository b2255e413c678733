#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "compare/analyses/judge.h"
#include "compare/equilibrium/rests.h"
#include "compare/states/branch.h"

/// What the judgement of every analysis takes: both solvers on one branch, their wrenches, numbers and an outcome.
namespace concord::compare::analyses {

/// Lines of a table, its header first.
using Lines = std::vector<std::vector<std::string>>;

/// Both solvers on one branch; `result` tells what the guesses left open.
Solvers make_solvers(Model& model, const SolverMakers& makers, AnalysisVerdict& result);

/// What both solvers found: states of a motion; a rest, where accelerations vanish and have no scale; or a rest that
/// leaves a motion without stiffness, as the heading of a vehicle, so that components in global axes are not
/// determined.
enum class Found { motion, rest, neutral_rest };

/// Which of the two kinds of rest.
Found kind_of(const Rests& rests);

/// Judges the wrenches of what both solvers found: in the same states, and of each as it found them; audits both, and
/// notes what the models of flexible bodies leave out there.
/// What they found stands in the verdict's trajectories.
void judge_wrenches(const Model& model, const Solvers& solvers, const std::array<Trajectory, 2>& found, Found kind,
                    AnalysisVerdict& result);

/// A number that both solvers give, with its digits on a scale of its own.
NumberRow number(std::string name, std::string unit, double one, double other, double scale, double need);

/// No verdict where joints carry reactions, of which none is unique and resolved.
void require_judged(AnalysisVerdict& result);

/// No verdict where joints carry reactions, of which none is unique. Those that are, but carry too little to be
/// resolved, are no hindrance where others than wrenches are asked for.
void require_unique(AnalysisVerdict& result);

/// The outcome, from the wrenches and the numbers.
void conclude(AnalysisVerdict& result);

/// A search for an equilibrium has ended at one, no step being left to make: else a finding.
void require_arrived(const Equilibrium& found, std::string_view solver, AnalysisVerdict& result);

/// How a solver found the equilibrium, and along what it meets no stiffness.
std::string equilibrium_text(const Equilibrium& found, std::string_view solver);

}  // namespace concord::compare::analyses
