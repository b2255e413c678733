#pragma once

#include <array>
#include <optional>
#include <vector>

#include "compare/audit/open_directions.h"
#include "compare/quantities/agreement.h"
#include "compare/quantities/align.h"
#include "compare/resolution/resolution.h"
#include "compare/states/singular_pose.h"

/// In which directions forces and torques of joints are not unique, state by state. The directions are the audit's;
/// they count where both solvers find the same components unique.
namespace concord::compare {

/// The force or the torque of a joint's reaction on a side that is not unique in some direction.
struct OpenReaction {
  Quantity of;  // a reaction; component 0: the force, 3: the torque
  OpenDirections open;
};

/// Those of one state, in the layout's order; nothing where a direction is in doubt, or where the audit finds other
/// components unique than one of the solvers does. Empty where both find everything unique. Throws SolverError if a
/// direction does not lie where the components are open.
std::optional<std::vector<OpenReaction>> open_reactions(const Model& model, const State& state,
                                                        const std::array<RankReport, 2>& reports);

/// The same by state.
using OpenReactions = std::vector<std::optional<std::vector<OpenReaction>>>;
OpenReactions open_reactions(const Model& model, const std::vector<SharedState>& states, const RankReports& reports);

/// On the part of each of them that is unique.
Projections projections_of(const QuantityLayout& layout, const OpenReactions& open);

/// Joints whose reactions are open across the plane in which their loops move, and nowhere else: forces along its
/// normal, torques about axes in it.
struct PlanarLoops {
  std::vector<int> joints;
  bool has_torques = false;    // whether torques are among them
  Vec3 normal = Vec3::Zero();  // global axes, in the first state
};

/// What of a state's open reactions is planar: nothing unless all are, between at least three bodies: bearings of one
/// axle share its thrust, and are no loop.
std::optional<PlanarLoops> planar_loops(const Model& model, const State& state, const std::vector<OpenReaction>& open);

}  // namespace concord::compare
