#include "cartesian/equations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/error.h"

namespace concord::cartesian {

namespace {

// Of projections, in the machine's units.
constexpr int kMostProjections = 12;
constexpr double kProjected = 1e-15;
constexpr double kProjectionLimit = 1e-9;

std::vector<BodyInertia> make_inertias(const Model& model) {
  std::vector<BodyInertia> inertias;
  for (const Body& body : model.bodies) inertias.emplace_back(body);
  return inertias;
}

/// The time squared in which a body's modes, the slowest that has a stiffness too, resist as if they were a million
/// times heavier [s^2].
double stiffening_of(const BodyInertia& inertia) {
  constexpr double kHeavier = 1e6;
  constexpr double kStiff = 1e-9;  // of the body's largest frequency squared: below, a mode is free
  const VecX squared = inertia.stiffness().diagonal().cwiseQuotient(inertia.modal_mass().diagonal());
  double slowest = HUGE_VAL;
  for (const double one : squared) {
    if (one > kStiff * squared.maxCoeff()) slowest = std::min(slowest, one);
  }
  return slowest < HUGE_VAL ? kHeavier / slowest : 0.0;
}

/// Size of a mode's rate that moves some joint of its body by `length` per second (C44).
double modal_unit(const Model& model, int body, int mode, double length) {
  double largest = 0.0;
  for (const Joint& joint : model.joints) {
    for (const Attachment& side : joint.sides) {
      if (side.body != body) continue;
      largest = std::max(largest, side.Psi_t_L.col(mode).norm());
      largest = std::max(largest, side.Psi_r_L.col(mode).norm() * length);
    }
  }
  if (largest > 0.0) return length / largest;
  // It moves no joint: by its size at a typical mass point.
  const BodyInertia inertia(model.bodies[body]);
  const double shape = std::sqrt(inertia.modal_mass()(mode, mode) / inertia.mass());
  return shape > 0.0 && std::isfinite(shape) ? length / shape : 1.0;
}

VecX machine_units(const Model& model, const Layout& layout) {
  const double length = model.length_scale();
  VecX units = VecX::Ones(layout.n_Y());
  for (int i = 1; i < layout.n_bodies(); ++i) {
    layout.v(units, i).setConstant(length);
    for (int mode = 0; mode < layout.n_modes(i); ++mode) {
      layout.adot(units, i)(mode) = modal_unit(model, i, mode, length);
    }
  }
  return units;
}

}  // namespace

Equations::Equations(const Model& model)
    : model_(model),
      length_(model.length_scale()),
      layout_(model),
      inertias_(make_inertias(model)),
      constraints_(model, layout_),
      applied_(model, layout_, constraints_),
      Y_(VecX::Zero(layout_.n_Y())),
      forces_(VecX::Zero(layout_.n_Y())),
      gamma_(VecX::Zero(constraints_.n_rows())),
      residual_(VecX::Zero(constraints_.n_rows())),
      velocity_residual_(VecX::Zero(constraints_.n_rows())),
      units_(machine_units(model, layout_)),
      row_sizes_(VecX::Zero(constraints_.n_rows())),
      terms_(VecX::Ones(constraints_.n_rows())),
      reaches_(VecX::Ones(constraints_.n_rows())),
      Ydot_(VecX::Zero(layout_.n_Y())),
      lambda_(VecX::Zero(constraints_.n_rows())),
      step_(VecX::Zero(layout_.n_Y())) {
  for (int i = 0; i < layout_.n_bodies(); ++i)
    mass_matrices_.emplace_back(MatX::Zero(layout_.size_Y(i), layout_.size_Y(i)));
  for (const BodyInertia& inertia : inertias_) stiffening_.push_back(stiffening_of(inertia));
  lay_out();
  use_rows(std::vector<bool>(constraints_.n_rows(), true));
}

void Equations::use_rows(const std::vector<bool>& active) {
  if (active == active_) return;
  active_ = active;
  std::vector<bool> idle(unknowns_.size(), false);
  for (int row = 0; row < constraints_.n_rows(); ++row) idle[index_of(row)] = !active[row];
  matrix_->set_idle(idle);
  has_new_rows_ = true;
  if (!position_matrix_) return;
  for (int row = 0; row < constraints_.n_rows(); ++row) {
    idle[index_of(row)] = !active[row] || !constraints_.holds_positions(row);
  }
  position_matrix_->set_idle(idle);
  has_new_position_rows_ = true;
}

void Equations::lay_out() {
  const int size = layout_.n_Y() + constraints_.n_rows();
  unknowns_ = VecX::Zero(size);
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
      for (int c = 0; c < layout_.size_Y(block.body); ++c) {
        columns[layout_.first_Y(block.body) + c].push_back(index_of(row));
        columns[index_of(row)].push_back(layout_.first_Y(block.body) + c);
      }
    }
  }
  for (int row = 0; row < constraints_.n_rows(); ++row) columns[index_of(row)].push_back(index_of(row));
  std::vector<int> starts{0};
  std::vector<int> rows;
  for (auto& column : columns) {
    std::sort(column.begin(), column.end());
    rows.insert(rows.end(), column.begin(), column.end());
    starts.push_back(static_cast<int>(rows.size()));
  }
  double mass = 0.0;
  for (const BodyInertia& inertia : inertias_) mass += inertia.mass();
  if (mass > 0.0) mass_unit_ = std::ldexp(1.0, std::ilogb(mass));
  const auto make = [&] {
    auto matrix = std::make_unique<SparseLu>(starts, rows, SparseLu::Pattern::symmetric);
    matrix->set_diagonal_unit(mass_unit_);
    return matrix;
  };
  matrix_ = make();
  if (constraints_.has_nonholonomic_rows() || model_.is_flexible()) position_matrix_ = make();
  find_entries();
}

