#include "relative/independent_rows.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace concord::relative {

namespace {

/// Diagonal entries of Lambda in machine units below this part of the largest are squares of round-off: the row
/// vanishes.
constexpr double kVanishing = 1e-22;

/// The square of the sine that a row must have against the rows chosen before, in rounds.
constexpr std::array kLeastOwnParts{0.1, 0.01, 1e-4, 1e-8, 1e-12, 0.0};

}  // namespace

bool IndependentRows::hold(RowIndex row) const { return std::binary_search(rows.begin(), rows.end(), row); }

void scale_rows(const MatX& Lambda, const VecX& units, VecX& scale) {
  const Eigen::Index n = Lambda.rows();
  double largest = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) largest = std::max(largest, Lambda(i, i) / (units(i) * units(i)));
  for (Eigen::Index i = 0; i < n; ++i) {
    const bool vanishes = !(Lambda(i, i) / (units(i) * units(i)) > kVanishing * largest);
    scale(i) = vanishes ? 0.0 : 1.0 / std::sqrt(Lambda(i, i));
  }
}

bool RowChoice::choose(const MatX& Lambda, int rank, IndependentRows& chosen) {
  std::vector<RowIndex>& rows = chosen.rows;
  rest_.noalias() = chosen.scale.asDiagonal() * Lambda * chosen.scale.asDiagonal();
  rows.clear();
  for (const double least : kLeastOwnParts) {
    for (const RowIndex row : upward<RowIndex>(Lambda.rows())) {
      if (static_cast<int>(rows.size()) == rank) break;
      if (!(rest_(row.value(), row.value()) > least)) continue;
      rows.push_back(row);
      take_off(row);
    }
  }
  if (static_cast<int>(rows.size()) < rank) return false;
  std::sort(rows.begin(), rows.end());
  return true;
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
