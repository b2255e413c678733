#pragma once

#include <algorithm>
#include <vector>

#include "common/solver.h"
#include "compare/audit/joint_motion.h"
#include "compare/states/chart.h"

/// What joints do between two states, and along a direction of motion.
namespace concord::compare {

/// The largest changes of coordinates in a step: of a joint's angles [rad]; of its slides [of the machine's length] and
/// of modes [modal_sizes()].
struct JointStep {
  double turn = 0.0;
  double rest = 0.0;
  double into_stops = 0.0;  // in units of the way to half the width of a stop, or by that further into it

  [[nodiscard]] double largest() const { return std::max(turn, rest); }
};
JointStep joint_step(const Model& model, const Chart& chart, const VecX& step);

/// The motion of joint k in a state; of all.
JointMotion motion_of(const Model& model, std::size_t k, const State& state);
std::vector<JointMotion> motions_of(const Model& model, const State& state);

/// What a law of force reads: a coordinate of a joint with a spring on it, the distance of a line spring's ends, the
/// angle of a turn spring; and its rate.
struct SprungCoordinate {
  const ForceLaw* law;
  double x;     // m or rad
  double xdot;  // m/s or rad/s
  bool is_length;
};
/// Of all springs in a state, in which the joints have these motions.
std::vector<SprungCoordinate> sprung_coordinates(const Model& model, const State& state,
                                                 const std::vector<JointMotion>& motions);

/// Speeds of all joints; slides by the machine's length.
VecX joint_speeds(const Model& model, const State& state);

/// By how much the coordinates of all joints differ in `state` from those in `start`, in the rows of joint_speeds(); of
/// a ball by the rotation vector of its turn.
VecX joint_displacements(const Model& model, const State& start, const State& state);

/// Rates W of joint speeds, weighed so that (W^T W)^-1 W^T moved is Newton's step of |moved|^2 / 2 for
/// joint_displacements() `moved`, but for how the motions themselves bend: across the turn theta of a ball its
/// curvature is (theta / 2) cot(theta / 2), not 1.
MatX weighed_by_nearness(const Model& model, const VecX& moved, MatX rates);

}  // namespace concord::compare
