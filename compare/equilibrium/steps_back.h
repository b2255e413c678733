#pragma once

#include <limits>
#include <optional>
#include <variant>

#include "common/solver.h"
#include "compare/states/chart.h"

namespace concord::compare {

/// A place of rest.
struct Rest {
  State state;
  Evaluation evaluation;
};

/// Of the equilibria that directions without stiffness lead to, the one nearest to the start is meant: steps towards
/// it, by least squares of the joints' coordinates. The places of rest may end before it, as where a stop begins to
/// press; a step beyond their edge leads back to where it was made, or farther, and shorter ones are made instead.
class StepsBack {
 public:
  /// Model and start must outlive it.
  StepsBack(const Model& model, const State& start) : model_(model), start_(start) {}

  /// At a place of rest: no step, a step in the chart there, or an earlier place of rest to go on from. `longest` is
  /// the longest step that is made at once; what is farther takes many. Where relaxing takes long, as where a stiff
  /// latch was opened by a strain of second order, steps are shorter from then on.
  using Next = std::variant<std::monostate, VecX, Rest>;
  [[nodiscard]] Next next(Chart& chart, const MatX& directions, const Rest& here, double longest);

  /// What a step back has strained relaxes in the next few steps. Returns such a step without its part along the
  /// directions of the one back, which look as if they met stiffness as long as forces turn with them; later steps as
  /// they are.
  [[nodiscard]] VecX relaxed(const Chart& chart, const VecX& step);

  /// Whether the last steps were short because longer ones failed. Where places of rest end between the start and the
  /// one that was found, it is on their edge, as far as forces that vanish there tell.
  [[nodiscard]] bool is_at_edge() const { return share_ < 1.0; }
  /// How many iterations the steps may take, with their corrections.
  [[nodiscard]] int iterations() const;

 private:
  /// Where the last step was made, what the joints had moved by then, and what they move by the step, at least.
  struct Made {
    Rest rest;
    VecX moved;
    VecX step;
  };
  /// Whether the last step led back, as from an edge, or farther from the start than it was made.
  [[nodiscard]] bool has_failed(const State& here, const VecX& moved) const;
  [[nodiscard]] MatX joint_rates(const Chart& chart, const MatX& directions) const;

  const Model& model_;
  const State& start_;
  std::optional<Made> made_;
  MatX way_;  // velocities along the directions of the last step; none if it was none
  int relaxations_ = 0;
  int astray_ = 0;        // iterations after steps back that took long to relax
  double shorter_ = 1.0;  // of the longest step, for good
  double share_ = 1.0;    // of the way to the nearest place by the directions
  int successes_ = 0;     // since the share became less
  double last_size_ = std::numeric_limits<double>::infinity();
  int near_ = 0;
  int far_ = 0;
  int returns_ = 0;
};

}  // namespace concord::compare
