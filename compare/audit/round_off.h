#pragma once

#include <array>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "common/results.h"
#include "compare/audit/free_body.h"

/// What round-off explains of what an audit finds.
namespace concord::compare {

/// States that no solver can tell from this one: every place, orientation and velocity moved by a few units of
/// round-off of what it is computed from. What a law makes of them is what is known of its force: that of a stiff
/// spring is attached by the last digits of its length.
std::array<State, 2> within_roundoff(const State& state, double length);

/// States moved by sixteen times as much, two of them to sides opposite to those of the others: where a law jumps so
/// near, one of them is beyond the jump. Places of bodies are sums along chains of them, so that solvers differ by some
/// of their units.
std::array<State, 4> about_a_jump(const State& state, double length);

/// What of residuals no round-off explains, `roundoff` being measured on two states.
VecX beyond_roundoff(const VecX& residuals, const VecX& roundoff);

/// The answer of the solver that is audited in a state that differs by round-off from the one it is asked about, the
/// k-th of several; nothing where it gives none.
using Redraw = std::function<std::optional<std::pair<State, Evaluation>>(const State& state, int k)>;

/// Whether some row of the balance leaves over what may be a breach.
bool is_suspicious(const Balance& balance);

/// A solver's own round-off in one state, found when it is first asked for: where its equations are ill-conditioned, as
/// those of a light body between heavy ones, what its answer leaves over changes as a whole with the last digits of the
/// state. A fault stays what it is.
class OwnRoundOff {
 public:
  OwnRoundOff(const State& state, const Redraw& redraw) : state_(state), redraw_(redraw) {}

  /// The rows of a balance, without those that are within 20 times of what they change by when the state moves by
  /// round-off; rows beyond 1e-6 of their scale stay, as no sound solver resolves so little. `again` computes the rows
  /// for another state and answer.
  VecX unexplained(const Balance& balance, const std::function<VecX(const State&, const Evaluation&)>& again);

 private:
  const State& state_;
  const Redraw& redraw_;
  std::optional<std::vector<std::pair<State, Evaluation>>> drawn_;
};

}  // namespace concord::compare
