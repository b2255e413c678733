#pragma once

#include <vector>

#include "common/types.h"
#include "relative/bodies/indices.h"

/// Which closure rows are independent in a pose.
namespace concord::relative {

/// Rows of Lambda = Phi_u Mbar^-1 Phi_u^T that are independent in one pose, in ascending order, and the factors by
/// which each of its rows is scaled to unit diagonal: zero for one that vanishes.
struct IndependentRows {
  std::vector<RowIndex> rows;
  VecX scale;
  /// How much each row weighs beside others: 1, but less for one that is small, which round-off spoils first: by the
  /// square of its size over that of the largest, in the machine's units.
  VecX weight;

  explicit IndependentRows(Eigen::Index n_rows = 0) : scale(VecX::Zero(n_rows)), weight(VecX::Zero(n_rows)) {}
  [[nodiscard]] bool hold(RowIndex row) const;
  /// The least weight of the rows that are held; 1 without any.
  [[nodiscard]] double least_weight() const;
};

/// The factors and weights of all rows, by which units do not weigh, from the diagonal of Lambda; `units`: the size of
/// one unit of each.
void scale_rows(const VecX& diagonal, const VecX& units, IndependentRows& rows);

/// Chooses rows by a pose alone. All memory is laid out at construction.
class RowChoice {
 public:
  explicit RowChoice(Eigen::Index n_rows) : rest_(MatX::Zero(n_rows, n_rows)) {}

  /// Chooses as many rows as are independent in a general pose, by elimination in the scaled Lambda: the first in order
  /// that keep enough of their own, by their weight, beside those taken, so that round-off does not choose between rows
  /// that are as good. False if there are too few. `chosen` has its factors and weights.
  [[nodiscard]] bool choose(const MatX& Lambda, int rank, IndependentRows& chosen);

 private:
  bool take(const MatX& Lambda, int rank, bool by_weight, IndependentRows& chosen);
  void take_off(RowIndex independent);

  MatX rest_;  // of Lambda scaled to unit diagonal, beside the rows taken
};

}  // namespace concord::relative
