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
  /// the longest step that is made at once; what is farther takes many.
  using Next = std::variant<std::monostate, VecX, Rest>;
  [[nodiscard]] Next next(const Chart& chart, const MatX& directions, const Rest& here, double longest);

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
  double share_ = 1.0;  // of the way to the nearest place by the directions
  int successes_ = 0;   // since the share became less
  double last_size_ = std::numeric_limits<double>::infinity();
  int steps_ = 0;
  int returns_ = 0;
};

}  // namespace concord::compare
