#include "relative/dynamics/independent_rows.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace concord::relative {

namespace {

/// Diagonal entries of Lambda in machine units below this part of the largest are squares of round-off: the row
/// vanishes.
constexpr double kVanishing = 1e-22;

/// Squares of sizes, of the largest row's: rows that are larger are all as good.
constexpr double kSmall = 1e-2;

/// The square of the sine that a row must have against the rows chosen before, in rounds; by its weight, but in the
/// last two: a row that almost vanishes, and still says something of its own, goes before what round-off leaves of
/// others.
struct Round {
  double least;
  bool weighs = true;
};
constexpr std::array kRounds{Round{0.1},   Round{0.01},         Round{1e-4},      Round{1e-8},
                             Round{1e-12}, Round{1e-12, false}, Round{0.0, false}};

}  // namespace

bool IndependentRows::hold(RowIndex row) const { return std::binary_search(rows.begin(), rows.end(), row); }

double IndependentRows::least_weight() const {
  double least = 1.0;
  for (const RowIndex row : rows) least = std::min(least, weight[row]);
  return least;
}

void scale_rows(const VecX& diagonal, const VecX& units, IndependentRows& rows) {
  const Eigen::Index n = diagonal.size();
  double largest = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) largest = std::max(largest, diagonal(i) / (units(i) * units(i)));
  for (Eigen::Index i = 0; i < n; ++i) {
    const double size = diagonal(i) / (units(i) * units(i));
    const bool vanishes = !(size > kVanishing * largest);
    rows.scale(i) = vanishes ? 0.0 : 1.0 / std::sqrt(diagonal(i));
    rows.weight(i) = vanishes ? 0.0 : std::min(1.0, size / (kSmall * largest));
  }
}

bool RowChoice::choose(const MatX& Lambda, int rank, IndependentRows& chosen) {
  constexpr double kIndependent = 0.01;
  bool is_complete = take(Lambda, rank, true, chosen);
  // A small row that still says something of its own, as that of a beam which its bending begins to lock, says that the
  // pose has more independent rows than a general one: it is not passed over.
  const auto of_small = (chosen.weight.array() < 1.0).select(rest_.diagonal(), 0.0);
  if (of_small.maxCoeff() > kIndependent) is_complete = take(Lambda, rank, false, chosen);
  std::sort(chosen.rows.begin(), chosen.rows.end());
  return is_complete;
}

bool RowChoice::take(const MatX& Lambda, int rank, bool by_weight, IndependentRows& chosen) {
  std::vector<RowIndex>& rows = chosen.rows;
  rest_.noalias() = chosen.scale.asDiagonal() * Lambda * chosen.scale.asDiagonal();
  rows.clear();
  for (const Round& round : kRounds) {
    for (const RowIndex row : upward<RowIndex>(Lambda.rows())) {
      if (static_cast<int>(rows.size()) == rank) return true;
      const double weight = by_weight && round.weighs ? chosen.weight[row] : 1.0;
      if (!(weight * rest_(row.value(), row.value()) > round.least)) continue;
      rows.push_back(row);
      take_off(row);
    }
  }
  return static_cast<int>(rows.size()) == rank;
}

/// Takes a row and its part off what is left of the others.
void RowChoice::take_off(RowIndex independent) {
  const Eigen::Index pivot = independent.value();
  const double size = rest_(pivot, pivot);
  for (Eigen::Index j = 0; j < rest_.cols(); ++j) {
    if (j == pivot) continue;
    const double factor = rest_(pivot, j) / size;
    for (Eigen::Index i = 0; i < rest_.rows(); ++i) {
      if (i != pivot) rest_(i, j) -= factor * rest_(i, pivot);
    }
  }
  rest_.row(pivot).setZero();
  rest_.col(pivot).setZero();
}

}  // namespace concord::relative
