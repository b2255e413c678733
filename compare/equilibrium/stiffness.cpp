#include "compare/equilibrium/stiffness.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/decompositions.h"
#include "common/error.h"
#include "common/products.h"

namespace concord::compare {

namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kDifferenceStep = 0.02;               // of the machine's length, rad
constexpr double kFinestStep = kDifferenceStep / 4.0;  // of the three from which derivatives are extrapolated
constexpr double kLeastDifferenceStep = 1e-6;
constexpr double kRoughStep = 1e-5;
constexpr double kTimesReference = 10.0;
/// Errors and round-off are measured once; what exceeds them so many times is stiffness.
constexpr double kClearly = 10.0;
constexpr double kRoundOffOfReference = 1e-12;  // derivative_at_zero() looks no further

/// Why the solver refuses the nearest of the states along a direction, to both sides, that it refuses at all.
std::string nearest_refusal(const Chart& chart, const VecX& direction) {
  for (double step = kLeastDifferenceStep; step <= kDifferenceStep; step *= 4.0) {
    for (const double sense : {1.0, -1.0}) {
      std::string refusal = chart.refusal_at(sense * step * direction);
      if (!refusal.empty()) return refusal;
    }
  }
  return "";
}

constexpr double kNearRest = 1e-9;  // of what forces cause

using AlongLine = std::function<std::optional<VecX>(double)>;

/// The shortest step of differences, and half of what changes across it; nothing where closed states are missing.
struct LeastStep {
  double step = kLeastDifferenceStep;
  std::optional<VecX> change;
};

/// A force that bends within the least step, as that of a stop on the first part of its way, asks for a shorter one.
LeastStep least_difference_step(const AlongLine& function, const AccelerationScale& scale) {
  constexpr double kShorter = 1.0 / 16.0;
  constexpr double kLeastOfAll = 1e-11;
  constexpr double kSeen = 1e-3;      // of what forces cause: less would be no stiff direction
  constexpr double kRoundOff = 1e-3;  // that may be in what is seen
  constexpr double kBends = 0.01;
  const auto change_over = [&](double step) -> std::optional<VecX> {
    const auto plus = function(step);
    const auto minus = function(-step);
    return plus && minus ? std::optional<VecX>(0.5 * (*plus - *minus)) : std::nullopt;
  };
  const double least = std::max(kSeen * scale.reference, scale.unresolved() / kRoundOff);
  LeastStep found{kLeastDifferenceStep, change_over(kLeastDifferenceStep)};
  while (found.change && found.step > kLeastOfAll && found.change->norm() > least) {
    auto shorter = change_over(kShorter * found.step);
    if (!shorter) break;
    const VecX straight = kShorter * *found.change;
    if ((*shorter - straight).norm() <= kBends * std::max(shorter->norm(), straight.norm())) break;
    found = {kShorter * found.step, std::move(shorter)};
  }
  return found;
}

/// So far that stiff directions change the accelerations by ten times the reference, soft ones as far as is good; where
/// forces are round-off of what springs add up, they say nothing.
double difference_step(const LeastStep& least, const AccelerationScale& scale) {
  const double reference = scale.reference;
  if (!least.change || reference <= scale.unresolved()) return kDifferenceStep;
  const double slope = least.change->norm() / least.step;
  if (slope * kDifferenceStep <= kTimesReference * reference) return kDifferenceStep;
  return std::max(4.0 * least.step, kTimesReference * reference / slope);
}

std::optional<Derivative> derivative_along(const AccelerationsAt& accelerations, const VecX& direction,
                                           const AccelerationScale& scale) {
  const AlongLine along = [&](double step) { return accelerations(step * direction); };
  const LeastStep least = least_difference_step(along, scale);
  return derivative_at_zero(along, difference_step(least, scale), least.step, scale.resolved_reference());
}

/// Differences soft directions along themselves where an error covers more than the last eight digits of them.
void refine_soft_directions(const AccelerationsAt& accelerations, const AccelerationScale& scale,
                            Stiffness& stiffness) {
  constexpr double kResolved = 1e-8;
  const Eigen::JacobiSVD<MatX> svd(stiffness.J, Eigen::ComputeFullU | Eigen::ComputeFullV);
  for (Eigen::Index k = 1; k < stiffness.J.cols(); ++k) {
    const VecX direction = svd.matrixV().col(k);
    const VecX error = stiffness.error * direction;
    if (error.norm() <= kResolved * std::max(svd.singularValues()(k), kResolved * scale.resolved_reference())) continue;
    const auto again = derivative_along(accelerations, direction, scale);
    if (!again || again->error.norm() >= error.norm()) continue;
    stiffness.J += (again->value - stiffness.J * direction) * direction.transpose();
    stiffness.error += (again->error - error) * direction.transpose();
  }
}

/// What turning the accelerations f of the chart's origin with the bodies adds to derivatives, at most: rows by the
/// accelerations `rows`, columns by the motions `columns`. Accelerations beyond `most` are those of a machine on its
/// way, for which nothing is decided yet.
MatX feigned_stiffness(const Chart& chart, const MatX& rows, const MatX& columns, const VecX& f, double most) {
  const VecX accelerations = (chart.basis() * f).cwiseAbs();
  const MatX seen = product(chart.basis(), rows).cwiseAbs();
  MatX feigned = MatX::Zero(rows.cols(), columns.cols());
  const MatX moved = product(chart.basis(), columns).cwiseAbs();
  Eigen::Index row = 0;
  for (std::size_t i = 1; i < chart.origin().bodies.size(); ++i) {
    const Eigen::Index size = 6 + chart.origin().bodies[i].a.size();
    const double largest = std::min(accelerations.segment(row, size).norm(), most);
    feigned += largest * seen.middleRows(row, size).colwise().norm().transpose() *
               moved.middleRows(row, size).colwise().norm();
    row += size;
  }
  return feigned;
}

}  // namespace