void Equations::find_entries() {
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
    for (int row = block.first_row; row < block.first_row + block.n_rows; ++row) {
      transposed_entries_[b].push_back(matrix_->find(first_Y, index_of(row)));
    }
    for (int c = 0; c < layout_.size_Y(block.body); ++c) {
      Phi_Y_entries_[b].push_back(matrix_->find(index_of(block.first_row), first_Y + c));
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
  has_row_sizes_ = false;
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
    const Eigen::Ref<const MatX> Phi_Y_transposed = constraints_.columns(constraints_.blocks()[b]);
    const int size = static_cast<int>(entries.size());
    for (Eigen::Index row = 0; row < Phi_Y_transposed.cols(); ++row) {
      std::copy_n(Phi_Y_transposed.col(row).data(), size, values + transposed_entries_[b][row]);
      for (int c = 0; c < size; ++c) values[entries[c] + row] = Phi_Y_transposed(c, row);
    }
  }
}

void Equations::solve(bool fresh_pivots) {
  constexpr double kGoodEnoughBetweenSteps = 1e-12;  // and with pivots chosen at another state
  constraints_.write_gamma(t_, gamma_);
  fill_matrix();
  const auto fill_right_side = [&] {
    unknowns_.head(layout_.n_Y()) = forces_;
    for (int row = 0; row < constraints_.n_rows(); ++row) unknowns_(index_of(row)) = active_[row] ? gamma_(row) : 0.0;
  };
  fill_right_side();
  bool good = false;
  if (!fresh_pivots && !has_new_rows_) {
    good = matrix_->refactor() && matrix_->solve_refined(unknowns_, magnifies_ ? 0.0 : kGoodEnoughBetweenSteps);
  }
  if (!good) {
    fill_right_side();
    good = matrix_->factor() && matrix_->solve_refined(unknowns_, 0.0);
    magnifies_ = good && magnifies_round_off();
    has_new_rows_ = false;
  }
  if (!good) {
    throw SingularPose(fmt::format(
        "cartesian: at t = {:.6g} s the equations of motion are singular: the machine is in a singular pose, or a body "
        "can move without inertia",
        t_));
  }
  Ydot_ = unknowns_.head(layout_.n_Y());
  lambda_ = unknowns_.tail(constraints_.n_rows());
}

