#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "compare/random_machines/machine.h"
#include "compare/random_machines/outcome.h"

/// Makes a machine smaller as long as the same thing becomes of it.
namespace concord::compare::fuzz {

/// Smaller machines that follow from one by one change each, those that take the most away first; each has been placed.
/// `choice` is that of place().
std::vector<Machine> smaller_machines(const Machine& machine, std::uint64_t choice);

/// Tells the first of the machines that keeps its kind of outcome; nothing if none does.
using FirstThatKeeps = std::function<std::optional<std::size_t>(const std::vector<Machine>& candidates)>;

/// The smallest machine that is found by taking the first change that keeps the outcome, again and again.
Machine shrink(Machine machine, std::uint64_t choice, const FirstThatKeeps& first_that_keeps);

/// What is left to take away: parts, terms, numbers that are not round.
double size_of(const Machine& machine);

}  // namespace concord::compare::fuzz
