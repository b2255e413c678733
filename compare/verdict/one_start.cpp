#include "compare/verdict/one_start.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/verdict/resolution.h"
#include "compare/verdict/states.h"

namespace concord::compare {

namespace {

/// The farthest that closing from round-off around a start ends from it; nothing if it closes from too few.
std::optional<double> known_to(const Model& model, Solver& solver, const State& start, std::uint64_t seed) {
  const StateSizes sizes = sizes_of(model, start);
  // A state that closes within round-off is left as it is: begin a little outside.
  constexpr double kUnits = 64.0;
  double farthest = 0.0;
  int closed = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const auto of_draw = seed + static_cast<std::uint64_t>(draw);
    const auto found = solver.close(draw_within_roundoff(start, sizes, of_draw, kUnits));
    if (!found) continue;
    farthest = std::max(farthest, distance(*found, start, sizes));
    ++closed;
  }
  if (closed < kFewestDraws) return std::nullopt;
  return farthest;
}

}  // namespace

std::optional<double> spread_of_closings(const Model& model, const std::array<Solver*, 2>& solvers,
                                         const std::array<State, 2>& starts, std::uint64_t seed) {
  double known = 0.0;
  for (std::size_t who = 0; who < 2; ++who) {
    const auto found = known_to(model, *solvers[who], starts[who], seed);
    if (!found || *found <= kSameClosing) return std::nullopt;
    known = std::max(known, *found);
  }
  return known;
}

bool is_explained_by_closing(double apart, double spread) {
  constexpr double kElsewhere = 1e-4;  // no round-off, however ill-conditioned the closing is
  return apart <= std::min(kWithinResolution * spread, kElsewhere);
}

std::optional<OneStart> one_start(const Model& model, const std::array<Solver*, 2>& solvers,
                                  const std::array<State, 2>& starts, std::uint64_t seed) {
  const double apart = distance(starts[0], starts[1], sizes_of(model, starts[0]));
  if (!(apart > kSameClosing)) return std::nullopt;
  const std::optional<double> known = spread_of_closings(model, solvers, starts, seed);
  if (!known || !is_explained_by_closing(apart, *known)) return std::nullopt;
  for (std::size_t who = 0; who < 2; ++who) {
    if (!accepts(*solvers[1 - who], starts[who])) continue;
    return OneStart{
        starts[who],
        fmt::format("closing from round-off around the start ends {:.1e} of its size from it, "
                    "as near a singular pose; the solvers' starts differ by {:.1e}: both run from that of {}",
                    *known, apart, solvers[who]->name())};
  }
  return std::nullopt;
}

}  // namespace concord::compare