/// The largest of what gravity, speeds and forces cause, in the machine's units [1/s2].
double Equations::typical_acceleration(const Eigen::Ref<const VecX>& Ydot) const {
  const double rate = natural_rate();
  return std::max(
      {rate * rate, Y_.cwiseQuotient(units_).cwiseAbs2().maxCoeff(), Ydot.cwiseQuotient(units_).cwiseAbs().maxCoeff()});
}

/// Whether the last solution needed correcting: as a whole, or the accelerations alone, which is where the tiny
/// equations of a body far lighter than those that lead it are seen.
bool Equations::magnifies_round_off() const {
  constexpr double kMagnified = 1e-13;
  if (matrix_->relative_correction() > kMagnified) return true;
  const auto n_Y = layout_.n_Y();
  const double acceleration = typical_acceleration(unknowns_.head(n_Y));
  return (matrix_->first_correction().head(n_Y).cwiseQuotient(units_).array().abs() > kMagnified * acceleration).any();
}

std::optional<int> Equations::contradicted_row() {
  constexpr double kContradiction = 1e-7;
  if (std::all_of(active_.begin(), active_.end(), [](bool is_active) { return is_active; })) return std::nullopt;
  VecX solution(unknowns_.size());
  solution << Ydot_, lambda_;
  unknowns_ << forces_, gamma_;
  matrix_->subtract_product(solution, unknowns_);
  double worst = kContradiction * typical_acceleration(Ydot_);
  std::optional<int> found;
  for (int row = 0; row < constraints_.n_rows(); ++row) {
    if (active_[row] || !(row_sizes()(row) > 0.0)) continue;
    const double misfit = std::abs(unknowns_(index_of(row))) / row_sizes()(row);
    if (misfit <= worst) continue;
    worst = misfit;
    found = row;
  }
  return found;
}

/// Adds to the inertia of each mode what its stiffness resists: it takes no part in closing the joints, unless nothing
/// else can (C48).
void Equations::stiffen_modes() {
  double* values = position_matrix_->values();
  for (int i = 1; i < layout_.n_bodies(); ++i) {
    const MatX& stiffness = inertias_[i].stiffness();
    for (int k = 0; k < layout_.n_modes(i); ++k) {
      double* column = values + mass_entries_[i][6 + k] + 6;
      for (int l = 0; l < layout_.n_modes(i); ++l) column[l] += stiffening_[i] * stiffness(l, k);
    }
  }
}

void Equations::factor_position_matrix() {
  std::copy_n(matrix_->values(), matrix_->row_indices().size(), position_matrix_->values());
  stiffen_modes();
  const bool is_regular = has_new_position_rows_ ? position_matrix_->factor() : position_matrix_->refactor();
  has_new_position_rows_ = false;
  if (!is_regular) {
    throw SolverError(fmt::format("cartesian: at t = {:.6g} s the equations of position are singular", t_));
  }
}

void Equations::solve_constraint_step(SparseLu& matrix, const VecX& residual) {  // (C48)
  unknowns_.head(layout_.n_Y()).setZero();
  for (int row = 0; row < constraints_.n_rows(); ++row) {
    unknowns_(index_of(row)) = active_[row] ? -residual(row) : 0.0;
  }
  matrix.solve(unknowns_);
  step_ = unknowns_.head(layout_.n_Y());
}

