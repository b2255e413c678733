#include "cartesian/rank/sparse_qr.h"

#include <algorithm>
#include <limits>
#include <new>
#include <utility>

#ifdef CONCORD_GPL
#include <Eigen/SPQRSupport>
#include <type_traits>
#endif

namespace concord::cartesian {

namespace {

#ifdef CONCORD_GPL
static_assert(std::is_same_v<SparseIndex, SuiteSparse_long>);
using Factorization = Eigen::SPQR<SparseMatrix>;
#else
using Factorization = Eigen::SparseQR<SparseMatrix, Eigen::COLAMDOrdering<SparseIndex> >;
#endif

/// With a tolerance of zero Eigen would keep columns of which nothing is left.
void factorize(Factorization& qr, const SparseMatrix& matrix, double tolerance) {
  SparseMatrix compressed = matrix;
  compressed.makeCompressed();
  qr.setPivotThreshold(std::max(tolerance, std::numeric_limits<double>::min()));
  qr.compute(compressed);
  if (qr.info() != Eigen::Success) throw std::bad_alloc();
}

/// Entries of each column in order of their rows, which Eigen's factorization leaves as they come.
SparseMatrix sorted(const SparseMatrix& matrix) { return SparseMatrix(matrix.transpose()).transpose(); }

}  // namespace

SparseQr sparse_qr(const SparseMatrix& matrix, double tolerance) {
  Factorization qr;
  factorize(qr, matrix, tolerance);
  const auto indices = qr.colsPermutation().indices();
  return {qr.rank(), {indices.begin(), indices.end()}, sorted(qr.matrixR())};
}

MatX sparse_least_squares(const SparseMatrix& matrix, const MatX& B) {
  Factorization qr;
  factorize(qr, matrix, 0.0);
  MatX X(matrix.cols(), B.cols());
  for (Eigen::Index k = 0; k < B.cols(); ++k) {  // SuiteSparseQR's interface in Eigen solves for one vector at a time
    const VecX b = B.col(k);
    X.col(k) = qr.solve(b);
  }
  return X;
}

ShortestSolution sparse_shortest(const SparseMatrix& matrix, const VecX& b, double tolerance) {
  Factorization qr;
  factorize(qr, matrix, tolerance);
  const Eigen::Index rank = qr.rank();
  if (rank == 0) return {VecX::Zero(matrix.rows()), 0};
  const auto indices = qr.colsPermutation().indices();
  VecX y(rank);
  for (Eigen::Index k = 0; k < rank; ++k) y(k) = b(indices(k));
  const SparseMatrix R_transposed = SparseMatrix(sorted(qr.matrixR()).topLeftCorner(rank, rank)).transpose();
  R_transposed.triangularView<Eigen::Lower>().solveInPlace(y);
  VecX in_Q = VecX::Zero(matrix.rows());
  in_Q.head(rank) = y;
  VecX x = qr.matrixQ() * in_Q;
  return {std::move(x), rank};
}

}  // namespace concord::cartesian
