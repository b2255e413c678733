#include "compare/equilibrium/step_length.h"

#include <algorithm>
#include <cmath>

#include "compare/equilibrium/joint_changes.h"

namespace concord::compare {

namespace {

constexpr double kSameDirection = 0.9;  // cosine

}  // namespace

void StepLength::shorten(const Chart& chart, bool as_a_whole, VecX& step) {
  constexpr double kMostTurn = 2.0;  // rad
  constexpr int kMostStraightOn = 3000;
  const JointStep joints = joint_step(model_, chart, step);
  move_before_ = last_move_;
  last_move_ = std::min(joints.largest(), longest());
  const bool slides = joints.rest > joints.turn;
  const double size = as_a_whole ? step.norm() * joints.part_of_gears() : joints.largest();
  const double of_turns = (slides ? joints.turn : size) / longest();
  const double of_slides = slides ? size / longest_slide_ : 0.0;
  const VecX velocities = chart.velocities(step).normalized();
  along_ = last_velocities_.size() > 0 ? velocities.dot(last_velocities_) : 0.0;
  last_velocities_ = velocities;
  if (along_ < 0.0) {
    longest_slide_ = std::max(longest_, 0.25 * longest_slide_);
  } else if (along_ > kSameDirection && of_slides > std::max(1.0, of_turns)) {
    longest_slide_ *= 2.0;
  }
  const double of_shafts = joints.fastest_turn / kMostTurn;
  const double others = std::max(of_turns, slides ? size / longest_slide_ : 0.0);
  const double cut = std::max({others, of_shafts, joints.into_stops});
  if (cut > 1.0) step /= cut;
  if (of_shafts > std::max(others, 1.0)) {
    ++cut_by_shafts_;
  } else if (along_ > kSameDirection && cut > 1.0 && cut_straight_on_ < kMostStraightOn) {
    ++cut_straight_on_;
  }
}

void StepLength::count_fall() {
  constexpr int kManyTimes = 15;
  if (along_ < 0.0 && ++falls_back_ % kManyTimes == 0) longest_ *= 0.5;
}

void StepLength::count_leap() {
  constexpr double kBack = -0.5;  // cosine
  constexpr double kNotShorter = 0.5;
  constexpr double kLong = 0.2;  // of the longest: a limit on less would be none
  constexpr int kLeaps = 4;
  if (along_ < kBack && last_move_ > kNotShorter * move_before_ && last_move_ > kLong * longest()) {
    if (++leaps_back_ % kLeaps == 0) share_ *= 0.5;
    return;
  }
  leaps_back_ = 0;
  if (along_ > kSameDirection) share_ = std::min(1.0, 2.0 * share_);
}

int StepLength::steps_to_stops(const Chart& chart, const VecX& push) const {
  constexpr double kMost = 1000.0;
  constexpr double kShorter = 2.0;  // than the longest are some on the way
  const State moving = chart.origin_moving(push);
  const JointStep joints = joint_step(model_, chart, push);
  const double lasting = std::max(joints.largest(), joints.fastest_turn) / longest_;
  double steps = 0.0;
  for (const SprungCoordinate& one : sprung_coordinates(model_, moving, motions_of(model_, moving))) {
    for (const auto& stop : {one.law->lower, one.law->upper}) {
      if (!stop) continue;
      const double way = std::abs(stop->at - one.x);
      const bool goes_there = (stop->at - one.x) * one.xdot > 0.0;
      steps = std::max({steps, way / (longest_ * (one.is_length ? model_.length_scale() : 1.0)),
                        goes_there ? way * lasting / std::abs(one.xdot) : 0.0});
    }
  }
  return static_cast<int>(std::min(kMost, std::ceil(kShorter * steps)));
}

bool StepLength::crawls(double size) {
  constexpr double kMuch = 0.5;
  constexpr int kManySteps = 20;
  const bool falls_a_little = size < last_size_ && size > kMuch * last_size_;
  crawling_steps_ = falls_a_little ? crawling_steps_ + 1 : 0;
  last_size_ = size;
  return crawling_steps_ >= kManySteps;
}

}  // namespace concord::compare