void Equations::measure_rows() const {  // (C45)
  const auto norm_of = [&](int k, int row) {
    double squared = 0.0;
    for (const Side side : {Side::parent, Side::child}) {
      const int body = model_.joints[k].on(side).body;
      if (body == kGround) continue;
      const auto over_Y = constraints_.joint(k).Phi_Y_transposed[index(side)].col(row);
      squared += over_Y.cwiseProduct(units_.segment(layout_.first_Y(body), over_Y.size())).squaredNorm();
    }
    return std::sqrt(squared);
  };
  for (int k = 0; k < constraints_.n_joints(); ++k) {
    const JointEquations& joint = constraints_.joint(k);
    for (int row = 0; row < joint.n_rows; ++row) row_sizes_(joint.first_row + row) = norm_of(k, row);
  }
  for (int g = 0; g < constraints_.n_couplings(); ++g) {
    const CouplingEquations& coupling = constraints_.coupling(g);
    double sum = 0.0;
    for (const CouplingEquations::Term& term : coupling.terms)
      sum += std::abs(term.factor) * norm_of(term.joint, term.row);
    row_sizes_(coupling.row) = sum;
  }
  has_row_sizes_ = true;
}

void Equations::measure_terms(double t, const Eigen::Ref<const VecX>& q) {
  reach_ = 1.0;
  for (int i = 1; i < layout_.n_bodies(); ++i) {
    reach_ = std::max(reach_, layout_.r(q, i).lpNorm<Eigen::Infinity>() / length_);
  }
  for (int k = 0; k < constraints_.n_joints(); ++k) {
    for (const Marker& marker : constraints_.joint(k).markers) {
      const double far = std::max(marker.lever.lpNorm<Eigen::Infinity>(), marker.point.lpNorm<Eigen::Infinity>());
      reach_ = std::max(reach_, far / length_);
    }
  }
  constraints_.write_own_terms(t, terms_);
  constraints_.write_reaches(reach_, reaches_);
  for (int row = 0; row < constraints_.n_rows(); ++row) {
    const double own = row_sizes()(row) > 0.0 ? terms_(row) / row_sizes()(row) : 0.0;
    terms_(row) = std::max(reaches_(row), own);
  }
}

double Equations::compliance(int body, int mode) const {
  constexpr double kLeast = 1e-4;  // far above what counts as dependent where nothing but modes can close a machine
  const BodyInertia& inertia = inertias_[body];
  const double stiffer = stiffening_[body] * inertia.stiffness()(mode, mode) / inertia.modal_mass()(mode, mode);
  return std::max(kLeast, 1.0 / std::sqrt(1.0 + std::max(0.0, stiffer)));
}

double Equations::largest_residual(const VecX& residual) const {
  double largest = 0.0;
  for (int row = 0; row < constraints_.n_rows(); ++row) {
    const double size = row_sizes()(row) > 0.0 ? row_sizes()(row) : 1.0;
    const double own = std::abs(residual(row)) / (size * terms_(row));
    if (std::isnan(own)) return own;
    largest = std::max(largest, own);
  }
  return largest;
}

double Equations::largest_velocity_residual(const VecX& velocity_residual) const {
  double largest = 0.0;
  for (int row = 0; row < constraints_.n_rows(); ++row) {
    const double size = row_sizes()(row) > 0.0 ? row_sizes()(row) : 1.0;
    const double own = std::abs(velocity_residual(row)) / size;
    if (std::isnan(own)) return own;
    largest = std::max(largest, own);
  }
  return largest;
}

double Equations::natural_rate() const {
  double acceleration = 0.0;
  for (int i = 1; i < layout_.n_bodies(); ++i) {
    if (!(inertias_[i].mass() > 0.0)) continue;
    acceleration = std::max(acceleration, layout_.v(forces_, i).lpNorm<Eigen::Infinity>() / inertias_[i].mass());
  }
  return std::sqrt(acceleration / length_);
}

double Equations::largest_velocity_residual_by_reach(const VecX& velocity_residual) const {
  return largest_velocity_residual(velocity_residual.cwiseQuotient(reaches_));
}

