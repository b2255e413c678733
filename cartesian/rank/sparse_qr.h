#pragma once

#include <Eigen/Sparse>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/types.h"

/// Rank-revealing QR factorization of a sparse matrix.
namespace concord::cartesian {

/// Indices as SuiteSparse has them.
using SparseIndex = std::int64_t;
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, SparseIndex>;

/// A P = Q R. A column of which those before it leave no more than a tolerance is left over: the independent columns
/// come first. By SuiteSparseQR (Davis, Algorithm 915, 2011), or by Eigen's sparse QR in a program built without
/// CONCORD_GPL.
struct SparseQr {
  Eigen::Index rank = 0;            // number of independent columns
  std::vector<Eigen::Index> order;  // of the columns of A
  SparseMatrix R;                   // upper triangular: the independent columns, then what is left over of the others
};
/// Throws std::bad_alloc where the memory does not suffice, as the functions below.
SparseQr sparse_qr(const SparseMatrix& matrix, double tolerance);

/// For each column b of B the x with which A x comes closest to b. The columns of A are independent.
MatX sparse_least_squares(const SparseMatrix& matrix, const MatX& B);

/// The shortest x with A^T x = b, if no column of A is left over; otherwise an x that obeys the rows of A^T which are
/// not.
struct ShortestSolution {
  VecX x;
  Eigen::Index rank = 0;  // number of rows that x obeys
};

/// Solves for one matrix after the other. One of the last one's pattern is not ordered anew, and one that is hardly
/// another, as where Newton's method has arrived, is solved with the last one's factors.
class ShortestSolver {
 public:
  ShortestSolver();
  ~ShortestSolver();
  ShortestSolver(const ShortestSolver&) = delete;
  ShortestSolver& operator=(const ShortestSolver&) = delete;

  /// A in compressed form.
  ShortestSolution solve(const SparseMatrix& A, const VecX& b, double tolerance);

 private:
  class Factors;
  std::unique_ptr<Factors> factors_;  // of matrix_
  SparseMatrix matrix_;
};

}  // namespace concord::cartesian
