#include "cartesian/rank/sparse_qr.h"

#include <algorithm>
#include <limits>
#include <new>

#ifdef CONCORD_GPL
#include <Eigen/SPQRSupport>
#include <SuiteSparseQR.hpp>
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

#ifdef CONCORD_GPL
/// Eigen's interface to SuiteSparseQR orders anew for each matrix.
class ShortestSolver::Factors {
 public:
  explicit Factors(SparseMatrix& pattern) {
    cholmod_l_start(&common_);
    constexpr int kFindsRank = 1;
    cholmod_sparse view = Eigen::viewAsCholmod(pattern);
    qr_ = SuiteSparseQR_symbolic<double>(SPQR_ORDERING_DEFAULT, kFindsRank, &view, &common_);
  }
  ~Factors() {
    if (qr_ != nullptr) SuiteSparseQR_free(&qr_, &common_);
    cholmod_l_finish(&common_);
  }
  Factors(const Factors&) = delete;
  Factors& operator=(const Factors&) = delete;

  void factorize(SparseMatrix& matrix, double tolerance) {
    cholmod_sparse view = Eigen::viewAsCholmod(matrix);
    if (qr_ == nullptr || SuiteSparseQR_numeric(tolerance, &view, qr_, &common_) == 0) throw std::bad_alloc();
  }

  [[nodiscard]] Eigen::Index rank() const { return qr_->rank; }

  VecX solve(VecX b) {
    cholmod_dense right_side = Eigen::viewAsCholmod(b);
    cholmod_dense* in_Q = SuiteSparseQR_solve(SPQR_RTX_EQUALS_ETB, qr_, &right_side, &common_);
    cholmod_dense* found = in_Q == nullptr ? nullptr : SuiteSparseQR_qmult(SPQR_QX, qr_, in_Q, &common_);
    cholmod_l_free_dense(&in_Q, &common_);
    if (found == nullptr) throw std::bad_alloc();
    VecX x = Eigen::Map<const VecX>(static_cast<const double*>(found->x), static_cast<Eigen::Index>(found->nrow));
    cholmod_l_free_dense(&found, &common_);
    return x;
  }

 private:
  cholmod_common common_{};
  SuiteSparseQR_factorization<double>* qr_ = nullptr;
};
#else
class ShortestSolver::Factors {
 public:
  explicit Factors(SparseMatrix& pattern) { qr_.analyzePattern(pattern); }

  void factorize(SparseMatrix& matrix, double tolerance) {
    qr_.setPivotThreshold(std::max(tolerance, std::numeric_limits<double>::min()));
    qr_.factorize(matrix);
    if (qr_.info() != Eigen::Success) throw std::bad_alloc();
  }

  [[nodiscard]] Eigen::Index rank() const { return qr_.rank(); }

  VecX solve(const VecX& b) {
    const Eigen::Index rank = qr_.rank();
    const auto indices = qr_.colsPermutation().indices();
    VecX in_Q = VecX::Zero(qr_.rows());
    for (Eigen::Index k = 0; k < rank; ++k) in_Q(k) = b(indices(k));
    const SparseMatrix R_transposed = SparseMatrix(sorted(qr_.matrixR()).topLeftCorner(rank, rank)).transpose();
    VecX y = in_Q.head(rank);
    R_transposed.triangularView<Eigen::Lower>().solveInPlace(y);
    in_Q.head(rank) = y;
    return qr_.matrixQ() * in_Q;
  }

 private:
  Factorization qr_;
};
#endif

ShortestSolver::ShortestSolver() = default;
ShortestSolver::~ShortestSolver() = default;

ShortestSolution ShortestSolver::solve(const SparseMatrix& A, const VecX& b, double tolerance) {
  constexpr double kHardlyAnother = 1e-10;
  const auto values = [](const SparseMatrix& matrix) {
    return Eigen::Map<const VecX>(matrix.valuePtr(), matrix.nonZeros());
  };
  const auto has_pattern_of_last = [&] {
    return A.rows() == matrix_.rows() && A.cols() == matrix_.cols() && A.nonZeros() == matrix_.nonZeros() &&
           std::equal(A.outerIndexPtr(), A.outerIndexPtr() + A.outerSize() + 1, matrix_.outerIndexPtr()) &&
           std::equal(A.innerIndexPtr(), A.innerIndexPtr() + A.nonZeros(), matrix_.innerIndexPtr());
  };
  if (A.nonZeros() == 0) return {VecX::Zero(A.rows()), 0};
  const bool is_known = factors_ != nullptr && has_pattern_of_last();
  if (!is_known || !((values(A) - values(matrix_)).norm() <= kHardlyAnother * values(A).norm())) {
    SparseMatrix next = A;
    matrix_ = SparseMatrix();  // until the next is factorized
    if (!is_known) factors_ = std::make_unique<Factors>(next);
    factors_->factorize(next, tolerance);
    matrix_.swap(next);
  }
  if (factors_->rank() == 0) return {VecX::Zero(A.rows()), 0};
  return {factors_->solve(b), factors_->rank()};
}

}  // namespace concord::cartesian