double Equations::largest_rate(double t, const Eigen::Ref<const VecX>& Y) const {
  constexpr double kAtRest = 1e-6;
  double largest = kAtRest * natural_rate();
  for (Eigen::Index c = 0; c < Y.size(); ++c) largest = std::max(largest, std::abs(Y(c)) / units_(c));
  for (int k = 0; k < constraints_.n_joints(); ++k) {
    const JointEquations& joint = constraints_.joint(k);
    for (int row = joint.first_driver; row < joint.n_rows; ++row) {
      const double size = row_sizes()(joint.first_row + row);
      const Driver& driver = model_.joints[k].drivers[row - joint.first_driver];
      if (size > 0.0) largest = std::max(largest, std::abs(evaluate(driver.law, t).fdot) / size);
    }
  }
  return largest;
}

std::string Equations::name_of(int wanted) const {
  for (int k = 0; k < constraints_.n_joints(); ++k) {
    const JointEquations& joint = constraints_.joint(k);
    if (wanted >= joint.first_row && wanted < joint.first_row + joint.n_rows) {
      return fmt::format("joint '{}'", model_.joints[k].name);
    }
  }
  for (int g = 0; g < constraints_.n_couplings(); ++g) {
    if (wanted == constraints_.coupling(g).row) return fmt::format("coupling '{}'", model_.couplings[g].name);
  }
  return {};
}

std::string Equations::name_of_largest(const VecX& residual) const {
  int largest = 0;
  double size = -1.0;
  for (int row = 0; row < constraints_.n_rows(); ++row) {
    const double own = std::abs(residual(row)) / (row_sizes()(row) > 0.0 ? row_sizes()(row) : 1.0);
    if (own <= size) continue;
    size = own;
    largest = row;
  }
  return name_of(largest);
}

void Equations::project(double t, Eigen::Ref<VecX> q, Eigen::Ref<VecX> Y) {
  layout_.normalize(q);
  if (constraints_.n_rows() == 0) return;
  project_positions(t, q);
  project_velocities(t, Y);
}

void Equations::project_positions(double t, Eigen::Ref<VecX> q) {
  if (position_matrix_) factor_position_matrix();
  SparseLu& matrix = position_matrix_ ? *position_matrix_ : *matrix_;
  measure_terms(t, q);
  double size = HUGE_VAL;
  for (int step = 0; step < kMostProjections; ++step) {
    constraints_.place(q);
    constraints_.write_residual(t, residual_);
    const double last = size;
    size = largest_residual(residual_);
    if (size <= kProjected || (size < kProjectionLimit && size > 0.5 * last)) return;
    solve_constraint_step(matrix, residual_);
    layout_.displace(step_, q);
  }
  if (size <= kProjectionLimit) return;
  throw SolverError(
      fmt::format("cartesian: at t = {:.6g} s {} will not close: residual {:.3g} (of the machine's length, or rad), "
                  "allowed {:.3g}; it was closed at the start: tighten the tolerance",
                  t, name_of_largest(residual_), size, kProjectionLimit));
}

void Equations::project_velocities(double t, Eigen::Ref<VecX> Y) {
  const double speed = largest_rate(t, Y);
  double size = HUGE_VAL;
  for (int step = 0; step < kMostProjections; ++step) {
    constraints_.move(Y);
    constraints_.write_velocity_residual(t, velocity_residual_);
    const double last = size;
    size = largest_velocity_residual(velocity_residual_);
    if (size <= kProjected * speed || (size < kProjectionLimit * speed && size > 0.5 * last)) return;
    solve_constraint_step(*matrix_, velocity_residual_);
    Y += step_;
  }
  throw SolverError(fmt::format(
      "cartesian: at t = {:.6g} s the velocities of {} will not close: residual {:.3g} of the largest speed", t,
      name_of_largest(velocity_residual_), size / speed));
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
