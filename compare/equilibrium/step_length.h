#pragma once

#include "common/model.h"
#include "compare/states/chart.h"

namespace concord::compare {

/// How far a search for an equilibrium goes in one step. Angles change by little, those of fast shafts by what a
/// rotation vector can say. Slides, which may have far to go, change by twice as much each time that they are cut short
/// in the same direction. A search that leaps to and fro, as across the edge of a stiff stop, goes on in shorter steps
/// until it goes one way again.
class StepLength {
 public:
  /// `longest` [of the machine's length, rad].
  StepLength(const Model& model, double longest)
      : model_(model), longest_(longest), longest_slide_(longest), last_move_(longest) {}

  /// Cuts a step of the chart's coordinates. `as_a_whole`: by its norm, not by its largest change of a joint.
  void shorten(const Chart& chart, bool as_a_whole, VecX& step);

  /// Tells of a step. A search that turns back in very many steps down from an unstable pose (`falls`) leaps to and fro
  /// across a narrow valley, and goes on in steps half as long. Where other steps turn back again and again without
  /// becoming shorter, the longest is halved; it grows again where they go one way.
  void count_step(bool falls) { falls ? count_fall() : count_leap(); }
  /// Whether accelerations, now of this size, have fallen for many steps, and little in each: the rest lies straight
  /// ahead, and these steps are short for it. Counts the steps in which it is asked.
  [[nodiscard]] bool crawls(double size);
  /// The most steps that may pass until joints and springs that are pushed this way [of the chart's coordinates] reach
  /// the farthest of their stops: what a gear or a thread moves slowly is long on the way.
  [[nodiscard]] int steps_to_stops(const Chart& chart, const VecX& push) const;
  /// Where the search is at rest, leaps are over.
  void forget_leaps() { share_ = 1.0; }

  [[nodiscard]] double longest() const { return share_ * longest_; }
  [[nodiscard]] double longest_slide() const { return longest_slide_; }
  /// The largest change of a joint by the last step, before it was cut, up to the longest.
  [[nodiscard]] double last_move() const { return last_move_; }
  /// Steps that fast shafts alone have made short, and up to 3000 that went on the same way, as far as they may.
  [[nodiscard]] int uncounted() const { return cut_by_shafts_ + cut_straight_on_; }

 private:
  void count_fall();
  void count_leap();

  const Model& model_;
  double longest_;
  double share_ = 1.0;  // of it, as leaps ask for
  double longest_slide_;
  double last_move_;
  double move_before_ = 0.0;
  VecX last_velocities_;
  double along_ = 0.0;  // cosine between the last two steps
  int falls_back_ = 0;
  int leaps_back_ = 0;
  int cut_by_shafts_ = 0;
  int cut_straight_on_ = 0;
  int crawling_steps_ = 0;
  double last_size_ = 0.0;
};

}  // namespace concord::compare
