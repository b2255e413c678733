#pragma once

#include "common/model.h"

/// By how much modal coordinates move a body.
namespace concord::compare {

/// What a unit of each modal coordinate of a body deflects a mass point by at most [m]; 1 for a mode that deflects
/// none.
VecX largest_deflections(const Body& body);

/// How far a unit of each modal coordinate of a body moves it at most: a mass point, of the machine's length, or a
/// frame to which a joint or a force element is attached, in rad, as torsion does that hardly moves a point.
VecX modal_sizes(const Model& model, std::size_t body);

}  // namespace concord::compare
