#include "cartesian/dynamics/sparse_lu.h"

#include <klu.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "common/error.h"

namespace concord::cartesian {

namespace {

/// The power of two that brings a number between 1/2 and 1; 1 for what has no size.
double power_to_one(double size) {
  if (!(size > 0.0) || !std::isfinite(size)) return 1.0;
  int exponent = 0;
  (void)std::frexp(size, &exponent);
  return std::ldexp(1.0, -exponent);
}

/// The power of two whose square brings a number between 1/2 and 2.
double root_to_one(double size) {
  int exponent = 0;
  (void)std::frexp(size, &exponent);
  return std::ldexp(1.0, -(exponent >> 1));
}

}  // namespace

/// What KLU keeps between its calls.
struct SparseLu::KluHandles {
  klu_common common{};
  klu_symbolic* symbolic = nullptr;
  klu_numeric* numeric = nullptr;

  KluHandles() { klu_defaults(&common); }
  ~KluHandles() {
    if (numeric != nullptr) klu_free_numeric(&numeric, &common);
    if (symbolic != nullptr) klu_free_symbolic(&symbolic, &common);
  }
  KluHandles(const KluHandles&) = delete;
  KluHandles& operator=(const KluHandles&) = delete;
};

SparseLu::SparseLu(std::vector<int> column_starts, std::vector<int> row_indices, Pattern pattern)
    : column_starts_(std::move(column_starts)),
      row_indices_(std::move(row_indices)),
      values_(row_indices_.size(), 0.0),
      scaled_(row_indices_.size(), 0.0),
      least_diagonal_(VecX::Zero(size())),
      pattern_(pattern),
      row_scales_(VecX::Ones(size())),
      column_scales_(VecX::Ones(size())),
      klu_(std::make_unique<KluHandles>()),
      right_side_(VecX::Zero(size())),
      solution_(VecX::Zero(size())),
      residual_(VecX::Zero(size())),
      terms_(VecX::Zero(size())),
      rounding_(size(), 0.0) {
  for (int column = 0; column < size(); ++column) {
    const auto first = row_indices_.begin() + column_starts_[column];
    const auto last = row_indices_.begin() + column_starts_[column + 1];
    const auto found = std::lower_bound(first, last, column);
    const bool is_there = found != last && *found == column;
    diagonal_.push_back(is_there ? static_cast<int>(found - row_indices_.begin()) : -1);
  }
  klu_->common.btf = pattern == Pattern::general ? 1 : 0;
  klu_->common.scale = -1;  // the matrix comes scaled, of a checked pattern: KLU neither scales nor checks again
  if (size() == 0) return;
  klu_->symbolic = klu_analyze(size(), column_starts_.data(), row_indices_.data(), &klu_->common);
  if (klu_->symbolic == nullptr) throw SolverError("cartesian: klu_analyze found the equations structurally singular");
}

SparseLu::~SparseLu() = default;

int SparseLu::find(int row, int column) const {
  const auto first = row_indices_.begin() + column_starts_[column];
  const auto last = row_indices_.begin() + column_starts_[column + 1];
  const auto found = std::lower_bound(first, last, row);
  if (found == last || *found != row) throw std::logic_error("SparseLu::find: entry outside the frozen pattern");
  return static_cast<int>(found - row_indices_.begin());
}

/// Columns with a diagonal entry by its root, the others by their largest entry after that: a saddle point matrix has
/// the inertias on its diagonal and nothing where its constraints stand.
void SparseLu::choose_symmetric_scales() {
  const auto diagonal = [&](int column) {
    const double own = diagonal_[column] >= 0 ? std::abs(values_[diagonal_[column]]) : 0.0;
    return std::max(own, least_diagonal_(column));
  };
  const auto has_diagonal = [&](int column) { return diagonal(column) > 0.0; };
  for (int column = 0; column < size(); ++column) {
    double scale = 0.0;
    if (is_idle(column)) {
      scale = 1.0;
    } else if (has_diagonal(column)) {
      scale = root_to_one(diagonal(column) / diagonal_unit_);
    }
    column_scales_(column) = scale;
  }
  for (int column = 0; column < size(); ++column) {
    if (column_scales_(column) > 0.0) continue;
    double largest = 0.0;
    for (int k = column_starts_[column]; k < column_starts_[column + 1]; ++k) {
      const int row = row_indices_[k];
      if (has_diagonal(row) && !is_idle(row)) {
        largest = std::max(largest, std::abs(values_[k]) * column_scales_(row));
      }
    }
    column_scales_(column) = -power_to_one(largest);  // the sign: has no diagonal entry
  }
  for (int column = 0; column < size(); ++column) {
    const bool is_constraint = column_scales_(column) < 0.0;
    const double scale = std::abs(column_scales_(column));
    row_scales_(column) = is_constraint ? scale : scale / diagonal_unit_;
    column_scales_(column) = is_constraint ? scale * diagonal_unit_ : scale;
    if (is_idle(column)) row_scales_(column) = column_scales_(column) = 0.0;
  }
}

void SparseLu::choose_general_scales() {
  row_scales_.setZero();
  for (int column = 0; column < size(); ++column) {
    for (int k = column_starts_[column]; k < column_starts_[column + 1]; ++k) {
      row_scales_(row_indices_[k]) = std::max(row_scales_(row_indices_[k]), std::abs(values_[k]));
    }
  }
  for (double& scale : row_scales_) scale = power_to_one(scale);
  for (int column = 0; column < size(); ++column) {
    double largest = 0.0;
    for (int k = column_starts_[column]; k < column_starts_[column + 1]; ++k) {
      largest = std::max(largest, std::abs(values_[k]) * row_scales_(row_indices_[k]));
    }
    column_scales_(column) = power_to_one(largest);
  }
  for (int place = 0; place < size(); ++place) {
    if (is_idle(place)) row_scales_(place) = column_scales_(place) = 0.0;
  }
}

void SparseLu::scale(bool anew) {
  if (anew && pattern_ == Pattern::symmetric) choose_symmetric_scales();
  if (anew && pattern_ == Pattern::general) choose_general_scales();
  for (int column = 0; column < size(); ++column) {
    const double of_column = column_scales_(column);
    for (int k = column_starts_[column]; k < column_starts_[column + 1]; ++k) {
      scaled_[k] = values_[k] * (row_scales_(row_indices_[k]) * of_column);
    }
    if (is_idle(column)) scaled_[diagonal_[column]] = 1.0;
  }
}

bool SparseLu::factor() {
  if (size() == 0) return true;
  scale(true);
  if (klu_->numeric != nullptr) klu_free_numeric(&klu_->numeric, &klu_->common);
  klu_->numeric = klu_factor(column_starts_.data(), row_indices_.data(), scaled_.data(), klu_->symbolic, &klu_->common);
  return klu_->numeric != nullptr && klu_->common.status == KLU_OK;
}

bool SparseLu::refactor() {
  if (size() == 0) return true;
  if (klu_->numeric == nullptr) return factor();
  scale(false);
  const int done = klu_refactor(column_starts_.data(), row_indices_.data(), scaled_.data(), klu_->symbolic,
                                klu_->numeric, &klu_->common);
  return (done != 0 && klu_->common.status == KLU_OK) || factor();
}

void SparseLu::solve(VecX& x) {
  if (size() == 0) return;
  x.array() *= row_scales_.array();
  klu_solve(klu_->symbolic, klu_->numeric, size(), 1, x.data(), &klu_->common);
  x.array() *= column_scales_.array();
}

void SparseLu::subtract_product(const VecX& x, VecX& y) const {
  for (int column = 0; column < size(); ++column) {
    const double factor_x = x(column);
    for (int k = column_starts_[column]; k < column_starts_[column + 1]; ++k) {
      y(row_indices_[k]) -= values_[k] * factor_x;
    }
  }
}

void SparseLu::write_rough_residual() {
  residual_ = right_side_;
  for (int column = 0; column < size(); ++column) {
    const double factor = solution_(column);
    for (int k = column_starts_[column]; k < column_starts_[column + 1]; ++k) {
      residual_(row_indices_[k]) -= scaled_[k] * factor;
    }
  }
}

void SparseLu::write_terms(const VecX& least) {
  terms_ = right_side_.cwiseAbs();
  for (int column = 0; column < size(); ++column) {
    const double at_least = least(column) > 0.0 ? least(column) / column_scales_(column) : 0.0;
    const double factor = std::max(std::abs(solution_(column)), at_least);
    for (int k = column_starts_[column]; k < column_starts_[column + 1]; ++k) {
      terms_(row_indices_[k]) += std::abs(scaled_[k]) * factor;
    }
  }
}

/// Each product and each sum with its rounding error, which are added up beside.
void SparseLu::write_exact_residual() {
  residual_ = right_side_;
  std::fill(rounding_.begin(), rounding_.end(), 0.0);
  for (int column = 0; column < size(); ++column) {
    const double factor = -solution_(column);
    for (int k = column_starts_[column]; k < column_starts_[column + 1]; ++k) {
      const double product = scaled_[k] * factor;
      double& sum = residual_(row_indices_[k]);
      const double before = sum;
      sum = before + product;
      const double added = sum - before;
      rounding_[row_indices_[k]] +=
          (before - (sum - added)) + (product - added) + std::fma(scaled_[k], factor, -product);
    }
  }
  for (int row = 0; row < size(); ++row) residual_(row) += rounding_[row];
}

void SparseLu::begin_solving(const VecX& right_side) {
  first_correction_.setZero(size());
  relative_correction_ = 0.0;
  right_side_ = right_side.cwiseProduct(row_scales_);
  solution_ = right_side_;
  solve_scaled(solution_);
}

void SparseLu::solve_scaled(VecX& x) { klu_solve(klu_->symbolic, klu_->numeric, size(), 1, x.data(), &klu_->common); }

template <class SolveScaled>
bool SparseLu::refine(double enough, const SolveScaled& solve_scaled) {
  constexpr double kFirstAllowed = 1e-2;                               // correction of the solution
  constexpr double kLeastNormal = std::numeric_limits<double>::min();  // smaller numbers have few digits
  constexpr double kFalling = 0.5;
  constexpr int kMaxRounds = 6;
  const auto largest = [](const VecX& vector) { return vector.lpNorm<Eigen::Infinity>(); };
  bool is_good = true;
  double last = HUGE_VAL;
  for (int round = 0; round < kMaxRounds && last > enough; ++round) {
    write_exact_residual();
    solve_scaled(residual_);
    const double size_of_solution = largest(solution_);
    const double correction = size_of_solution > 0.0 ? largest(residual_) / size_of_solution : 0.0;
    if (round == 0) {
      first_correction_ = residual_.cwiseProduct(column_scales_);
      relative_correction_ = correction;
      is_good = correction <= kFirstAllowed || largest(residual_) < kLeastNormal;
    }
    if (!is_good || !(correction < kFalling * last)) break;
    solution_ += residual_;
    last = last_correction_ = correction;
  }
  return is_good;
}

/// A round more than round-off of the largest asks for: the smaller ones have theirs.
bool SparseLu::refine_by_factors() {
  return refine(std::numeric_limits<double>::epsilon(), [this](VecX& rest) { solve_scaled(rest); });
}

bool SparseLu::end_solving(bool is_good, VecX& x) const {
  x = solution_.cwiseProduct(column_scales_);
  return is_good && x.allFinite();
}

bool SparseLu::improve(const VecX& right_side, VecX& x, const std::function<void(VecX&)>& solve_nearly) {
  constexpr double kEnough = 1e-10;  // the next correction is as small a part of this one as this of the solution
  if (size() == 0) return true;
  scale(false);
  last_correction_ = 0.0;
  right_side_ = right_side.cwiseProduct(row_scales_);
  const auto divide = [this](VecX& numbers, const VecX& scales) {
    for (int place = 0; place < size(); ++place) numbers(place) = is_idle(place) ? 0.0 : numbers(place) / scales(place);
  };
  solution_ = x;
  divide(solution_, column_scales_);
  const auto solve_nearly_scaled = [&](VecX& rest) {
    divide(rest, row_scales_);
    solve_nearly(rest);
    divide(rest, column_scales_);
  };
  const bool is_good = solution_.allFinite() && refine(kEnough, solve_nearly_scaled);
  return end_solving(is_good && last_correction_ <= kEnough, x);
}

double SparseLu::relative_size(const VecX& x, const VecX& y) const {
  double of_x = 0.0;
  double of_y = 0.0;
  for (int place = 0; place < size(); ++place) {
    if (is_idle(place)) continue;
    of_x = std::max(of_x, std::abs(x(place) / column_scales_(place)));
    of_y = std::max(of_y, std::abs(y(place) / column_scales_(place)));
  }
  return of_y > 0.0 ? of_x / of_y : 0.0;
}

bool SparseLu::solve_refined(VecX& x, double good_enough) {
  if (size() == 0) return true;
  begin_solving(x);
  const auto is_good_enough = [&] {
    if (!(good_enough > 0.0)) return false;
    write_rough_residual();
    return residual_.lpNorm<Eigen::Infinity>() <= good_enough * right_side_.lpNorm<Eigen::Infinity>();
  };
  return end_solving(solution_.allFinite() && (is_good_enough() || refine_by_factors()), x);
}

bool SparseLu::solve_equation_by_equation(VecX& x, double good_enough, const VecX& least) {
  if (size() == 0) return true;
  begin_solving(x);
  const auto is_good_enough = [&] {
    write_rough_residual();
    write_terms(least);
    return (residual_.array().abs() <= good_enough * terms_.array()).all();
  };
  return end_solving(solution_.allFinite() && (is_good_enough() || refine_by_factors()), x);
}

}  // namespace concord::cartesian
