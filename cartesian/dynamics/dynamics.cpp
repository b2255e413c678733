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
      places_{{InertiaElimination(equations, modal_masses(equations)), {}}},
      elimination_(&places_.front().elimination),
      projection_(equations),
      gamma_(VecX::Zero(equations.constraints().n_rows())),
      right_side_(VecX::Zero(equations.layout().n_Y() + gamma_.size())),
      unknowns_(VecX::Zero(equations.layout().n_Y() + gamma_.size())),
      trial_(VecX::Zero(unknowns_.size())),
      error_(VecX::Zero(unknowns_.size())),
      least_unknowns_(VecX::Zero(unknowns_.size())),
      solution_(equations.layout().n_Y(), equations.constraints().n_rows()) {
  use_rows(std::vector<bool>(equations.constraints().n_rows(), true));
}

void Dynamics::use_rows(const std::vector<bool>& active) {
  if (active == active_) return;
  active_ = active;
  matrix_.use_rows(active);
  for (Place& place : places_) {
    place.elimination.use_rows(active);
    place.is_known = false;
  }
  is_eliminated_ = false;
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
  right_side_.head(equations_.layout().n_Y()) = equations_.forces();
  for (const RowIndex row : equations().constraints().rows()) {
    right_side_(matrix_.index_of(row)) = is_active(row) ? gamma_(row.value) : 0.0;
  }
}

/// What speeds and gravity make of a body is no small acceleration.
void Dynamics::measure_least_unknowns() {
  const VecX& units = equations_.units();
  const double from_gravity = equations_.model().gravity.norm() / equations_.length();
  const double from_speeds = equations_.Y().cwiseQuotient(units).cwiseAbs2().maxCoeff();
  least_unknowns_.head(units.size()) = std::max(from_gravity, from_speeds) * units;
}

namespace {

/// Residuals of equations as parts of their terms: round-off of a solution, and what is good enough between steps.
constexpr double kRoundOff = 1e-15;
constexpr double kGoodEnough = 1e-12;
/// What round-off of a solution may be magnified to, of the solution.
constexpr double kMagnified = 1e-13;
/// By how much it may have grown since the elimination was judged.
constexpr double kWorse = 2.0;

}  // namespace

bool Dynamics::solve_by_elimination() {
  is_eliminated_ = elimination_->factor(equations_);
  if (!is_eliminated_) return false;
  unknowns_ = right_side_;
  elimination_->solve(unknowns_);
  if (refinement_ != Refinement::exact) {
    const double residual = elimination_->largest_residual(right_side_, unknowns_, least_unknowns_);
    if (residual <= kRoundOff && refinement_ == Refinement::none) return true;
    elimination_->correct(unknowns_);
    if (residual <= kGoodEnough) return true;
  }
  matrix_.fill(equations_);
  return matrix_.lu().improve(right_side_, unknowns_, [this](VecX& rest) { elimination_->solve(rest); });
}

/// What has changed since a state nearby is so little that the factors from there tell it.
bool Dynamics::solve_by_factors_of(const Place& near) {
  constexpr double kLittle = 1e-10;  // of the sizes of terms; the factors miss about as small a part of it
  if (refinement_ == Refinement::exact) return false;
  unknowns_ = near.unknowns;
  elimination_->read(equations_);
  if (!(elimination_->largest_residual(right_side_, unknowns_, least_unknowns_) <= kLittle)) return false;
  elimination_->correct(unknowns_);
  is_eliminated_ = true;
  return true;
}

/// With pivots chosen at another state.
bool Dynamics::solve_by_whole_matrix() {
  SparseLu& lu = matrix_.lu();
  is_eliminated_ = false;
  matrix_.fill(equations_);
  if (!lu.refactor()) return false;
  unknowns_ = right_side_;
  if (refinement_ != Refinement::none) return lu.solve_refined(unknowns_, 0.0);
  return lu.solve_equation_by_equation(unknowns_, kRoundOff, least_unknowns_);
}

bool Dynamics::factor_and_solve(Pivots pivots, const Place* near) {
  write_right_side();
  if (pivots == Pivots::kept && !has_new_rows_) {
    measure_least_unknowns();
    if (eliminates_ && ((near != nullptr && solve_by_factors_of(*near)) || solve_by_elimination())) return true;
    if (solve_by_whole_matrix()) return true;
  }
  SparseLu& lu = matrix_.lu();
  is_eliminated_ = false;
  matrix_.fill(equations_);
  unknowns_ = right_side_;
  if (!has_new_rows_ && solve_with_last_pivots()) {
    if (!is_good_elimination()) judge_elimination();
    return true;
  }
  unknowns_ = right_side_;
  if (!lu.factor() || !lu.solve_refined(unknowns_, 0.0)) return false;
  judge_elimination();
  has_new_rows_ = false;
  return true;
}

