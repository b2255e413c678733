#include "relative/start/projection.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/error.h"

namespace concord::relative {

namespace {

constexpr double kNearlyClosed = 1e-7;         // a position residual that does not change Phi_u enough for speeds
constexpr double kNoRoundOff = 1e-9;           // of the largest speed: what no dependent row explains
constexpr double kRoundOffOfSpeed = 1e-15;     // of the largest speed
constexpr double kRoundOffOfPosition = 1e-15;  // of the largest coordinate, at least of 1: nothing to take away
/// A modal coordinate moves in a projection as if its column were this part of itself.
constexpr double kModesMove = 1e-3;

}  // namespace

Projection::Projection(const ScaledClosure& scaled) : scaled_(&scaled), loop_rows_(scaled) {
  const std::vector<int>& columns = scaled.free_columns();
  weights_of_joints_ = weights_of_all_ = VecX::Ones(static_cast<Eigen::Index>(columns.size()));
  const std::vector<int> of_joints = scaled.moving_columns(scaled.equations().driven(), Modes::kept);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (std::binary_search(of_joints.begin(), of_joints.end(), columns[c])) continue;
    weights_of_joints_(static_cast<Eigen::Index>(c)) = kModesMove;
  }
}

/// Factors the closure rows here, in the units of the machine: all at once where they are clearly independent, else
/// those for positions by themselves, and all.
void Projection::factor_rows() {
  is_clear_ = loop_rows_.factor(weights());
  if (is_clear_) return;
  const Closure& closure = scaled_->closure();
  const MatX Phi = scaled_->rows(scaled_->free_columns()) * weights().asDiagonal();
  const bool positions_are_all = closure.n_position_rows() == closure.n_rows();
  row_factors_.compute(Phi);
  if (!positions_are_all) position_factors_.compute(Phi.topRows(closure.n_position_rows()));
}

/// The smallest step of the free columns in the units of the machine that takes away the misfit of the independent rows
/// of this pose among those that it has; the others follow.
VecX Projection::step_against(const VecX& misfit) const {
  const Closure& closure = scaled_->closure();
  const VecX scaled = misfit.cwiseQuotient(closure.row_units().head(misfit.size()));
  const RowRank& factors = misfit.size() < closure.n_rows() ? position_factors_ : row_factors_;
  const VecX solution = is_clear_ ? loop_rows_.smallest_step(scaled) : factors.smallest_step(scaled);
  VecX step = VecX::Zero(scaled_->equations().topology().n_tree_u);
  const VecX& columns = weights();
  for (std::size_t c = 0; c < scaled_->free_columns().size(); ++c) {
    const int column = scaled_->free_columns()[c];
    step(column) = solution(static_cast<Eigen::Index>(c)) * columns(static_cast<Eigen::Index>(c)) *
                   scaled_->size().speeds()(column);
  }
  return step;
}

/// Newton's method to round-off; Phi_u is kept while each step takes away nine tenths of the residual.
void Projection::project_positions(Coordinates& coordinates) {
  const Closure& closure = scaled_->closure();
  const double allowed = kClosedPart * scaled_->size_of_places(coordinates.q);
  double residual = scaled_->position_residual();
  if (residual <= kRoundOffOfPosition * std::max(1.0, scaled_->size().largest_coordinate(coordinates.q))) return;
  bool is_fresh = true;
  for (int iteration = 0; iteration < 8; ++iteration) {
    scaled_->advance(coordinates.q, step_against(closure.position_residual()));
    scaled_->move(coordinates);
    if (!closure.position_residual().allFinite()) break;
    const double reached = scaled_->position_residual();
    const bool stands = reached >= 0.5 * residual;
    const bool is_slow = reached >= 0.1 * residual;
    residual = std::min(residual, reached);
    if (reached < 0.1 * allowed || (stands && is_fresh && reached < allowed)) break;
    if (stands && iteration > 3) break;
    is_fresh = is_slow;
    if (is_slow) factor_rows();
  }
  residual = scaled_->position_residual();
  if (closure.position_residual().allFinite()) {
    if (residual <= allowed) return;
    if (scaled_->residual_of_coordinates(closure, scaled_->free_columns()) <= allowed) return;
  }
  throw SolverError(fmt::format(
      "{} will not close: position residual {:.1e} in parts of the machine's length and rad, allowed {:.0e}; it was "
      "closed at the start: tighten the tolerance",
      closure.worst_place(
          closure.position_residual().cwiseQuotient(closure.row_units().head(closure.position_residual().size()))),
      residual, allowed));
}

/// Until round-off stands; Phi_u is taken anew where a step takes away less than nine tenths of the residual.
void Projection::project_velocities(Coordinates& coordinates) {
  const Closure& closure = scaled_->closure();
  double residual = scaled_->velocity_residual();
  if (residual <= kRoundOffOfSpeed * scaled_->size().largest_speed(coordinates.u)) return;
  bool is_fresh = false;
  for (int iteration = 0; iteration < 4 && residual > 0.0; ++iteration) {
    coordinates.u.head(scaled_->equations().topology().n_tree_u) += step_against(closure.velocity_residual());
    scaled_->move(coordinates);
    const double reached = scaled_->velocity_residual();
    const bool is_slow = reached >= 0.1 * residual;
    residual = std::min(residual, reached);
    if (reached <= kRoundOffOfSpeed * scaled_->size().largest_speed(coordinates.u) || (is_slow && is_fresh)) break;
    if (is_slow) factor_rows();
    is_fresh = is_slow;
  }
  residual = scaled_->velocity_residual();
  const double allowed = kNoRoundOff * scaled_->size().rate_at(coordinates.u);
  if (closure.velocity_residual().allFinite() && residual <= allowed) return;
  throw SolverError(fmt::format(
      "{} does not obey the velocity constraints: residual {:.1e} in parts of the machine's length and rad per s, "
      "allowed {:.0e}; it obeyed them at the start: tighten the tolerance",
      closure.worst_place(closure.velocity_residual().cwiseQuotient(closure.row_units())), residual, allowed));
}

void Projection::project(Coordinates& coordinates, Modes modes) {
  scaled_->normalize(coordinates.q);
  modes_ = modes;
  scaled_->move(coordinates);
  if (scaled_->closure().n_rows() == 0) return;
  const bool was_near = scaled_->position_residual() < kNearlyClosed;
  factor_rows();
  project_positions(coordinates);
  if (!was_near) factor_rows();
  project_velocities(coordinates);
}

bool Projection::try_positions(Coordinates& coordinates, Modes modes) {
  try {
    scaled_->normalize(coordinates.q);
    modes_ = modes;
    scaled_->move(coordinates);
    factor_rows();
    project_positions(coordinates);
    return true;
  } catch (const SolverError&) {
    return false;
  }
}

}  // namespace concord::relative
