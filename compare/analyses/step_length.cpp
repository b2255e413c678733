#include "compare/analyses/step_length.h"

#include <algorithm>

#include "compare/analyses/joint_changes.h"

namespace concord::compare::analyses {

void StepLength::shorten(const Chart& chart, bool as_a_whole, VecX& step) {
  constexpr double kMostTurn = 2.0;       // rad
  constexpr double kSameDirection = 0.9;  // cosine
  const JointStep joints = joint_step(model_, chart, step);
  last_move_ = std::min(joints.largest(), longest_);
  const bool slides = joints.rest > joints.turn;
  const double size = as_a_whole ? step.norm() * joints.part_of_gears() : joints.largest();
  const double of_turns = (slides ? joints.turn : size) / longest_;
  const double of_slides = slides ? size / longest_slide_ : 0.0;
  const VecX velocities = chart.velocities(step).normalized();
  const double along = last_velocities_.size() > 0 ? velocities.dot(last_velocities_) : 0.0;
  last_velocities_ = velocities;
  turned_back_ = along < 0.0;
  if (along < 0.0) {
    longest_slide_ = std::max(longest_, 0.25 * longest_slide_);
  } else if (along > kSameDirection && of_slides > std::max(1.0, of_turns)) {
    longest_slide_ *= 2.0;
  }
  const double of_shafts = joints.fastest_turn / kMostTurn;
  const double others = std::max(of_turns, slides ? size / longest_slide_ : 0.0);
  const double cut = std::max(others, of_shafts);
  if (cut > 1.0) step /= cut;
  if (of_shafts > std::max(others, 1.0)) ++cut_by_shafts_;
}

void StepLength::count_fall() {
  constexpr int kManyTimes = 15;
  if (turned_back_ && ++leaps_back_ % kManyTimes == 0) longest_ *= 0.5;
}

}  // namespace concord::compare::analyses
