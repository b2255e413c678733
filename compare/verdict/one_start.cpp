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

std::optional<SpreadOfClosing> spread_of_closing(const Model& model, const std::array<Solver*, 2>& solvers,
                                                 const std::array<State, 2>& starts, std::uint64_t seed) {
  const auto one = known_to(model, *solvers[0], starts[0], seed);
  const auto other = known_to(model, *solvers[1], starts[1], seed);
  if (!one || !other) return std::nullopt;
  return SpreadOfClosing{std::min(*one, *other), std::max(*one, *other)};
}

bool is_explained_by_closing(double apart, double spread) {
  constexpr double kElsewhere = 1e-4;  // no round-off, however ill-conditioned the closing is
  return apart <= std::min(kWithinResolution * spread, kElsewhere);
}

std::optional<OneStart> one_start(const Model& model, const std::array<Solver*, 2>& solvers,
                                  const std::array<State, 2>& starts, std::uint64_t seed) {
  const double apart = distance(starts[0], starts[1], sizes_of(model, starts[0]));
  if (!(apart > kSameClosing)) return std::nullopt;
  const std::optional<SpreadOfClosing> spread = spread_of_closing(model, solvers, starts, seed);
  if (!spread || spread->least <= kSameClosing || !is_explained_by_closing(apart, spread->most)) return std::nullopt;
  for (std::size_t who = 0; who < 2; ++who) {
    if (!accepts(*solvers[1 - who], starts[who])) continue;
    return OneStart{
        starts[who],
        fmt::format("closing from round-off around the start ends {:.1e} of its size from it, "
                    "as near a singular pose; the solvers' starts differ by {:.1e}: both run from that of {}",
                    spread->most, apart, solvers[who]->name())};
  }
  return std::nullopt;
}

}  // namespace concord::compare
