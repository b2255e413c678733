#include "cartesian/equations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/error.h"

namespace concord::cartesian {

namespace {

std::vector<BodyInertia> make_inertias(const Model& model) {
  std::vector<BodyInertia> inertias;
  for (const Body& body : model.bodies) inertias.emplace_back(body);
  return inertias;
}

}  // namespace

Equations::Equations(const Model& model)
    : model_(model),
      layout_(model),
      inertias_(make_inertias(model)),
      constraints_(model, layout_),
      applied_(model, layout_, constraints_),
      Y_(VecX::Zero(layout_.n_Y())),
      forces_(VecX::Zero(layout_.n_Y())),
      gamma_(VecX::Zero(constraints_.n_rows())),
      residual_(VecX::Zero(constraints_.n_rows())),
      velocity_residual_(VecX::Zero(constraints_.n_rows())),
      Ydot_(VecX::Zero(layout_.n_Y())),
      lambda_(VecX::Zero(constraints_.n_rows())),
      step_(VecX::Zero(layout_.n_Y())) {
  for (int i = 0; i < layout_.n_bodies(); ++i)
    mass_matrices_.emplace_back(MatX::Zero(layout_.size_Y(i), layout_.size_Y(i)));
  use_rows(std::vector<bool>(constraints_.n_rows(), true));
}

void Equations::use_rows(const std::vector<bool>& active) {
  place_of_row_.assign(active.size(), -1);
  int place = layout_.n_Y();
  for (std::size_t row = 0; row < active.size(); ++row) {
    if (active[row]) place_of_row_[row] = place++;
  }
  unknowns_ = VecX::Zero(place);
  is_slip_place_.assign(place, false);
  for (std::size_t row = 0; row < active.size(); ++row) {
    if (active[row]) is_slip_place_[place_of_row_[row]] = !constraints_.holds_positions(static_cast<int>(row));
  }
  lay_out();
}

void Equations::lay_out() {
  const int size = static_cast<int>(unknowns_.size());
  std::vector<std::vector<int>> columns(size);
  for (int i = 1; i < layout_.n_bodies(); ++i) {
    for (int column = 0; column < layout_.size_Y(i); ++column) {
      for (int row = 0; row < layout_.size_Y(i); ++row) {
        columns[layout_.first_Y(i) + column].push_back(layout_.first_Y(i) + row);
      }
    }
  }
  for (const RowBlock& block : constraints_.blocks()) {
    for (int row = block.first_row; row < block.first_row + block.n_rows; ++row) {
      const int place = place_of_row_[row];
      if (place < 0) continue;
      for (int c = 0; c < layout_.size_Y(block.body); ++c) {
        columns[layout_.first_Y(block.body) + c].push_back(place);
        columns[place].push_back(layout_.first_Y(block.body) + c);
      }
    }
  }
  for (int row = 0; row < constraints_.n_rows(); ++row) {
    // Room for the unit rows of the position matrix.
    if (is_active(row) && !constraints_.holds_positions(row)) columns[place_of_row_[row]].push_back(place_of_row_[row]);
  }
  std::vector<int> starts{0};
  std::vector<int> rows;
  for (auto& column : columns) {
    std::sort(column.begin(), column.end());
    rows.insert(rows.end(), column.begin(), column.end());
    starts.push_back(static_cast<int>(rows.size()));
  }
  const auto make = [&] { return std::make_unique<SparseLu>(starts, rows, SparseLu::Pattern::symmetric); };
  matrix_ = make();
  position_matrix_ = constraints_.has_slip_rows() ? make() : nullptr;

  mass_entries_.assign(layout_.n_bodies(), {});
  for (int i = 1; i < layout_.n_bodies(); ++i) {
    for (int column = 0; column < layout_.size_Y(i); ++column) {
      mass_entries_[i].push_back(matrix_->find(layout_.first_Y(i), layout_.first_Y(i) + column));
    }
  }
  Phi_Y_entries_.assign(constraints_.blocks().size(), {});
  transposed_entries_.assign(constraints_.blocks().size(), {});
  for (std::size_t b = 0; b < constraints_.blocks().size(); ++b) {
    const RowBlock& block = constraints_.blocks()[b];
    const int first_Y = layout_.first_Y(block.body);
    int first_active = -1;
    for (int row = block.first_row; row < block.first_row + block.n_rows; ++row) {
      const int place = place_of_row_[row];
      transposed_entries_[b].push_back(place < 0 ? -1 : matrix_->find(first_Y, place));
      if (first_active < 0) first_active = place;
    }
    if (first_active < 0) continue;
    for (int c = 0; c < layout_.size_Y(block.body); ++c) {
      Phi_Y_entries_[b].push_back(matrix_->find(first_active, first_Y + c));
    }
  }
}

void Equations::count_turns_from(const std::vector<VecX>& q) {
  applied_.count_turns_from(q);
  constraints_.count_turns_from(q);
}

void Equations::update(double t, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y) {
  t_ = t;
  Y_ = Y;
  constraints_.place(q);
  constraints_.move(Y);
  constraints_.write_residual(t, residual_);
  constraints_.write_velocity_residual(t, velocity_residual_);
  for (int i = 1; i < layout_.n_bodies(); ++i) inertias_[i].update(layout_.a(q, i), layout_.adot(Y, i));
  for (int i = 1; i < layout_.n_bodies(); ++i) {
    inertias_[i].write_forces(constraints_.rotation(i), layout_.omega(Y, i), model_.gravity, layout_.a(q, i),
                              layout_.adot(Y, i), forces_.segment(layout_.first_Y(i), layout_.size_Y(i)));
  }
  applied_.update(t, q, Y);
  applied_.add_to(forces_);
}

void Equations::fill_mass_matrices() {
  for (int i = 1; i < layout_.n_bodies(); ++i) {
    inertias_[i].write_mass_matrix(constraints_.rotation(i), mass_matrices_[i]);
  }
}

void Equations::fill_matrix() {
  fill_mass_matrices();
  double* values = matrix_->values();
  for (int i = 1; i < layout_.n_bodies(); ++i) {
    const int size = layout_.size_Y(i);
    for (int column = 0; column < size; ++column) {
      std::copy_n(mass_matrices_[i].col(column).data(), size, values + mass_entries_[i][column]);
    }
  }
  for (std::size_t b = 0; b < constraints_.blocks().size(); ++b) {
    const auto& entries = Phi_Y_entries_[b];
    if (entries.empty()) continue;
    const Eigen::Ref<const MatX> Phi_Y_transposed = constraints_.columns(constraints_.blocks()[b]);
    const int size = static_cast<int>(entries.size());
    int active = 0;
    for (Eigen::Index row = 0; row < Phi_Y_transposed.cols(); ++row) {
      const int start = transposed_entries_[b][row];
      if (start < 0) continue;
      std::copy_n(Phi_Y_transposed.col(row).data(), size, values + start);
      for (int c = 0; c < size; ++c) values[entries[c] + active] = Phi_Y_transposed(c, row);
      ++active;
    }
  }
}

void Equations::solve(bool fresh_pivots) {
  constexpr double kRoundOff = 1e-15;                // of the right side
  constexpr double kGoodEnoughBetweenSteps = 1e-12;  // and with pivots chosen at another state
  constraints_.write_gamma(t_, gamma_);
  fill_matrix();
  const auto fill_right_side = [&] {
    unknowns_.head(layout_.n_Y()) = forces_;
    for (int row = 0; row < constraints_.n_rows(); ++row) {
      if (place_of_row_[row] >= 0) unknowns_(place_of_row_[row]) = gamma_(row);
    }
  };
  fill_right_side();
  bool good = false;
  if (!fresh_pivots) good = matrix_->refactor() && matrix_->solve_refined(unknowns_, kGoodEnoughBetweenSteps);
  if (!good) {
    fill_right_side();
    good = matrix_->factor() && matrix_->solve_refined(unknowns_, kRoundOff);
  }
  if (!good || !unknowns_.allFinite()) {
    throw SolverError(fmt::format(
        "cartesian: at t = {:.6g} s the equations of motion are singular: the machine is in a singular pose, or a body "
        "can move without inertia",
        t_));
  }
  Ydot_ = unknowns_.head(layout_.n_Y());
  for (int row = 0; row < constraints_.n_rows(); ++row) {
    lambda_(row) = place_of_row_[row] >= 0 ? unknowns_(place_of_row_[row]) : 0.0;
  }
}

/// From the numbers of the last fill_matrix(): rows and columns of what holds for velocities alone become those of the
/// identity, so that they neither restrict a step nor push it.
void Equations::factor_position_matrix() {
  const std::vector<int>& starts = matrix_->column_starts();
  const std::vector<int>& rows = matrix_->row_indices();
  const double* from = matrix_->values();
  double* to = position_matrix_->values();
  for (int column = 0; column < matrix_->size(); ++column) {
    for (int entry = starts[column]; entry < starts[column + 1]; ++entry) {
      const bool is_slip = is_slip_place_[column] || is_slip_place_[rows[entry]];
      to[entry] = is_slip ? (rows[entry] == column ? 1.0 : 0.0) : from[entry];
    }
  }
  if (!position_matrix_->refactor()) {
    throw SolverError(fmt::format("cartesian: at t = {:.6g} s the equations of position are singular", t_));
  }
}

void Equations::solve_constraint_step(SparseLu& matrix, const VecX& residual) {
  unknowns_.head(layout_.n_Y()).setZero();
  for (int row = 0; row < constraints_.n_rows(); ++row) {
    if (place_of_row_[row] >= 0) unknowns_(place_of_row_[row]) = -residual(row);
  }
  matrix.solve(unknowns_);
  step_ = unknowns_.head(layout_.n_Y());
}

std::string Equations::name_of_largest(const VecX& residual) const {
  Eigen::Index largest = 0;
  residual.cwiseAbs().maxCoeff(&largest);
  for (int k = 0; k < constraints_.n_joints(); ++k) {
    const JointEquations& joint = constraints_.joint(k);
    if (largest >= joint.first_row && largest < joint.first_row + joint.n_rows) {
      return fmt::format("joint '{}'", model_.joints[k].name);
    }
  }
  for (int g = 0; g < constraints_.n_couplings(); ++g) {
    if (largest == constraints_.coupling(g).row) return fmt::format("coupling '{}'", model_.couplings[g].name);
  }
  return {};
}

void Equations::project(double t, Eigen::Ref<VecX> q, Eigen::Ref<VecX> Y) {
  constexpr int kMostSteps = 12;
  constexpr double kRoundOff = 2e-15;
  constexpr double kAllowed = 1e-9;
  layout_.normalize(q);
  if (constraints_.n_rows() == 0) return;
  if (position_matrix_) factor_position_matrix();
  SparseLu& position_matrix = position_matrix_ ? *position_matrix_ : *matrix_;
  double last = HUGE_VAL;
  for (int step = 0; step < kMostSteps; ++step) {
    constraints_.place(q);
    constraints_.write_residual(t, residual_);
    const double size = residual_.lpNorm<Eigen::Infinity>();
    if (size <= kRoundOff || (size < kAllowed && size > 0.5 * last)) break;
    last = size;
    solve_constraint_step(position_matrix, residual_);
    layout_.displace(step_, q);
  }
  if (!(residual_.lpNorm<Eigen::Infinity>() <= kAllowed)) {
    throw SolverError(fmt::format(
        "cartesian: at t = {:.6g} s {} will not close: gap {:.3g} (m or rad), allowed {:.3g}; it was closed at "
        "the start: tighten the tolerance",
        t, name_of_largest(residual_), residual_.lpNorm<Eigen::Infinity>(), kAllowed));
  }
  const double speed = 1.0 + Y.lpNorm<Eigen::Infinity>();
  last = HUGE_VAL;
  for (int step = 0; step < kMostSteps; ++step) {
    constraints_.move(Y);
    constraints_.write_velocity_residual(t, velocity_residual_);
    const double size = velocity_residual_.lpNorm<Eigen::Infinity>();
    if (size <= kRoundOff * speed || (size < kAllowed * speed && size > 0.5 * last)) return;
    last = size;
    solve_constraint_step(*matrix_, velocity_residual_);
    Y += step_;
  }
  throw SolverError(fmt::format("cartesian: at t = {:.6g} s the velocities of {} will not close: residual {:.3g}", t,
                                name_of_largest(velocity_residual_), velocity_residual_.lpNorm<Eigen::Infinity>()));
}

double Equations::power_of(const Eigen::Ref<const VecX>& lambda) const {
  double sum = applied_.power(Y_);
  for (int k = 0; k < constraints_.n_joints(); ++k) {
    const JointEquations& joint = constraints_.joint(k);
    for (int row = joint.first_driver; row < joint.n_rows; ++row) {
      const Driver& driver = model_.joints[k].drivers[row - joint.first_driver];
      sum -= lambda(joint.first_row + row) * evaluate(driver.law, t_).fdot;
    }
  }
  for (int i = 1; i < layout_.n_bodies(); ++i) sum -= inertias_[i].damping_power(layout_.adot(Y_, i));
  return sum;
}

void Equations::add_Phi_Y_transposed_times(const Eigen::Ref<const VecX>& x, Eigen::Ref<VecX> sum) const {
  for (const RowBlock& block : constraints_.blocks()) {
    const Eigen::Ref<const MatX> Phi_Y_transposed = constraints_.columns(block);
    for (int row = 0; row < block.n_rows; ++row) {
      if (!is_active(block.first_row + row)) continue;
      sum.segment(layout_.first_Y(block.body), layout_.size_Y(block.body)) +=
          x(block.first_row + row) * Phi_Y_transposed.col(row);
    }
  }
}

void Equations::write_mass_times(const Eigen::Ref<const VecX>& x, Eigen::Ref<VecX> product) const {
  for (int i = 1; i < layout_.n_bodies(); ++i) {
    product.segment(layout_.first_Y(i), layout_.size_Y(i)).noalias() =
        mass_matrices_[i] * x.segment(layout_.first_Y(i), layout_.size_Y(i));
  }
}

}  // namespace concord::cartesian
