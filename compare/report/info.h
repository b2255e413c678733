#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/solver.h"

namespace concord::compare {

/// What one solver says about a machine at its start.
struct SolverView {
  std::string name;
  std::vector<std::string> cut_joints;
  std::vector<std::string> integrators;
  RankReport rank;
};

/// Bodies, joints, degrees of freedom, loops, cut joints, rank and uniqueness as text.
std::string format_info(const Model& model, const std::array<SolverView, 2>& solvers);

}  // namespace concord::compare
