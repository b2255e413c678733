#include "cartesian/sparse_lu.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "common/error.h"

namespace concord::cartesian {

SparseLu::SparseLu(std::vector<int> column_starts, std::vector<int> row_indices, Pattern pattern)
    : column_starts_(std::move(column_starts)),
      row_indices_(std::move(row_indices)),
      values_(row_indices_.size(), 0.0),
      right_side_(VecX::Zero(size())),
      residual_(VecX::Zero(size())) {
  klu_defaults(&common_);
  common_.btf = pattern == Pattern::general ? 1 : 0;
  if (size() == 0) return;
  symbolic_ = klu_analyze(size(), column_starts_.data(), row_indices_.data(), &common_);
  if (symbolic_ == nullptr) throw SolverError("cartesian: klu_analyze found the equations structurally singular");
}

SparseLu::~SparseLu() {
  if (numeric_ != nullptr) klu_free_numeric(&numeric_, &common_);
  if (symbolic_ != nullptr) klu_free_symbolic(&symbolic_, &common_);
}

int SparseLu::find(int row, int column) const {
  const auto first = row_indices_.begin() + column_starts_[column];
  const auto last = row_indices_.begin() + column_starts_[column + 1];
  const auto found = std::lower_bound(first, last, row);
  if (found == last || *found != row) throw std::logic_error("SparseLu::find: entry outside the frozen pattern");
  return static_cast<int>(found - row_indices_.begin());
}

bool SparseLu::factor() {
  if (size() == 0) return true;
  if (numeric_ != nullptr) klu_free_numeric(&numeric_, &common_);
  numeric_ = klu_factor(column_starts_.data(), row_indices_.data(), values_.data(), symbolic_, &common_);
  return numeric_ != nullptr && common_.status == KLU_OK;
}

bool SparseLu::refactor() {
  if (size() == 0) return true;
  if (numeric_ == nullptr) return factor();
  const int done =
      klu_refactor(column_starts_.data(), row_indices_.data(), values_.data(), symbolic_, numeric_, &common_);
  return (done != 0 && common_.status == KLU_OK) || factor();
}

void SparseLu::solve(VecX& x) {
  if (size() > 0) klu_solve(symbolic_, numeric_, size(), 1, x.data(), &common_);
}

void SparseLu::subtract_product(const VecX& x, VecX& y) const {
  for (int column = 0; column < size(); ++column) {
    const double factor_x = x(column);
    for (int k = column_starts_[column]; k < column_starts_[column + 1]; ++k) {
      y(row_indices_[k]) -= values_[k] * factor_x;
    }
  }
}

void SparseLu::write_residual(const VecX& x) {
  residual_ = right_side_;
  subtract_product(x, residual_);
}

bool SparseLu::solve_refined(VecX& x, double good_enough) {
  constexpr double kAllowed = 1e-9;  // pivots gone bad show far above, round-off far below
  constexpr int kMaxRounds = 2;
  right_side_ = x;
  const double size = 1e-300 + right_side_.lpNorm<Eigen::Infinity>();
  solve(x);
  write_residual(x);
  for (int round = 0; round < kMaxRounds && residual_.lpNorm<Eigen::Infinity>() > good_enough * size; ++round) {
    solve(residual_);
    x += residual_;
    write_residual(x);
  }
  return residual_.lpNorm<Eigen::Infinity>() <= kAllowed * size;
}

}  // namespace concord::cartesian
