#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/results.h"
#include "compare/quantities/agreement.h"

/// Observed order of each solver's integration: how what it leaves falls with the relative tolerance. It explains, and
/// is never judged.
namespace concord::compare {

struct RunPair;

/// How the errors of one solver's own runs fall with the relative tolerance, in one kind of numbers: error ~
/// rtol^exponent.
struct ObservedOrder {
  /// At the tolerances, loosest first; largest over the run, in parts of the largest of the kind.
  std::vector<double> errors;
  /// Missing where the errors do not fall from each tolerance to the next: not in the range of convergence.
  std::optional<double> exponent;
};

struct SolverOrders {
  ObservedOrder places;      // of origins by the length, angles of orientations, modal ones by the body's largest
  ObservedOrder velocities;  // of origins, angular ones times the length, by the largest; modal ones by the body's
  ObservedOrder reactions;   // of components that are unique, each by its scale; no errors if there are none
};

/// Observed orders of both solvers.
struct Orders {
  std::vector<double> tolerances;  // of the errors, loosest first
  double against = 0.0;            // the tolerance of the runs that the others are held against
  std::array<SolverOrders, 2> solvers;
};

/// Gathers runs at several tolerances, a part of their samples.
class OrderStudy {
 public:
  /// The layout must outlive it.
  explicit OrderStudy(const QuantityLayout& layout);

  /// Complete runs, side by side. Of two at tolerances that are near to each other the first counts.
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
