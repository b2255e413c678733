#include "relative/rank/closing.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/decompositions.h"
#include "common/error.h"
#include "relative/rank/row_rank.h"

namespace concord::relative {

namespace {

constexpr int kMostIterations = 60;
constexpr double kFarthestStep = 0.5;  // in machine units: half a radian, half the length, unless rows are straight
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

/// The same without singular values (R66), if all rows are far from dependent, and from the damping.
std::optional<VecX> undamped_step(const MatX& Phi, const VecX& misfit, double damping, std::optional<int> rank) {
  const int n_rows = static_cast<int>(Phi.rows());
  if (rank.value_or(n_rows) < n_rows) return std::nullopt;
  const RowRank factors(Phi);
  const double least = std::max(kFarFromDependent, kBeyondDamping * damping);
  if (factors.rank() < n_rows || factors.singular_value(n_rows) <= least) return std::nullopt;
  return factors.smallest_step(misfit);
}

}  // namespace

VecX smallest_step(const ScaledClosure& scaled, const Closure& closure, const std::vector<int>& columns,
                   const VecX& misfit, double damping, std::optional<int> rank) {
  const MatX Phi = scaled.rows(closure, columns).topRows(misfit.size());
  VecX step = VecX::Zero(scaled.equations().topology().n_tree_u);
  if (Phi.size() == 0) return step;
  const VecX misfit_in_units = misfit.cwiseQuotient(closure.row_units().head(misfit.size()));
  const std::optional<VecX> undamped = undamped_step(Phi, misfit_in_units, damping, rank);
  const VecX solution = undamped ? *undamped : filtered_step(Phi, misfit_in_units, damping, rank);
  for (std::size_t c = 0; c < columns.size(); ++c) step(columns[c]) = solution(c);
  return step;
}

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

namespace {

/// Where a part of a step leads, and what it leaves open.
struct Trial {
  Coordinates coordinates;
  double residual = HUGE_VAL;
  VecX misfit;
};

/// A step of the tree's speeds (n_tree_u numbers), made in parts from where it begins.
class PartedStep {
 public:
  PartedStep(const ScaledClosure& scaled, const Coordinates& from, Closure& closure, VecX step)
      : scaled_(scaled), from_(from), closure_(closure), step_(std::move(step)) {}

  [[nodiscard]] Trial make(double part) const {
    Trial trial{from_, HUGE_VAL, {}};
    scaled_.advance(trial.coordinates.q, part * step_);
    trial.residual = try_to_measure(scaled_, trial.coordinates, closure_);
    trial.misfit = closure_.position_residual();
    return trial;
  }

  /// Goes on from `reached`, a part of the step, twice as far each time, while every row changes in proportion: so does
  /// a coupling, or a thread, along which a slide may have many lengths to go. `begin`: the misfit where it begins.
  void go_on(const VecX& begin, double part, Trial& reached) const {
    while (part < 1.0) {
      const double farther = std::min(1.0, 2.0 * part);
      Trial trial = make(farther);
      const VecX expected = begin + farther / part * (reached.misfit - begin);
      if (!(trial.residual < reached.residual) || !is_near(trial.misfit, expected, begin)) return;
      reached = std::move(trial);
      part = farther;
    }
  }

 private:
  static bool is_near(const VecX& misfit, const VecX& expected, const VecX& begin) {
    constexpr double kBent = 0.01;      // of a row's change
    constexpr double kRoundOff = 1e-9;  // of the largest row
    const VecX allowed = kBent * (misfit - begin).cwiseAbs();
    return ((misfit - expected).cwiseAbs().array() <= allowed.array() + kRoundOff * largest_entry(begin)).all();
  }

  const ScaledClosure& scaled_;
  const Coordinates& from_;
  Closure& closure_;
  VecX step_;
};

}  // namespace

bool close_positions(const ScaledClosure& scaled, Coordinates& coordinates, const PrescribedMask& prescribed,
                     Modes modes, std::optional<int> rank) {
  Closure closure(scaled.equations().kinematics(), prescribed);
  if (closure.n_position_rows() == 0) return true;
  const std::vector<int> columns = scaled.moving_columns(prescribed, modes);
  double residual = measure(scaled, coordinates, closure);
  for (int iteration = 0; iteration < kMostIterations && residual > 0.0; ++iteration) {
    const VecX misfit = closure.position_residual();
    VecX step = smallest_step(scaled, closure, columns, misfit, std::min(1e-3, residual), rank);
    const double longest = std::min(1.0, kFarthestStep / std::max(largest_entry(step), 1e-300));
    step = step.cwiseProduct(scaled.size().speeds().head(step.size()));
    const PartedStep parted(scaled, coordinates, closure, std::move(step));
    double part = longest;
    Trial reached = parted.make(part);
    for (int halvings = 1; halvings < 12 && !(reached.residual < residual); ++halvings) {
      part *= 0.5;
      reached = parted.make(part);
    }
    if (!(reached.residual < residual)) break;
    const bool is_cut = longest < 1.0 && part == longest;
    if (is_cut) parted.go_on(misfit, part, reached);
    coordinates = std::move(reached.coordinates);
    residual = is_cut ? measure(scaled, coordinates, closure) : reached.residual;
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
  const double rate = scaled.size().rate_at(coordinates.u);
  double residual = 0.0;
  for (int iteration = 0; iteration < 4; ++iteration) {
    measure(scaled, coordinates, closure);
    residual = largest_entry(closure.velocity_residual().cwiseQuotient(closure.row_units()));
    const VecX step = smallest_step(scaled, closure, columns, closure.velocity_residual(), 0.0);
    coordinates.u.head(step.size()) += step.cwiseProduct(scaled.size().speeds().head(step.size()));
  }
  measure(scaled, coordinates, closure);
  residual = std::min(residual, largest_entry(closure.velocity_residual().cwiseQuotient(closure.row_units())));
  return residual <= kClosedPart * std::max(rate, scaled.size().rate_at(coordinates.u));
}

}  // namespace concord::relative