/// To round-off; false where the last pivots are not as good as new ones.
bool Dynamics::solve_with_last_pivots() {
  SparseLu& lu = matrix_.lu();
  return lu.refactor() && lu.solve_refined(unknowns_, 0.0) && lu.relative_correction() <= kMagnified;
}

/// Elimination was found good where round-off was magnified about as much.
bool Dynamics::is_good_elimination() {
  const bool was_good = eliminates_ && refinement_ == Refinement::none;
  return was_good && matrix_.lu().relative_correction() <= kWorse * judged_at_;
}

/// In a state that has been solved for to round-off.
void Dynamics::judge_elimination() {
  constexpr double kFarOff = 1e-9;
  SparseLu& lu = matrix_.lu();
  judged_at_ = std::max(lu.relative_correction(), kRoundOff);
  const bool magnifies = loses_more_than(kMagnified, lu.relative_correction(), lu.first_correction());
  refinement_ = magnifies ? Refinement::exact : Refinement::none;
  eliminates_ = is_eliminated_ = false;
  if (!elimination_->factor(equations_)) return;
  trial_ = right_side_;
  elimination_->solve(trial_);
  const auto departs_by_more_than = [&](double part) {
    error_ = trial_ - unknowns_;
    return loses_more_than(part, lu.relative_size(error_, unknowns_), error_);
  };
  if (departs_by_more_than(kFarOff)) return;
  eliminates_ = is_eliminated_ = true;
  refinement_ = Refinement::none;
  if (!departs_by_more_than(kMagnified)) return;
  (void)elimination_->largest_residual(right_side_, trial_, least_unknowns_);
  elimination_->correct(trial_);
  refinement_ = departs_by_more_than(kMagnified) ? Refinement::exact : Refinement::rough;
}

const Solution& Dynamics::solve(Pivots pivots) {
  elimination_ = &places_.front().elimination;
  return solve(pivots, nullptr);
}

const Solution& Dynamics::solve(Pivots pivots, const Place* near) {
  equations_.moving_constraints().write_gamma(equations_.time(), gamma_);
  if (!factor_and_solve(pivots, near)) {
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

void Dynamics::keep_places(int n) {
  places_.reserve(1 + n);
  while (static_cast<int>(places_.size()) < 1 + n) places_.push_back(places_.front());
  elimination_ = &places_.front().elimination;
  is_eliminated_ = false;
}

const Solution& Dynamics::solve_at_place(int number, bool again, double t, const Eigen::Ref<const VecX>& q,
                                         const Eigen::Ref<const VecX>& Y) {
  equations_.update(t, q, Y);
  Place& place = places_[1 + number];
  elimination_ = &place.elimination;
  const bool is_near = std::exchange(place.is_known, false) && again;
  const Solution& solution = solve(Pivots::kept, is_near ? &place : nullptr);
  place.unknowns = unknowns_;
  place.is_known = is_eliminated_;
  return solution;
}

void Dynamics::accelerate(const Eigen::Ref<const VecX>& forces, Eigen::Ref<VecX> accelerations) {
  unknowns_.setZero();
  unknowns_.head(forces.size()) = forces;
  if (is_eliminated_) {
    elimination_->solve(unknowns_);
  } else {
    matrix_.lu().solve(unknowns_);
  }
  accelerations = unknowns_.head(forces.size());
}

/// Whether an error of the solution is more than a part of it: as a whole, or of the accelerations alone, which is
/// where the tiny equations of a body far lighter than those that lead it are seen.
bool Dynamics::loses_more_than(double part, double relative_error, const VecX& error) const {
  if (relative_error > part) return true;
  const auto n_Y = equations_.layout().n_Y();
  const double acceleration = largest_acceleration(equations_, unknowns_.head(n_Y));
  const auto in_units = error.head(n_Y).cwiseQuotient(equations_.units());
  return (in_units.array().abs() > part * acceleration).any();
}

std::optional<RowIndex> Dynamics::contradicted_row(const Solution& solution) {
  constexpr double kContradiction = 1e-7;
  if (std::all_of(active_.begin(), active_.end(), [](bool is_active) { return is_active; })) return std::nullopt;
  VecX solved(unknowns_.size());
  solved << solution.Ydot(), solution.lambda();
  unknowns_ << equations_.forces(), gamma_;
  matrix_.fill(equations_);
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
  return projection_.project(equations_, {matrix_.lu(), is_eliminated_ ? elimination_ : nullptr}, t, q, Y);
}

}  // namespace concord::cartesian
