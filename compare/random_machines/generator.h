#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "compare/random_machines/machine.h"

namespace concord::compare::fuzz {

/// What kind of machines are drawn.
enum class Style {
  mixed,      // all of what follows but the last in turn
  generic,    // tilted frames, offsets along no axis
  ordinary,   // aligned, symmetric, at rest, round numbers
  loops,      // at least one loop
  redundant,  // loops with constraints that depend on each other
  flexible,   // at least one flexible body
  forces,     // many force elements and springs
  wide,       // sizes and masses over many decades
  stiff       // springs and dampers far beyond the pace of the motion, or slender bodies; slow to compare
};

/// Names of the styles in their order.
const std::vector<std::string>& style_names();

/// Machine `number` of a seed: the same on every computer, whatever was drawn before. It has been placed: its text is a
/// model that can start, as far as the generator knows.
Machine draw_machine(std::uint64_t seed, std::uint64_t number, Style style);

}  // namespace concord::compare::fuzz