Stiffness stiffness_matrix(const Chart& chart, const Solver& solver, const AccelerationsAt& accelerations,
                           const AccelerationScale& scale) {
  Stiffness stiffness{MatX(chart.n(), chart.n()), MatX(chart.n(), chart.n())};
  for (int k = 0; k < chart.n(); ++k) {
    const auto column = derivative_along(accelerations, VecX::Unit(chart.n(), k), scale);
    if (!column) {
      const std::string refusal = nearest_refusal(chart, VecX::Unit(chart.n(), k));
      if (!refusal.empty()) throw SolverError(refusal);
      throw SingularPose(fmt::format(
          "{}: at t = {:.6g} s the constraints permit {}, but no closed states are found along it: the pose "
          "is singular, or the machine cannot move so far there",
          solver.name(), chart.origin().t, chart.describe(VecX::Unit(chart.n(), k))));
    }
    stiffness.J.col(k) = column->value;
    stiffness.error.col(k) = column->error;
  }
  refine_soft_directions(accelerations, scale, stiffness);
  return stiffness;
}

std::optional<MatX> rough_stiffness(const Chart& chart, const VecX& f, const AccelerationsAt& accelerations,
                                    double reference) {
  MatX J(chart.n(), chart.n());
  for (int k = 0; k < chart.n(); ++k) {
    const auto beside = accelerations(kRoughStep * VecX::Unit(chart.n(), k));
    if (!beside) return std::nullopt;
    J.col(k) = (*beside - f) / kRoughStep;
    if (!(J.col(k).norm() * kRoughStep <= kTimesReference * reference)) return std::nullopt;
  }
  return J;
}

std::string kink_at_origin(const Chart& chart, const AccelerationsAt& accelerations, const MatX& J,
                           const AccelerationScale& scale) {
  constexpr double kJump = 1e-3;      // of a column of J
  constexpr double kRoundOff = 1e-7;  // of what forces cause, over the step
  constexpr double kStays = 1.5;      // what is smooth grows with the step, round-off falls
  const double round_off = std::max(kRoundOff * scale.reference, kClearly * scale.unresolved() / kLeastDifferenceStep);
  const auto here = accelerations(VecX::Zero(chart.n()));
  if (!here) return "";
  const auto bend = [&](int k, double step) -> double {
    const auto plus = accelerations(step * VecX::Unit(chart.n(), k));
    const auto minus = accelerations(-step * VecX::Unit(chart.n(), k));
    return plus && minus ? (*plus + *minus - 2.0 * *here).norm() / (2.0 * step) : 0.0;
  };
  int worst = -1;
  double largest = 0.0;
  for (int k = 0; k < chart.n(); ++k) {
    const double coarse = bend(k, kLeastDifferenceStep);
    if (coarse <= std::max({kJump * J.col(k).norm(), round_off, largest})) continue;
    const double wider[] = {bend(k, 4.0 * kLeastDifferenceStep), bend(k, 16.0 * kLeastDifferenceStep)};
    // Shorter than what stiff stops are soft over, and longer than how near to a kink a rest is found.
    const double narrow = bend(k, kLeastDifferenceStep / 64.0);
    const auto [least, most] = std::minmax({narrow, coarse, wider[0], wider[1]});
    if (most > kStays * least) continue;
    worst = k;
    largest = coarse;
  }
  return worst < 0 ? "" : chart.describe(VecX::Unit(chart.n(), worst));
}

