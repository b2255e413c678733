#include "compare/equilibrium/growth.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "common/decompositions.h"

namespace concord::compare {

namespace {

/// What an eigenvalue may be wrong by: |y E x| for measured errors, and round-off of the entries of J; of its largest
/// ones too, which the search for eigenvalues spreads.
double unresolved_growth(const Stiffness& stiffness, const Eigen::VectorXcd& x, const Eigen::RowVectorXcd& y) {
  constexpr double kRoundOff = 4.0 * std::numeric_limits<double>::epsilon();
  const double round_off = kRoundOff * y.cwiseAbs().dot(stiffness.J.cwiseAbs() * x.cwiseAbs());
  const double of_search = std::numeric_limits<double>::epsilon() * y.norm() * stiffness.J.norm() * x.norm();
  return round_off + of_search + y.cwiseAbs().dot(stiffness.error.cwiseAbs() * x.cwiseAbs());
}

}  // namespace

Growth::Growth(const Stiffness& stiffness, double least) {
  constexpr double kClearly = 30.0;
  GeneralEigenpairs pairs = eigenpairs(stiffness.J);
  values_ = std::move(pairs.values);
  right_ = std::move(pairs.vectors);
  left_ = inverse_of(right_);
  for (Eigen::Index k = 0; k < values_.size(); ++k) {
    const double growth = values_(k).real();
    if (growth <= least) continue;
    const double unresolved = kClearly * unresolved_growth(stiffness, right_.col(k), left_.row(k));
    if (!(growth > unresolved)) continue;
    growing_.push_back(k);
    steepest_ = std::max(steepest_, growth);
  }
}

VecX Growth::without_negligible(const VecX& f, double least) const {
  if (!left_.allFinite()) return f;
  VecX along = VecX::Zero(f.size());
  for (const Eigen::Index k : growing_) {
    const std::complex<double> part = left_.row(k) * f.cast<std::complex<double>>();
    if (std::abs(part) * right_.col(k).norm() > least) return f;
    along += (right_.col(k) * part).real();
  }
  return f - along;
}

MatX Growth::reversed_above(double rate) const {
  MatX reversed = MatX::Zero(values_.size(), values_.size());
  if (!left_.allFinite()) return reversed;
  for (Eigen::Index k = 0; k < values_.size(); ++k) {
    if (values_(k).real() <= rate) continue;
    reversed += 2.0 * values_(k).real() * (right_.col(k) * left_.row(k)).real();
  }
  return reversed;
}

}  // namespace concord::compare
