#include "compare/equilibrium/steps_back.h"

#include <algorithm>
#include <utility>

#include "common/decompositions.h"
#include "compare/equilibrium/joint_changes.h"
#include "compare/equilibrium/step_limit.h"

namespace concord::compare {

namespace {

constexpr int kMostSteps = 300;
constexpr int kMostReturns = 15;
constexpr double kNoNearer = 0.9;
constexpr double kPartOfTheWay = 0.1;
constexpr double kShorterStep = 0.25;
constexpr int kNoEdge = 5;            // steps without failure after which longer ones are tried again
constexpr double kSeenStep = 1e-6;    // its half square is no round-off of the distance
constexpr double kLeastSpeed = 1e-7;  // of the fastest joint's

}  // namespace

bool StepsBack::has_failed(const State& here, const VecX& moved) const {
  if (!made_) return false;
  const double before = made_->moved.norm();
  const VecX went = joint_displacements(model_, made_->rest.state, here);
  if (went.dot(made_->step) >= kPartOfTheWay * made_->step.squaredNorm()) {
    return made_->step.norm() > kSeenStep * std::max(1.0, before) &&
           moved.norm() > before;  // it went beyond the nearest place
  }
  // Where skates or rolling wheels lead elsewhere, it may have come nearer all the same.
  return before - moved.norm() < -kPartOfTheWay * made_->moved.dot(made_->step) / before;
}

MatX StepsBack::joint_rates(const Chart& chart, const MatX& directions) const {
  MatX rates;
  for (Eigen::Index k = 0; k < directions.cols(); ++k) {
    const VecX of_one = joint_speeds(model_, chart.origin_moving(directions.col(k)));
    // What round-off of the directions mixes in must not count the ways of joints that do not move along them.
    const double seen = kLeastSpeed * of_one.lpNorm<Eigen::Infinity>();
    rates.conservativeResize(of_one.size(), directions.cols());
    rates.col(k) = (of_one.array().abs() < seen).select(0.0, of_one);
  }
  return rates;
}

StepsBack::Next StepsBack::next(const Chart& chart, const MatX& directions, const Rest& here, double longest) {
  if (directions.cols() == 0 || steps_ == kMostSteps || (returns_ == kMostReturns && !made_)) return {};
  const VecX moved = joint_displacements(model_, start_, here.state);
  if (has_failed(here.state, moved)) {
    share_ *= kShorterStep;
    successes_ = 0;
    ++returns_;
    Rest nearest = std::move(made_->rest);
    made_.reset();
    return nearest;
  }
  if (made_ && ++successes_ % kNoEdge == 0) share_ = std::min(1.0, share_ / kShorterStep);
  const MatX rates = joint_rates(chart, directions);
  const MatX weighed = weighed_by_nearness(model_, moved, rates);
  const VecX along = share_ * smallest_least_squares(weighed, moved, kRoundOffStep);
  const VecX step = -directions * along;
  const double size = step.norm();
  if (size <= kRoundOffStep || (size <= kSmallStep && (share_ < 1.0 || size >= kNoNearer * last_size_))) return {};
  last_size_ = size;
  made_ = Made{here, moved, -std::min(1.0, longest / size) * (rates * along)};
  ++steps_;
  return step;
}

}  // namespace concord::compare
