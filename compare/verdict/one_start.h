#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "common/solver.h"

/// Where closing knows a start less well than round-off, as near a singular pose, both solvers run from the same one.
namespace concord::compare {

/// The farthest that closing from round-off around a solver's start ends from it, by its sizes: the least and the most
/// of two solvers.
struct SpreadOfClosing {
  double least = 0.0;
  double most = 0.0;
};
/// Nothing if one closes from too few.
std::optional<SpreadOfClosing> spread_of_closing(const Model& model, const std::array<Solver*, 2>& solvers,
                                                 const std::array<State, 2>& starts, std::uint64_t seed);

/// Whether starts so far apart, by their sizes, may be one that closing knows no better.
bool is_explained_by_closing(double apart, double spread);

/// A start for both, and a note that says so.
struct OneStart {
  State state;
  std::string note;
};

/// Nothing if the two starts are the same within kSameClosing, if they differ by more than closing explains, or if
/// neither solver accepts that of the other. What closing explains is measured by each solver alone: how far it ends
/// from its own start when it closes anew from round-off around it. Both must find more than kSameClosing, so that the
/// pose is to blame and not one solver; then the starts may differ by kWithinResolution times the larger.
std::optional<OneStart> one_start(const Model& model, const std::array<Solver*, 2>& solvers,
                                  const std::array<State, 2>& starts, std::uint64_t seed);

}  // namespace concord::compare