StiffnessSplit::StiffnessSplit(const Chart& chart, const Stiffness& stiffness, const AccelerationScale& scale,
                               const VecX& f, double strictness)
    : clearly_(kClearly * strictness) {
  const MatX& J = stiffness.J;
  const Eigen::Index n = J.cols();
  const Eigen::Index m = chart.n_modal();
  MatX range = MatX::Identity(n, n);
  if (m > 0) range = orthogonal_completion(J.leftCols(m));
  onto_modes_ = range.leftCols(m);
  beyond_ = range.rightCols(n - m);
  R11_ = transposed_product(onto_modes_, J.leftCols(m));
  R12_ = transposed_product(onto_modes_, J.rightCols(n - m));
  free_ = MatX(n, 0);
  if (n == m) return;
  // Rigid motions, in which modes follow statically.
  MatX motions = MatX::Zero(n, n - m);
  motions.bottomRows(n - m).setIdentity();
  if (m > 0) motions.topRows(m) = -least_squares(R11_, R12_);
  const MatX round_off =
      4.0 * kEpsilon * transposed_product(beyond_.cwiseAbs(), product(J.cwiseAbs(), motions.cwiseAbs()));
  const MatX feigned = feigned_stiffness(chart, beyond_, motions, f, kNearRest * scale.reference);
  MatX of_scale = MatX::Identity(n - m, n - m) * (kRoundOffOfReference * scale.reference);
  for (Eigen::Index row = 0; row < n - m; ++row) {
    of_scale.row(row).array() += scale.unresolved_along(beyond_.col(row)) / kFinestStep;
  }
  split(transposed_product(beyond_, J.rightCols(n - m)), transposed_product(beyond_, product(stiffness.error, motions)),
        round_off + feigned + of_scale);
  const MatX directions = free_;
  free_ = product(motions, directions);
}

void StiffnessSplit::split(const MatX& stiffness, const MatX& error, const MatX& round_off) {
  const Eigen::JacobiSVD<MatX> svd(stiffness, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const VecX& sigma = svd.singularValues();
  const Eigen::Index n = sigma.size();
  const MatX& U = svd.matrixU();
  const MatX& V = svd.matrixV();
  const MatX unresolved = transposed_product(U, product(error, V)).cwiseAbs() +
                          transposed_product(U.cwiseAbs(), product(round_off, V.cwiseAbs()));
  // Of a direction among those that are at most as stiff, and what those that are stiffer pass on to it.
  const auto least_in = [&](Eigen::Index k) {
    double least = unresolved.bottomRightCorner(n - k, n - k).norm();
    for (Eigen::Index i = 0; i < k; ++i) {
      least += unresolved.row(i).tail(n - k).norm() * unresolved.col(i).tail(n - k).norm() / sigma(i);
    }
    return clearly_ * least;
  };
  Eigen::Index rank = 0;
  while (rank < n && sigma(rank) > least_in(rank)) ++rank;
  largest_ = sigma(0);
  least_ = least_in(std::min(rank, n - 1));
  const Eigen::Index missing = n - rank;
  pseudo_inverse_ =
      product(V.leftCols(rank) * sigma.head(rank).cwiseInverse().asDiagonal(), U.leftCols(rank).transpose());
  unmet_projector_ = product(U.rightCols(missing), U.rightCols(missing).transpose());
  free_ = V.rightCols(missing);
}

VecX StiffnessSplit::newton_step(const VecX& f) const {
  const Eigen::Index m = onto_modes_.cols();
  const Eigen::Index rigid = beyond_.cols();
  VecX step = VecX::Zero(f.size());
  if (rigid > 0) step.tail(rigid) = -(pseudo_inverse_ * (beyond_.transpose() * f));
  if (m > 0) {
    step.head(m) = least_squares(R11_, -(onto_modes_.transpose() * f) - R12_ * step.tail(rigid));
  }
  return step;
}

VecX StiffnessSplit::unmet(const VecX& f) const {
  if (beyond_.cols() == 0) return VecX::Zero(f.size());
  return beyond_ * (unmet_projector_ * (beyond_.transpose() * f));
}

}  // namespace concord::compare
