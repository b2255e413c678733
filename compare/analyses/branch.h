#pragma once

#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "common/types.h"

/// On which of the branches that close a driven machine a motion stays. Two poses of a linkage at the same place of its
/// drivers lie on both sides of a singular pose, and between them the determinant of the equations for its velocities
/// changes its sign; along a motion that passes no singular pose it keeps it, however narrow the passage is.
/// Needed by a crank that is hardly shorter than its rod (tests/verification/driven_motions_test); whether one pose is
/// singular is another question (compare/states/singular_pose).
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

/// The equations for all velocities of a machine in one state: v_rel - S u = 0 at each joint, global axes, u = its law
/// at each driver, the sum of the factors times u = 0 at each coupling; over the bodies' velocities and all joint
/// speeds, lengths by the machine's, by the kinematics of the third opinion. Without a degree of freedom there are as
/// many independent rows as columns; redundant ones come on top.
MatX velocity_equations(const Model& model, const State& state);

/// Whether two states may be joined by a motion without a singular pose, as far as the sign of det(M^T N) tells, M and
/// N the equations of both: that of det M det N where none is redundant. Each part of a machine that moves by itself
/// once its drivers do, as one of two linkages on one crank, has a sign of its own. Where round-off may decide a sign
/// they may be. `blocks`: block_triangular_form() of the model.
bool are_on_one_branch(const Model& model, const std::vector<Block>& blocks, const State& one, const State& other);

}  // namespace concord::compare::analyses
