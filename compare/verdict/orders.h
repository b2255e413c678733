#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "compare/verdict/convergence.h"

/// Observed order of each solver's integration: how what it leaves falls with the relative tolerance. It explains, and
/// is never judged.
namespace concord::compare {

/// Gathers runs at several tolerances, a part of their samples.
class OrderStudy {
 public:
  /// The layout must outlive it.
  explicit OrderStudy(const QuantityLayout& layout);

  /// Complete runs, side by side. Of two at one tolerance the first counts.
  void add(const RunPair& pair);

  /// How many tolerances there are, and the loosest of them.
  [[nodiscard]] std::size_t size() const { return kept_.size(); }
  [[nodiscard]] double loosest() const { return kept_.front().rtol; }

  /// Of up to three tolerances, the tightest but one that all are held against; nothing with fewer than two such.
  /// `unique`: of the quantities in the samples of the runs; empty: all are.
  [[nodiscard]] std::optional<Orders> orders(const Mask& unique) const;

 private:
  struct Kept {
    double rtol = 0.0;
    std::array<std::string, 2> integrators;
    std::array<std::vector<std::vector<BodyState>>, 2> motions;  // sample by sample
    std::array<MatX, 2> reactions;
    VecX scales;  // of reactions
  };

  [[nodiscard]] double error_of_places(const Kept& one, const Kept& other, std::size_t who) const;
  [[nodiscard]] double error_of_velocities(const Kept& one, const Kept& other, std::size_t who) const;
  [[nodiscard]] std::optional<double> error_of_reactions(const Kept& one, const Kept& other, std::size_t who,
                                                         const Mask& unique) const;

  const QuantityLayout& layout_;
  std::vector<int> rows_;   // of reactions
  std::vector<Kept> kept_;  // loosest first
};

/// The exponent of errors at tolerances, both loosest first, by the slope of their logarithms; nothing if there are
/// fewer than two, or if the errors do not clearly fall from each to the next.
std::optional<double> observed_exponent(const std::vector<double>& tolerances, const std::vector<double>& errors);

/// A sentence for each solver: "observed order of cartesian, errors at rtol ...: places fall as rtol^0.98, ...".
std::vector<std::string> describe(const Orders& orders);

}  // namespace concord::compare
