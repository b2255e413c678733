#include "relative/run/fastest_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/error.h"

namespace concord::relative {

namespace {

/// |udot_c| changes by so much where `move` moves the coordinates by `step`.
template <class Move>
double change(Equations& equations, const Coordinates& at, int c, double step, const Move& move) {
  double udot[2];
  for (const int side : {0, 1}) {
    Coordinates there = at;
    move(there, side == 0 ? step : -step);
    udot[side] = equations.compute_accelerations(there.t, there.q, there.u).udot()(c);
  }
  return 0.5 * std::abs(udot[0] - udot[1]);
}

}  // namespace

FastestMotion fastest_motion(Equations& equations, const Coordinates& at) {
  constexpr double kStep = 1e-7;
  FastestMotion fastest;
  const Topology& topology = equations.topology();
  const double length = machine_length(equations.model());
  for (const JointIndex k : upward<JointIndex>(topology.joints.size())) {
    const Span& span = topology.joints[k];
    const Mobilizer& mobilizer = equations.kinematics().mobilizer(k);
    for (int c = 0; c < mobilizer.n_u(); ++c) {
      const int place = span.first_u + c;
      if (place >= topology.n_tree_u || equations.driven()[place] != 0) continue;
      const double step = kStep * (mobilizer.kind(c).is_length ? length : 1.0);
      try {
        const auto speed_up = [&](Coordinates& there, double by) { there.u(place) += by; };
        const auto displace = [&](Coordinates& there, double by) {
          const VecX along = by * VecX::Unit(span.n_u, c);
          mobilizer.advance(there.q.data() + span.first_q, along.data());
        };
        const double damped = change(equations, at, place, step, speed_up) / step;
        const double sprung = change(equations, at, place, step, displace) / step;
        const double rate = std::max(damped, std::sqrt(sprung));
        if (rate > fastest.rate) fastest = {fmt::format("joint '{}'", equations.model().joints[k].name), rate};
      } catch (const SolverError&) {  // not defined so near to here
      }
    }
  }
  return fastest;
}

std::string place_of_cost(Equations& equations, const Coordinates& at) {
  std::string text;
  if (equations.closure().n_rows() > 0) {
    text = fmt::format("; {} has the largest multiplier there",
                       equations.closure().worst_place(equations.loops().solution().lambda));
  }
  Equations alone(equations.model());
  alone.count_turns_as(equations);
  const FastestMotion fastest = fastest_motion(alone, at);
  if (fastest.of.empty()) return text;
  return text + fmt::format("; the fastest motion there is that of {}, at {:.1e} per s", fastest.of, fastest.rate);
}

}  // namespace concord::relative
