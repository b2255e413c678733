#include "cartesian/row_choice.h"

#include <utility>

#include "cartesian/rank.h"
#include "common/decompositions.h"

namespace concord::cartesian {

namespace {

constexpr double kWellIndependent = 1e-2;   // what others leave of a row that is well independent of them
constexpr double kLeastIndependent = 1e-6;  // the same, where rows are exchanged or none can be left over

/// Rows that hold for positions, where there are others; nullptr else.
const std::vector<bool>* rows_that_go_first(const Constraints& constraints, std::vector<bool>& rows) {
  if (!constraints.has_nonholonomic_rows()) return nullptr;
  for (const RowIndex row : constraints.rows()) rows.push_back(constraints.holds_positions(row));
  return &rows;
}

/// Whether a sparse QR shows so: where no row may be left over there is none to exchange.
bool are_all_independent(const SparseMatrix& matrix) {
  const RowSelection selection = select_rows(matrix.transpose(), nullptr, kLeastIndependent);
  return selection.live == matrix.rows() && selection.smallest_live >= kLeastIndependent;
}

}  // namespace

ScaledJacobian scaled_jacobian(const Equations& equations) {
  const MovingConstraints& constraints = equations.moving_constraints();
  const Layout& layout = equations.layout();
  const VecX& units = equations.units();
  ScaledJacobian scaled;
  scaled.row_scale = equations.row_sizes().unaryExpr([](double size) { return size > 0.0 ? 1.0 / size : 1.0; });
  std::vector<Eigen::Triplet<double, SparseIndex>> entries;
  for (const RowBlock& block : constraints.blocks()) {
    const Eigen::Ref<const MatX> Phi_Y_transposed = constraints.columns(block);
    for (int own = 0; own < block.n_rows; ++own) {
      const int row = block.row(own).value;
      for (int c = 0; c < layout.size_Y(block.body); ++c) {
        const int column = layout.first_Y(block.body) + c;
        const double value = Phi_Y_transposed(c, own) * units(column) * scaled.row_scale(row);
        entries.emplace_back(row, column, value);
      }
    }
  }
  scaled.matrix = SparseMatrix(constraints.n_rows(), layout.n_Y());
  scaled.matrix.setFromTriplets(entries.begin(), entries.end());
  return scaled;
}

RowChoice choose_rows(const Equations& equations, int expected) {
  const SparseMatrix matrix = scaled_jacobian(equations).matrix;
  if (expected == matrix.rows() && expected > kDenseRows && are_all_independent(matrix)) {
    return {expected, std::vector<bool>(matrix.rows(), true)};
  }
  std::vector<bool> rows;
  const std::vector<bool>* goes_first = rows_that_go_first(equations.constraints(), rows);
  if (matrix.rows() > kDenseRows) {
    const SparseMatrix transposed = matrix.transpose();
    RowSelection selection = select_rows(transposed, goes_first, kWellIndependent);
    // A sparse QR may choose rows that together are nearly dependent, with which velocities do not close to round-off.
    const bool may_be_exchanged = goes_first == nullptr && matrix.rows() <= kMostDenseRows;
    if (may_be_exchanged && !(selection.live == expected && selection.smallest_live >= kWellIndependent)) {
      selection = select_well(transposed, kLeastIndependent);
    }
    if (selection.live == expected) {
      RowChoice choice{expected, std::vector<bool>(matrix.rows(), false)};
      for (int k = 0; k < expected; ++k) choice.independent[selection.order[k]] = true;
      return choice;
    }
  }
  RankDecision decision = decide_rank(matrix, goes_first);
  return {decision.rank, std::move(decision.independent)};
}

RowChoice choose_rows_beside(const Equations& equations, int expected) {
  RowChoice choice = choose_rows(equations, expected);
  if (choice.rank <= expected) return choice;
  constexpr double kHigher = 10.0;
  const SparseMatrix transposed = scaled_jacobian(equations).matrix.transpose();
  std::vector<bool> rows;
  const std::vector<bool>* goes_first = rows_that_go_first(equations.constraints(), rows);
  double tolerance = kRankThreshold;
  RowSelection selection = select_rows(transposed, goes_first, tolerance);
  while (selection.live > expected) {
    tolerance *= kHigher;
    RowSelection fewer = select_rows(transposed, goes_first, tolerance);
    if (fewer.live < expected) break;
    selection = std::move(fewer);
  }
  choice = {expected, std::vector<bool>(static_cast<std::size_t>(transposed.cols()), false)};
  for (int k = 0; k < expected; ++k) choice.independent[selection.order[k]] = true;
  return choice;
}

std::vector<bool> independent_rows(const Equations& equations) { return choose_rows(equations, -1).independent; }

MatX permitted_velocities(const Equations& equations) {
  const Layout& layout = equations.layout();
  const MatX transposed = MatX(scaled_jacobian(equations).matrix).transpose();
  MatX null_space = MatX::Identity(layout.n_Y(), layout.n_Y());
  if (transposed.cols() > 0) {
    Eigen::ColPivHouseholderQR<MatX> qr(transposed);
    qr.setThreshold(kRankThreshold);
    null_space = orthogonal_factor(qr).rightCols(layout.n_Y() - qr.rank());
  }
  null_space = equations.units().asDiagonal() * null_space;
  const double length = equations.model().length_scale();
  VecX sizes = VecX::Ones(layout.n_Y());
  for (const BodyIndex i : layout.moving_bodies()) {
    null_space.middleRows<3>(layout.first_Y(i)) /= length;
    layout.adot(sizes, i) = layout.adot(equations.units(), i);
  }
  return sizes.asDiagonal() * orthonormal_columns(sizes.cwiseInverse().asDiagonal() * null_space);
}

}  // namespace concord::cartesian
