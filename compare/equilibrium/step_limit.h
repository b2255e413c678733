#pragma once

#include "common/model.h"
#include "compare/states/chart.h"

namespace concord::compare {

/// A search may end with a step as short as the first, and does end with one as short as the second: it is round-off
/// [rad, of the machine's length].
inline constexpr double kSmallStep = 1e-9;
inline constexpr double kRoundOffStep = 1e-14;

/// How far a search for an equilibrium goes in one step: no joint changes by more than one limit. It halves where a
/// step turns back and is not much shorter than the one before, or ends in no closed state; it doubles while steps go
/// on, up to its first value, and beyond that where ten in a row have gone straight on, as far as they may. No joint
/// turns by more than 2 rad, and no step enters a stop by more than half its width.
class StepLimit {
 public:
  explicit StepLimit(const Model& model) : model_(&model) {}

  /// Cuts a step of the chart's coordinates.
  void shorten(const Chart& chart, VecX& step);
  /// The last step ended in no closed state, and is made half as long.
  void halve();
  /// At a place of rest, from where another search begins.
  void begin_anew() { *this = StepLimit(*model_); }

  /// Of the largest change of a joint [of the machine's length, rad].
  [[nodiscard]] double limit() const { return limit_; }
  /// The largest change of a joint by the last step.
  [[nodiscard]] double last_move() const { return last_move_; }
  /// Whether steps go straight on, as far as they may, but not yet farther than any machine reaches.
  [[nodiscard]] bool goes_on() const { return straight_on_ > 0 && last_move_ < kFar; }

 private:
  static constexpr double kFirst = 0.3;
  static constexpr double kFar = 1e6;

  const Model* model_;
  double limit_ = kFirst;
  double last_move_ = kFirst;
  int straight_on_ = 0;
  VecX last_direction_;  // of joint_speeds()
};

}  // namespace concord::compare
