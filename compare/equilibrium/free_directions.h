#pragma once

#include <string>
#include <vector>

#include "common/model.h"
#include "compare/states/chart.h"

namespace concord::compare {

/// A direction in which a machine at rest meets no stiffness.
struct FreeDirection {
  std::string name;  // "hinge: turn_z 1" or "body coupler: ..."
};

/// Such directions, columns of the chart's coordinates, told apart by the joints that move along them, in
/// the order of their names.
std::vector<FreeDirection> name_free_directions(const Model& model, const Chart& chart, const MatX& directions);

/// Throws SingularPose, or the solver's refusal as SolverError, where neighbours of the chart's origin, looked at in
/// one direction, have other directions of motion than the origin. `name`: who asks.
void refuse_singular(Chart& chart, const std::string& name);

}  // namespace concord::compare
