#include "common/decompositions.h"

#include <algorithm>
#include <complex>
#include <cstddef>
#include <limits>

template class Eigen::ColPivHouseholderQR<concord::MatX>;
template class Eigen::HouseholderQR<concord::MatX>;
template class Eigen::JacobiSVD<concord::MatX>;
template Eigen::LLT<concord::MatX>& Eigen::LLT<concord::MatX>::compute(const Eigen::EigenBase<concord::MatX>&);

/// Of LAPACK: singular values by divide and conquer, eigenvalues of a general matrix, which it balances, and complex
/// equations. Last arguments are the lengths of texts before.
extern "C" {
void dgesdd_(const char* job, const int* m, const int* n, double* a, const int* lda, double* s, double* u,
             const int* ldu, double* vt, const int* ldvt, double* work, const int* lwork, int* iwork, int* info,
             std::size_t length_of_job);
void dgeev_(const char* left, const char* right, const int* n, double* a, const int* lda, double* wr, double* wi,
            double* vl, const int* ldvl, double* vr, const int* ldvr, double* work, const int* lwork, int* info,
            std::size_t length_of_left, std::size_t length_of_right);
void zgesv_(const int* n, const int* columns, std::complex<double>* a, const int* lda, int* pivots,
            std::complex<double>* b, const int* ldb, int* info);
}

namespace concord {

namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

Svd by_rotations(const MatX& A) {
  const Eigen::JacobiSVD<MatX> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.singularValues(), svd.matrixU(), svd.matrixV()};
}

/// Sizes of LAPACK, whose matrices are stored by columns as ours are.
int lapack_size(Eigen::Index n) { return static_cast<int>(n); }

/// Calls a routine of LAPACK twice: to ask how much memory it wants, and to let it work; true if it succeeded.
/// `routine` takes the memory, its size (-1: ask) and where to write how it ended.
template <typename Routine>
bool run_lapack(const Routine& routine) {
  int info = 0;
  int size = -1;
  double wanted = 1.0;
  routine(&wanted, &size, &info);
  if (info != 0) return false;
  VecX memory(static_cast<Eigen::Index>(wanted));
  size = lapack_size(memory.size());
  routine(memory.data(), &size, &info);
  return info == 0;
}

}  // namespace

Svd svd_of(const MatX& A) {
  // LAPACK ends the program on empty matrices and may not end on numbers that are not finite.
  if (!A.allFinite()) {
    const auto nothing = [](Eigen::Index m, Eigen::Index n) { return MatX::Constant(m, n, kNotANumber); };
    return {nothing(std::min(A.rows(), A.cols()), 1), nothing(A.rows(), A.rows()), nothing(A.cols(), A.cols())};
  }
  if (A.size() == 0) {
    return {VecX(0), MatX::Identity(A.rows(), A.rows()), MatX::Identity(A.cols(), A.cols())};
  }
  MatX copy = A;
  const int rows = lapack_size(A.rows());
  const int columns = lapack_size(A.cols());
  MatX transposed(columns, columns);
  Svd found{VecX(std::min(rows, columns)), MatX(rows, rows), MatX()};
  Eigen::VectorXi order(8 * found.sigma.size());
  const bool is_found = run_lapack([&](double* memory, const int* size, int* info) {
    dgesdd_("A", &rows, &columns, copy.data(), &rows, found.sigma.data(), found.U.data(), &rows, transposed.data(),
            &columns, memory, size, order.data(), info, 1);
  });
  if (!is_found) return by_rotations(A);
  found.V = transposed.transpose();
  return found;
}

MatX solve_square(const MatX& A, const MatX& B) { return A.partialPivLu().solve(B); }

MatX solve_by_complete_pivoting(const MatX& A, const MatX& B) { return A.fullPivLu().solve(B); }

MatX least_squares(const MatX& A, const MatX& B) { return A.colPivHouseholderQr().solve(B); }

VecX least_squares(const Eigen::ColPivHouseholderQR<MatX>& factors, const VecX& b) { return factors.solve(b); }

MatX smallest_least_squares(const MatX& A, const MatX& B, std::optional<double> threshold) {
  Eigen::CompleteOrthogonalDecomposition<MatX> factors;
  if (threshold) factors.setThreshold(*threshold);
  return factors.compute(A).solve(B);
}

MatX kernel_of(const MatX& A) { return A.fullPivLu().kernel(); }

Eigen::MatrixXcd inverse_of(const Eigen::MatrixXcd& A) {
  if (A.size() == 0 || !A.allFinite()) return Eigen::MatrixXcd::Constant(A.rows(), A.cols(), kNotANumber);
  const int n = lapack_size(A.rows());
  Eigen::MatrixXcd factors = A;
  Eigen::MatrixXcd inverse = Eigen::MatrixXcd::Identity(n, n);
  Eigen::VectorXi pivots(n);
  int info = 0;
  zgesv_(&n, &n, factors.data(), &n, pivots.data(), inverse.data(), &n, &info);
  if (info != 0) inverse.setConstant(kNotANumber);
  return inverse;
}

MatX orthonormal_columns(const MatX& A) {
  const Eigen::HouseholderQR<MatX> factors(A);
  return factors.householderQ() * MatX::Identity(A.rows(), A.cols());
}

MatX orthogonal_completion(const MatX& A) { return Eigen::HouseholderQR<MatX>(A).householderQ(); }

MatX orthogonal_factor(const Eigen::ColPivHouseholderQR<MatX>& factors) { return factors.householderQ(); }

void apply_orthogonal_factor(const Eigen::ColPivHouseholderQR<MatX>& factors, VecX& x) {
  x.applyOnTheLeft(factors.householderQ());
}

MatX apply_transposed_factor(const Eigen::HouseholderQR<MatX>& factors, const MatX& B) {
  return factors.householderQ().transpose() * B;
}

VecX singular_values(const MatX& A) {
  return A.size() == 0 ? VecX() : VecX(Eigen::JacobiSVD<MatX>(A).singularValues());
}

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
  const int n = lapack_size(A.rows());
  GeneralEigenpairs pairs{Eigen::VectorXcd::Constant(n, kNotANumber), Eigen::MatrixXcd::Constant(n, n, kNotANumber)};
  if (n == 0 || !A.allFinite()) return pairs;  // on which LAPACK ends the program
  MatX copy = A;
  VecX real(n);
  VecX imaginary(n);
  MatX vectors(n, n);  // the real and the imaginary part of a pair beside each other
  const int none = 1;
  const bool is_found = run_lapack([&](double* memory, const int* size, int* info) {
    dgeev_("N", "V", &n, copy.data(), &n, real.data(), imaginary.data(), nullptr, &none, vectors.data(), &n, memory,
           size, info, 1, 1);
  });
  if (!is_found) return pairs;
  pairs.values.real() = real;
  pairs.values.imag() = imaginary;
  pairs.vectors = vectors.cast<std::complex<double>>();
  for (Eigen::Index k = 0; k + 1 < n; ++k) {
    if (imaginary(k) <= 0.0) continue;
    pairs.vectors.col(k).imag() = vectors.col(k + 1);
    pairs.vectors.col(k + 1) = pairs.vectors.col(k).conjugate();
  }
  return pairs;
}

}  // namespace concord
