#include "relative/closing.h"

#include <algorithm>
#include <cmath>

#include "common/decompositions.h"
#include "common/error.h"
#include "relative/row_factors.h"

namespace concord::relative {

namespace {

constexpr int kMostIterations = 60;
constexpr double kFarthestStep = 0.5;  // in machine units: half a radian, half the length; of the first step
constexpr int kManyRows = 48;
constexpr double kFarFromDependent = 1e-4;  // smallest singular value of rows that need no filter
constexpr double kBeyondDamping = 30.0;     // times the damping, which takes a thousandth of the step there

/// Directions in which the rows are dependent are left alone, those with singular values below the damping hardly used,
/// and those beyond `rank` not (R65).
VecX filtered_step(const MatX& Phi, const VecX& misfit, double damping, std::optional<int> rank) {
  const Eigen::JacobiSVD<MatX> svd(Phi, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VecX& sigma = svd.singularValues();
  VecX filter = VecX::Zero(sigma.size());
  const Eigen::Index used = std::min<Eigen::Index>(sigma.size(), rank.value_or(static_cast<int>(sigma.size())));
  for (Eigen::Index i = 0; i < used; ++i) {
    if (sigma(i) > kDependentPart * std::max(sigma(0), 1.0))
      filter(i) = sigma(i) / (sigma(i) * sigma(i) + damping * damping);
  }
  return -(svd.matrixV() * filter.asDiagonal() * svd.matrixU().transpose() * misfit);
}

/// The same of many rows without their singular values (R66), if all are far from dependent, and from the damping.
std::optional<VecX> undamped_step(const MatX& Phi, const VecX& misfit, double damping, std::optional<int> rank) {
  const int n_rows = static_cast<int>(Phi.rows());
  if (n_rows < kManyRows || rank.value_or(n_rows) < n_rows) return std::nullopt;
  RowFactors factors;
  factors.compute(Phi);
  const double least = std::max(kFarFromDependent, kBeyondDamping * damping);
  if (factors.rank() < n_rows || factors.singular_value(n_rows) <= least) return std::nullopt;
  return factors.smallest_step(misfit);
}

/// The smallest step (n_tree_u numbers, in machine units) of the given columns that takes the misfit, of as many rows
/// as it has, away to first order (R65). Many rows that are far from dependent are left without their singular values,
/// which would take most of a closing's time.
VecX smallest_step(const ScaledClosure& scaled, const Closure& closure, const std::vector<int>& columns,
                   const VecX& misfit, double damping, std::optional<int> rank = {}) {
  const MatX Phi = scaled.rows(closure, columns).topRows(misfit.size());
  VecX step = VecX::Zero(scaled.equations().topology().n_tree_u);
  if (Phi.size() == 0) return step;
  const VecX misfit_in_units = misfit.cwiseQuotient(closure.row_units().head(misfit.size()));
  const std::optional<VecX> undamped = undamped_step(Phi, misfit_in_units, damping, rank);
  const VecX solution = undamped ? *undamped : filtered_step(Phi, misfit_in_units, damping, rank);
  for (std::size_t c = 0; c < columns.size(); ++c) step(columns[c]) = solution(c);
  return step;
}

/// Whether a step, of which `part` was made, has left of each row's misfit what its first order says, to a hundredth of
/// what it takes away: so does a rope that hauls a load, or a thread, however far they go.
bool went_straight(const VecX& before, const VecX& after, double part) {
  constexpr double kBent = 0.01;
  constexpr double kRoundOff = 1e-9;
  const double nothing = kRoundOff * largest_entry(before);
  for (Eigen::Index row = 0; row < before.size(); ++row) {
    const double taken = part * std::abs(before(row));
    if (std::abs(after(row) - (1.0 - part) * before(row)) > kBent * taken + nothing) return false;
  }
  return true;
}

}  // namespace

double measure(const ScaledClosure& scaled, Coordinates& coordinates, Closure& closure) {
  scaled.equations().move(coordinates.t, coordinates.q, coordinates.u);
  closure.measure(coordinates.q, coordinates.u);
  return largest_entry(closure.position_residual().cwiseQuotient(closure.row_units().head(closure.n_position_rows())));
}

double try_to_measure(const ScaledClosure& scaled, Coordinates& coordinates, Closure& closure) {
  try {
    return measure(scaled, coordinates, closure);
  } catch (const SolverError&) {
    return HUGE_VAL;
  }
}

bool close_positions(const ScaledClosure& scaled, Coordinates& coordinates, const PrescribedMask& prescribed,
                     Modes modes, std::optional<int> rank) {
  Closure closure(scaled.equations().kinematics(), prescribed);
  if (closure.n_position_rows() == 0) return true;
  const std::vector<int> columns = scaled.moving_columns(prescribed, modes);
  double residual = measure(scaled, coordinates, closure);
  double farthest = kFarthestStep;
  for (int iteration = 0; iteration < kMostIterations && residual > 0.0; ++iteration) {
    const VecX misfit = closure.position_residual();
    VecX step = smallest_step(scaled, closure, columns, misfit, std::min(1e-3, residual), rank);
    double part = std::min(1.0, farthest / std::max(largest_entry(step), 1e-300));
    step = step.cwiseProduct(scaled.scales().speeds().head(step.size()));
    bool improved = false;
    for (int halvings = 0; halvings < 12 && !improved; ++halvings, part *= 0.5) {
      Coordinates trial = coordinates;
      scaled.advance(trial.q, part * step);
      const double trial_residual = try_to_measure(scaled, trial, closure);
      improved = trial_residual < residual;
      if (!improved) continue;
      coordinates = std::move(trial);
      residual = trial_residual;
      farthest = went_straight(misfit, closure.position_residual(), part) ? 2.0 * farthest : kFarthestStep;
    }
    if (!improved) break;
  }
  measure(scaled, coordinates, closure);
  // Round-off adds up along a loop, which has at most all links.
  const double longest = 0.01 * static_cast<double>(scaled.equations().topology().links.size());
  const double allowed = kClosedPart * std::max(scaled.size_of_places(coordinates.q), longest);
  return residual < allowed || scaled.residual_of_coordinates(closure, columns) < allowed;
}

bool close_velocities(const ScaledClosure& scaled, Coordinates& coordinates, const PrescribedMask& prescribed,
                      Modes modes) {
  Closure closure(scaled.equations().kinematics(), prescribed);
  if (closure.n_rows() == 0) return true;
  const std::vector<int> columns = scaled.moving_columns(prescribed, modes);
  const double size = std::max(scaled.rate(), scaled.size_of_u(coordinates.u));
  double residual = 0.0;
  for (int iteration = 0; iteration < 4; ++iteration) {
    measure(scaled, coordinates, closure);
    residual = largest_entry(closure.velocity_residual().cwiseQuotient(closure.row_units()));
    const VecX step = smallest_step(scaled, closure, columns, closure.velocity_residual(), 0.0);
    coordinates.u.head(step.size()) += step.cwiseProduct(scaled.scales().speeds().head(step.size()));
  }
  measure(scaled, coordinates, closure);
  residual = std::min(residual, largest_entry(closure.velocity_residual().cwiseQuotient(closure.row_units())));
  return residual <= kClosedPart * std::max(size, scaled.size_of_u(coordinates.u));
}

}  // namespace concord::relative
