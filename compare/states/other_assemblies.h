#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "common/solver.h"

/// In which other poses could the loops of a machine have been assembled? A linkage that was put together on the wrong
/// branch passes every check of mechanics.
namespace concord::compare {

/// Starts in other poses than the given one, which keep what the model keeps and drives.
struct OtherAssemblies {
  std::vector<State> states;  // in the order in which they were found, each once
  int guesses = 0;            // that were tried
};

/// The joints of each loop: those that close one over a tree of the joints before them, with the tree's way between
/// their bodies; in the order of the model.
std::vector<std::vector<int>> loops_of(const Model& model);

/// Other starts, as far as they are found: a solver made by `make` assembles the machine from guesses in which
/// coordinates of one loop after another are mirrored or drawn, and from 16 in which all are drawn; what is kept or
/// driven stays. Draws are the same in each run, and of more than 16 loops the first 16 count. Only poses that
/// `accepts` takes count; two are the same if all bodies stand alike. Closed positions alone: nothing is integrated.
/// Without a loop nothing is sought.
OtherAssemblies find_other_assemblies(const Model& model, const State& start,
                                      const std::function<std::unique_ptr<Solver>(const Model&)>& make,
                                      const std::function<bool(const State&)>& accepts);

}  // namespace concord::compare
