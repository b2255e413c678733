#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "compare/verdict/verdict.h"

/// What redundant constraints leave open, and what they do not, in words.
namespace concord::compare {

/// Whether a joint is one of those that the line on planar loops names.
bool is_across_plane(const std::optional<PlanarLoops>& planar, int joint);

/// One line for all joints of planar loops, without its end: "across the plane of the loops, normal (0, 0, 1): forces
/// along it and torques about axes in the plane in joints A, B, C".
std::string planar_text(const Model& model, const PlanarLoops& planar);

/// A line for each vector that is unique but for a direction, with its digits.
std::string partly_unique_text(const Model& model, const Verdict& verdict);

/// Which changes of joints would make every reaction unique, or that none of those tried would; empty if none was.
std::string cures_text(const Model& model, const Cures& cures);

/// Adds `partly_unique`, `planar_loops` and `unique_if` to a document, each where there is something to say.
void add_redundancy(nlohmann::ordered_json& said, const Model& model, const Verdict& verdict);

}  // namespace concord::compare
