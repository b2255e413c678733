#include "compare/equilibrium/step_limit.h"

#include <algorithm>

#include "compare/equilibrium/joint_changes.h"

namespace concord::compare {

void StepLimit::shorten(const Chart& chart, VecX& step) {
  constexpr double kMostTurn = 2.0;   // rad: farther, turns of joints would be miscounted
  constexpr double kStraight = 0.99;  // cosine
  constexpr double kOnward = 0.5;
  constexpr double kBack = -0.5;
  constexpr double kNotMuchShorter = 0.5;  // than the last one
  constexpr double kLong = 0.2;            // of the limit
  constexpr int kInARow = 10;              // three radians, or lengths, by the first limit
  const JointStep joints = joint_step(*model_, chart, step);
  const VecX direction = joint_speeds(*model_, chart.origin_moving(step)).normalized();
  const double along = last_direction_.size() > 0 ? direction.dot(last_direction_) : 0.0;
  last_direction_ = direction;
  if (along < kBack && joints.largest() > std::max(kNotMuchShorter * last_move_, kLong * limit_)) limit_ *= 0.5;
  if (along > kOnward && limit_ < kFirst) limit_ *= 2.0;
  if (straight_on_ > kInARow && joints.largest() > limit_) limit_ *= 2.0;
  const double cut = std::max({1.0, joints.largest() / limit_, joints.turn / kMostTurn, joints.into_stops});
  straight_on_ = cut > 1.0 && along > kStraight ? straight_on_ + 1 : 0;
  last_move_ = joints.largest() / cut;
  step /= cut;
}

void StepLimit::halve() {
  last_move_ *= 0.5;
  limit_ = last_move_;
  straight_on_ = 0;
}

}  // namespace concord::compare
