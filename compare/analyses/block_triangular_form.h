#pragma once

#include <vector>

#include "common/model.h"
#include "common/types.h"

/// In which order the velocities of a driven machine follow from each other.
namespace concord::compare::analyses {

/// Rows of velocity_equations() that hold certain columns, once those of earlier blocks are known.
struct Block {
  std::vector<Eigen::Index> rows;
  std::vector<Eigen::Index> columns;
};

/// The equations as they are solved one after the other, by what the model connects alone: bodies on driven joints from
/// the ground on, speeds of joints between two bodies that move as is known; then what is left, part by part where
/// parts share no unknown. Without a degree of freedom a block has at least as many rows as columns; equations between
/// known velocities alone are in none.
std::vector<Block> block_triangular_form(const Model& model);

}  // namespace concord::compare::analyses
