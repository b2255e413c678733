#include "cartesian/dynamics/dynamics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cartesian/dynamics/state_scales.h"
#include "common/error.h"

namespace concord::cartesian {

Dynamics::Dynamics(Equations& equations)
    : equations_(equations),
      matrix_(equations),
      projection_(equations),
      gamma_(VecX::Zero(equations.constraints().n_rows())),
      unknowns_(VecX::Zero(equations.layout().n_Y() + gamma_.size())),
      least_unknowns_(VecX::Zero(unknowns_.size())),
      solution_(equations.layout().n_Y(), equations.constraints().n_rows()) {
  use_rows(std::vector<bool>(equations.constraints().n_rows(), true));
}

void Dynamics::use_rows(const std::vector<bool>& active) {
  if (active == active_) return;
  active_ = active;
  matrix_.use_rows(active);
  projection_.use_rows(active);
  has_new_rows_ = true;
}

void Dynamics::add_Phi_Y_transposed_times(const Eigen::Ref<const VecX>& x, Eigen::Ref<VecX> sum) const {
  const Layout& layout = equations_.layout();
  const MovingConstraints& constraints = equations_.moving_constraints();
  for (const RowBlock& block : constraints.blocks()) {
    const Eigen::Ref<const MatX> Phi_Y_transposed = constraints.columns(block);
    for (int own = 0; own < block.n_rows; ++own) {
      if (!is_active(block.row(own))) continue;
      sum.segment(layout.first_Y(block.body), layout.size_Y(block.body)) +=
          x(block.row(own).value) * Phi_Y_transposed.col(own);
    }
  }
}

const SparseLu& Dynamics::fill_matrix() {
  matrix_.fill(equations_);
  return matrix_.lu();
}

void Dynamics::write_right_side() {
  unknowns_.head(equations_.layout().n_Y()) = equations_.forces();
  for (const RowIndex row : equations().constraints().rows()) {
    unknowns_(matrix_.index_of(row)) = is_active(row) ? gamma_(row.value) : 0.0;
  }
}

/// With pivots chosen at another state. What speeds and gravity make of a body is no small acceleration.
bool Dynamics::solve_between_steps() {
  constexpr double kGoodEnough = 1e-12;
  const VecX& units = equations_.units();
  const double from_gravity = equations_.model().gravity.norm() / equations_.length();
  const double from_speeds = equations_.Y().cwiseQuotient(units).cwiseAbs2().maxCoeff();
  least_unknowns_.head(units.size()) = std::max(from_gravity, from_speeds) * units;
  return matrix_.lu().solve_equation_by_equation(unknowns_, kGoodEnough, least_unknowns_);
}

bool Dynamics::factor_and_solve(Pivots pivots) {
  SparseLu& lu = matrix_.lu();
  if (pivots == Pivots::kept && !has_new_rows_) {
    write_right_side();
    if (lu.refactor() && (magnifies_ ? lu.solve_refined(unknowns_, 0.0) : solve_between_steps())) return true;
  }
  write_right_side();
  const bool is_good = lu.factor() && lu.solve_refined(unknowns_, 0.0);
  magnifies_ = is_good && magnifies_round_off();
  has_new_rows_ = false;
  return is_good;
}

const Solution& Dynamics::solve(Pivots pivots) {
  equations_.moving_constraints().write_gamma(equations_.time(), gamma_);
  matrix_.fill(equations_);
  if (!factor_and_solve(pivots)) {
    throw SingularPose(fmt::format(
        "cartesian: at t = {:.6g} s the equations of motion are singular: the machine is in a singular pose, a body "
        "can move without inertia, or inertias lie too far apart for double precision",
        equations_.time()));
  }
  solution_.Ydot_ = unknowns_.head(solution_.Ydot_.size());
  solution_.lambda_ = unknowns_.tail(solution_.lambda_.size());
  return solution_;
}

const Solution& Dynamics::solve_at(double t, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y,
                                   Pivots pivots) {
  equations_.update(t, q, Y);
  return solve(pivots);
}

void Dynamics::accelerate(const Eigen::Ref<const VecX>& forces, Eigen::Ref<VecX> accelerations) {
  unknowns_.setZero();
  unknowns_.head(forces.size()) = forces;
  matrix_.lu().solve(unknowns_);
  accelerations = unknowns_.head(forces.size());
}

/// Whether the last solution needed correcting: as a whole, or the accelerations alone, which is where the tiny
/// equations of a body far lighter than those that lead it are seen.
bool Dynamics::magnifies_round_off() const {
  constexpr double kMagnified = 1e-13;
  const SparseLu& lu = matrix_.lu();
  if (lu.relative_correction() > kMagnified) return true;
  const auto n_Y = equations_.layout().n_Y();
  const double acceleration = largest_acceleration(equations_, unknowns_.head(n_Y));
  const auto correction = lu.first_correction().head(n_Y).cwiseQuotient(equations_.units());
  return (correction.array().abs() > kMagnified * acceleration).any();
}

std::optional<RowIndex> Dynamics::contradicted_row(const Solution& solution) {
  constexpr double kContradiction = 1e-7;
  if (std::all_of(active_.begin(), active_.end(), [](bool is_active) { return is_active; })) return std::nullopt;
  VecX solved(unknowns_.size());
  solved << solution.Ydot(), solution.lambda();
  unknowns_ << equations_.forces(), gamma_;
  matrix_.lu().subtract_product(solved, unknowns_);
  double worst = kContradiction * largest_acceleration(equations_, solution.Ydot());
  std::optional<RowIndex> found;
  for (const RowIndex row : equations().constraints().rows()) {
    const double size = equations_.row_sizes()(row.value);
    if (is_active(row) || !(size > 0.0)) continue;
    const double misfit = std::abs(unknowns_(matrix_.index_of(row))) / size;
    if (misfit <= worst) continue;
    worst = misfit;
    found = row;
  }
  return found;
}

const RoundOffShares& Dynamics::project(const Solution& /*nearby*/, double t, Eigen::Ref<VecX> q, Eigen::Ref<VecX> Y) {
  return projection_.project(equations_, matrix_, t, q, Y);
}

}  // namespace concord::cartesian
