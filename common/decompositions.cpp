#include "common/decompositions.h"

#include <algorithm>

template class Eigen::BDCSVD<concord::MatX>;
template class Eigen::ColPivHouseholderQR<concord::MatX>;
template class Eigen::HouseholderQR<concord::MatX>;
template class Eigen::JacobiSVD<concord::MatX>;

namespace concord {

namespace {

bool gives_back(const Svd& found, const MatX& A) {
  constexpr double kRoundOff = 1e-13;
  MatX rest = A * found.V;
  rest.leftCols(found.sigma.size()) -= found.U.leftCols(found.sigma.size()) * found.sigma.asDiagonal();
  const double least = kRoundOff * std::max(found.sigma(0), 1.0);
  if (!(rest.cwiseAbs().maxCoeff() <= least)) return false;
  const Eigen::Index left_over = A.rows() - found.sigma.size();
  return left_over == 0 || (found.U.rightCols(left_over).transpose() * A).cwiseAbs().maxCoeff() <= least;
}

}  // namespace

Svd svd_of(const MatX& A) {
  constexpr Eigen::Index kManyRows = 24;
  constexpr unsigned kAll = Eigen::ComputeFullU | Eigen::ComputeFullV;
  if (A.rows() >= kManyRows) {
    const Eigen::BDCSVD<MatX> svd(A, kAll);
    Svd found{svd.singularValues(), svd.matrixU(), svd.matrixV()};
    if (gives_back(found, A)) return found;
  }
  const Eigen::JacobiSVD<MatX> svd(A, kAll);
  return {svd.singularValues(), svd.matrixU(), svd.matrixV()};
}

MatX solve_square(const MatX& A, const MatX& B) { return A.partialPivLu().solve(B); }

MatX solve_by_complete_pivoting(const MatX& A, const MatX& B) { return A.fullPivLu().solve(B); }

MatX least_squares(const MatX& A, const MatX& B) { return A.colPivHouseholderQr().solve(B); }

MatX smallest_least_squares(const MatX& A, const MatX& B, std::optional<double> threshold) {
  Eigen::CompleteOrthogonalDecomposition<MatX> factors;
  if (threshold) factors.setThreshold(*threshold);
  return factors.compute(A).solve(B);
}

MatX kernel_of(const MatX& A) { return A.fullPivLu().kernel(); }

Eigen::MatrixXcd inverse_of(const Eigen::MatrixXcd& A) { return A.partialPivLu().inverse(); }

MatX orthonormal_columns(const MatX& A) {
  const Eigen::HouseholderQR<MatX> factors(A);
  return factors.householderQ() * MatX::Identity(A.rows(), A.cols());
}

MatX orthogonal_completion(const MatX& A) { return Eigen::HouseholderQR<MatX>(A).householderQ(); }

VecX singular_values(const MatX& A) { return Eigen::JacobiSVD<MatX>(A).singularValues(); }

SymmetricEigenpairs symmetric_eigenpairs(const MatX& A) {
  const Eigen::SelfAdjointEigenSolver<MatX> solution(A);
  return {solution.eigenvalues(), solution.eigenvectors()};
}

VecX symmetric_eigenvalues(const MatX& A) {
  return Eigen::SelfAdjointEigenSolver<MatX>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

std::optional<SymmetricEigenpairs> symmetric_eigenpairs(const MatX& A, const MatX& B) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatX> solution(A, B);
  if (solution.info() != Eigen::Success) return std::nullopt;
  return SymmetricEigenpairs{solution.eigenvalues(), solution.eigenvectors()};
}

GeneralEigenpairs eigenpairs(const MatX& A) {
  const Eigen::EigenSolver<MatX> solution(A);
  return {solution.eigenvalues(), solution.eigenvectors()};
}

}  // namespace concord
