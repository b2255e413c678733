#pragma once

#include <optional>

#include "common/types.h"

/// Decompositions of dense matrices of any size, compiled once in decompositions.cpp: Eigen's templates for them take
/// longer to compile than all that a source says itself. They allocate memory: for fixed sizes on hot paths use Eigen's
/// own. Where the classes themselves are needed (thresholds, permutations), including this header keeps their largest
/// parts from being compiled anew.
extern template class Eigen::ColPivHouseholderQR<concord::MatX>;
extern template class Eigen::HouseholderQR<concord::MatX>;
extern template class Eigen::JacobiSVD<concord::MatX>;
extern template Eigen::LLT<concord::MatX>& Eigen::LLT<concord::MatX>::compute(const Eigen::EigenBase<concord::MatX>&);

namespace concord {

/// x (columns of A x columns of B) that solves A x = B, for a regular square A: partial pivoting.
MatX solve_square(const MatX& A, const MatX& B);
/// The same by complete pivoting: a solution as well if A lacks rank and B has none of what A does not reach.
MatX solve_by_complete_pivoting(const MatX& A, const MatX& B);
/// x with which A x comes closest to B; if A lacks rank, one of them.
MatX least_squares(const MatX& A, const MatX& B);
/// The same of factors that a threshold may cut off.
VecX least_squares(const Eigen::ColPivHouseholderQR<MatX>& factors, const VecX& b);
/// The smallest of the x with which A x comes closest to B. Pivots below `threshold` of the largest count as zero;
/// without one, those of round-off.
MatX smallest_least_squares(const MatX& A, const MatX& B, std::optional<double> threshold = {});
/// A = U diag(sigma) V^T, sigma falling; U and V square.
struct Svd {
  VecX sigma;
  MatX U;
  MatX V;
};
/// By LAPACK's divide and conquer, which is the fastest for many rows, and compiles in no time; of some matrices with
/// equal singular values Eigen 3.4's gives wrong vectors. What it does not decompose is left to rotations; not numbers
/// where A holds any.
Svd svd_of(const MatX& A);
/// Columns that span what A maps to zero; one column of zeros if there is nothing.
MatX kernel_of(const MatX& A);
/// Not numbers where A is singular.
Eigen::MatrixXcd inverse_of(const Eigen::MatrixXcd& A);

/// As many orthonormal columns as A has, spanning the same if these are independent.
MatX orthonormal_columns(const MatX& A);
/// A square orthogonal matrix; its first columns are orthonormal_columns(A).
MatX orthogonal_completion(const MatX& A);

/// The orthogonal factor of A P = Q R, square; Q x in place; Q^T B.
MatX orthogonal_factor(const Eigen::ColPivHouseholderQR<MatX>& factors);
void apply_orthogonal_factor(const Eigen::ColPivHouseholderQR<MatX>& factors, VecX& x);
MatX apply_transposed_factor(const Eigen::HouseholderQR<MatX>& factors, const MatX& B);

/// Largest first; none of an empty matrix.
VecX singular_values(const MatX& A);

/// Eigenvalues in ascending order, unit eigenvectors as columns.
struct SymmetricEigenpairs {
  VecX values;
  MatX vectors;
};
/// Of a symmetric A; its lower triangle is read.
SymmetricEigenpairs symmetric_eigenpairs(const MatX& A);
VecX symmetric_eigenvalues(const MatX& A);
/// A x = lambda B x with symmetric A and x^T B x = 1; nothing unless B is positive definite.
std::optional<SymmetricEigenpairs> symmetric_eigenpairs(const MatX& A, const MatX& B);

struct GeneralEigenpairs {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors;
};
/// Of any square A, which LAPACK balances first; not numbers if it finds none.
GeneralEigenpairs eigenpairs(const MatX& A);

}  // namespace concord
