#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/solver.h"
#include "compare/audit/cures.h"
#include "compare/resolution/open_reactions.h"

namespace concord::compare {

/// What one solver says about a machine at its start.
struct SolverView {
  std::string name;
  std::vector<std::string> cut_joints;
  std::vector<std::string> integrators;
  RankReport rank;
};

/// What redundant constraints mean for a machine at its start.
struct RedundancyView {
  std::optional<PlanarLoops> planar;
  Cures cures;
};

/// Bodies, joints, degrees of freedom, loops, cut joints, rank and uniqueness as text, and what would make all
/// reactions unique. Joints of planar loops are named in one line.
std::string format_info(const Model& model, const std::array<SolverView, 2>& solvers,
                        const RedundancyView& redundancy = {});

}  // namespace concord::compare
