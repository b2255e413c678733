#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/joints/joint_type.h"

/// What the words of a motion say of it at every pose, before any coordinate is known.
namespace concord::relative {

/// What one speed of a joint can do to the child at any pose, and the unit of its coordinate.
struct ColumnKind {
  bool displaces = false;  // S has entries in the rows of ddot
  bool rotates = false;    // and in those of omega_rel
  bool is_length = false;  // q in m; else in rad
  bool is_fixed = false;   // the column is the same in every pose: a unit vector along or about
  int axis = 0;            // this axis of the parent's joint frame
};

struct MotionStructure {
  std::array<ColumnKind, 6> kinds{};
  int n_u = 0;
  /// Speeds before those of a ball: one for each coordinate that is one number.
  int n_scalars = 0;
  /// The second of two turns at right angles that carry a link, at right angles to it, to a ball: two sets of
  /// coordinates name each pose. -1: none.
  int elevation = -1;
  bool has_ball = false;
  /// Whether the child's point can leave the parent's.
  bool has_place = false;
  bool by_functions = false;
  /// Whether d or R depends on q other than by slides and turns in place.
  bool is_curved = false;
  /// Whether the columns of S are independent in every pose.
  bool rank_is_certain = true;
  std::vector<std::array<double, 2>> ranges;  // of a motion by functions, if it states them
};

/// The structure of the motion that a type permits. Throws std::invalid_argument, which names the type, if its words
/// stand in an order that the vocabulary excludes, if it has more than six speeds, or if a motion by functions does not
/// say of each coordinate whether it is a turn.
MotionStructure structure_of(const joints::JointType& type);

}  // namespace concord::relative
