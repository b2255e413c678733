#include "cartesian/dynamics/projection.h"

#include <fmt/format.h>

#include <cmath>

#include "common/error.h"

namespace concord::cartesian {

namespace {

// In the machine's units.
constexpr int kMostProjections = 12;
constexpr double kProjected = 1e-15;
constexpr double kProjectionLimit = 1e-9;

}  // namespace

Projection::Projection(const Equations& equations)
    : constraints_(Constraints::make(equations.model(), equations.layout())),
      shares_(*constraints_),
      residual_(VecX::Zero(constraints_->n_rows())),
      unknowns_(VecX::Zero(equations.layout().n_Y() + constraints_->n_rows())),
      step_(VecX::Zero(equations.layout().n_Y())),
      stiffening_(equations.layout().n_bodies()) {
  if (constraints_->has_nonholonomic_rows() || equations.model().is_flexible()) {
    ByBody<MatX> masses = modal_masses(equations);
    for (const BodyIndex i : equations.layout().moving_bodies()) {
      stiffening_[i] = equations.scales().stiffening[i] * equations.inertia(i).stiffness();
      masses[i] += stiffening_[i];
    }
    position_matrix_ = std::make_unique<AugmentedMatrix>(equations);
    position_elimination_ = std::make_unique<InertiaElimination>(equations, masses);
  }
}

void Projection::use_rows(const std::vector<bool>& active) {
  active_ = active;
  if (!position_matrix_) return;
  std::vector<bool> of_positions = active;
  for (const RowIndex row : constraints_->rows()) {
    of_positions[row.value] = active[row.value] && constraints_->holds_positions(row);
  }
  position_matrix_->use_rows(of_positions);
  position_elimination_->use_rows(of_positions);
  has_new_rows_ = true;
}

const RoundOffShares& Projection::project(const Equations& equations, const NearbyFactors& nearby, double t,
                                          Eigen::Ref<VecX> q, Eigen::Ref<VecX> Y) {
  equations.layout().normalize(q);
  if (constraints_->n_rows() == 0) return shares_;
  constraints_->count_turns_as(equations.constraints());
  PlacedConstraints& placed = project_positions(equations, nearby, t, q);
  project_velocities(placed, equations, nearby, t, Y);
  return shares_;
}

/// Adds to the inertia of each mode what its stiffness resists: it takes no part in closing the joints, unless nothing
/// else can (C48).
NearbyFactors Projection::factor_position_matrix(const Equations& equations, const NearbyFactors& nearby) {
  if (!position_matrix_) return nearby;
  SparseLu& lu = position_matrix_->lu();
  if (nearby.elimination != nullptr && position_elimination_->factor(equations)) {
    return {lu, position_elimination_.get()};
  }
  position_matrix_->fill(equations);
  for (const BodyIndex i : equations.layout().moving_bodies()) {
    position_matrix_->add_to_modes(i, stiffening_[i]);
  }
  const bool is_regular = has_new_rows_ ? lu.factor() : lu.refactor();
  has_new_rows_ = false;
  if (is_regular) return {lu, nullptr};
  throw SolverError(fmt::format("cartesian: at t = {:.6g} s the equations of position are singular", equations.time()));
}

void Projection::solve_constraint_step(const NearbyFactors& factors) {  // (C48)
  unknowns_.setZero();
  auto of_rows = unknowns_.tail(residual_.size());
  for (const RowIndex row : constraints_->rows()) {
    of_rows(row.value) = active_[row.value] ? -residual_(row.value) : 0.0;
  }
  factors.solve(unknowns_);
  step_ = unknowns_.head(step_.size());
}

PlacedConstraints& Projection::project_positions(const Equations& equations, const NearbyFactors& nearby, double t,
                                                 Eigen::Ref<VecX> q) {
  const NearbyFactors of_positions = factor_position_matrix(equations, nearby);
  measure_round_off(equations, t, q, shares_);
  PlacedConstraints* placed = nullptr;
  double size = HUGE_VAL;
  for (int step = 0; step < kMostProjections; ++step) {
    placed = &constraints_->place(q);
    placed->write_residual(t, residual_);
    const double last = size;
    size = largest_residual(equations, residual_, &shares_.terms);
    if (size <= kProjected || (size < kProjectionLimit && size > 0.5 * last)) return *placed;
    solve_constraint_step(of_positions);
    equations.layout().displace(step_, q);
  }
  if (size <= kProjectionLimit) return *placed;
  throw SolverError(
      fmt::format("cartesian: at t = {:.6g} s {} will not close: residual {:.3g} (of the machine's length, or rad), "
                  "allowed {:.3g}; it was closed at the start: tighten the tolerance",
                  t, name_of_largest(equations, residual_), size, kProjectionLimit));
}

void Projection::project_velocities(PlacedConstraints& placed, const Equations& equations, const NearbyFactors& nearby,
                                    double t, Eigen::Ref<VecX> Y) {
  const double speed = largest_rate(equations, t, Y);
  double size = HUGE_VAL;
  for (int step = 0; step < kMostProjections; ++step) {
    placed.move(Y).write_velocity_residual(t, residual_);
    const double last = size;
    size = largest_residual(equations, residual_);
    velocity_residual_left_ = size / speed;
    if (size <= kProjected * speed || (size < kProjectionLimit * speed && size > 0.5 * last)) return;
    solve_constraint_step(nearby);
    Y += step_;
  }
  if (size <= kProjectionLimit * speed) return;
  throw SolverError(fmt::format(
      "cartesian: at t = {:.6g} s the velocities of {} will not close: residual {:.3g} of the largest speed", t,
      name_of_largest(equations, residual_), size / speed));
}

}  // namespace concord::cartesian
