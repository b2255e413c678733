#include "cartesian/run/ida_jacobian.h"

#include <algorithm>
#include <utility>

#include "cartesian/bodies/euler_parameters.h"

namespace concord::cartesian {

IdaUnknowns::IdaUnknowns(const Equations& equations) {
  const Layout& layout = equations.layout();
  n_rows = equations.constraints().n_rows();
  for (const RowIndex row : rows()) {
    place_of_mu.push_back(equations.constraints().holds_positions(row) ? n_mu++ : -1);
  }
  n_nu = layout.n_bodies() - 1;
  first_Y = layout.n_q();
  first_lambda = first_Y + layout.n_Y();
  first_mu = first_lambda + n_rows;
  first_nu = first_mu + n_mu;
  at_work = first_nu + n_nu;
  size = at_work + 1;
}

namespace {

/// pdot = E(p)^T omega / 2 = Omega(omega) p / 2: the matrix Omega / 2 (C62).
Eigen::Matrix4d compute_Omega_half(const Vec3& omega) {
  Eigen::Matrix4d half;
  for (int k = 0; k < 4; ++k) half.col(k) = compute_pdot(Vec4::Unit(k), omega);
  return half;
}

}  // namespace

IdaJacobian::IdaJacobian(const Dynamics& dynamics, const IdaUnknowns& places, const VecX& q, const VecX& Y)
    : dynamics_(dynamics),
      own_(dynamics.equations().model()),
      layout_(own_.layout()),
      places_(places),
      mass_matrices_(make_mass_matrices(layout_)) {
  for (const RowBlock& block : own_.constraints().blocks()) {
    rates_over_q_.emplace_back(MatX::Zero(block.n_rows, layout_.size_Y(block.body)));
  }
  for (const AppliedForce& applied : own_.applied().applied_forces()) slopes_.add(make_slopes(applied));
  lay_out(q, Y);
}

IdaJacobian::ForceSlopes IdaJacobian::make_slopes(const AppliedForce& applied) const {
  ForceSlopes slopes;
  for (const Side moved : {Side::parent, Side::child}) {
    for (const Side pushed : {Side::parent, Side::child}) {
      if (!applied.sits_on_moving_body(moved) || !applied.sits_on_moving_body(pushed)) continue;
      const MatX none = MatX::Zero(layout_.size_Y(applied.body(pushed)), layout_.size_Y(applied.body(moved)));
      slopes.over_q[index(moved)][index(pushed)] = none;
      slopes.over_Y[index(moved)][index(pushed)] = none;
    }
  }
  return slopes;
}

/// How Phi_Y Y of each block's rows changes with the positions of its body, by central differences of the joints
/// concerned alone: small entries, but Newton's method on the velocity rows needs them, since velocities follow
/// positions at once.
void IdaJacobian::differentiate_rates(const VecX& q, const Eigen::Ref<const VecX>& Y) {
  const auto& blocks = own_.constraints().blocks();
  for (std::size_t b = 0; b < blocks.size(); ++b) differentiate_rates(blocks[b], q, Y, rates_over_q_[b]);
}

void IdaJacobian::differentiate_rates(const RowBlock& block, const VecX& q, const Eigen::Ref<const VecX>& Y,
                                      MatX& rates) {
  constexpr double kStep = 1e-6;  // of the machine's units
  MovingConstraints& constraints = own_.moving_constraints();
  const auto units = own_.units().segment(layout_.first_Y(block.body), layout_.size_Y(block.body));
  displaced_q_ = q;
  for (int c = 0; c < layout_.size_Y(block.body); ++c) {
    rates.col(c).setZero();
    const double step = kStep * units(c);
    for (const double sign : {1.0, -1.0}) {
      layout_.displace_along(block.body, c, sign * step, displaced_q_);
      constraints.displace(block, displaced_q_, Y);
      for (int row = 0; row < rates.rows(); ++row) {
        rates(row, c) += sign * constraints.row_rate(block, row) / (2.0 * step);
      }
      layout_.copy_body(block.body, q, displaced_q_);
    }
  }
  constraints.displace(block, q, Y);
}

/// How the forces of each applied force change with positions and velocities of the bodies that it pushes on, by
/// central differences of the applied force alone.
void IdaJacobian::differentiate_forces(double t, double rate, const VecX& q, const Eigen::Ref<const VecX>& Y) {
  const ByAppliedForce<AppliedForce>& applied_forces = own_.applied().applied_forces();
  for (const AppliedForceIndex a : applied_forces.indices()) {
    for (const Side moved : {Side::parent, Side::child}) {
      if (!applied_forces[a].sits_on_moving_body(moved)) continue;
      differentiate_forces(a, moved, t, rate, q, Y, slopes_[a]);
    }
  }
}

void IdaJacobian::differentiate_forces(AppliedForceIndex of, Side moved, double t, double rate, const VecX& q,
                                       const Eigen::Ref<const VecX>& Y, ForceSlopes& slopes) {
  constexpr double kStep = 1e-6;  // of the machine's units
  const AppliedForce& applied = own_.applied().applied_forces()[of];
  const BodyIndex body = applied.body(moved);
  const auto units = own_.units().segment(layout_.first_Y(body), layout_.size_Y(body));
  const auto put = [&](const VecX& at, const VecX& speeds) {
    if (const std::optional<JointIndex> joint = applied.joint()) {
      own_.moving_constraints().displace(*joint, body, at, speeds);
    } else {
      own_.moving_constraints().displace(body, at);
    }
    own_.applied().update(own_.moving_constraints(), of, t, at, speeds);
  };
  const auto add = [&](std::array<MatX, 2>& slope, int c, double over) {
    for (const Side pushed : {Side::parent, Side::child}) {
      if (!applied.sits_on_moving_body(pushed)) continue;
      slope[index(pushed)].col(c) += applied.forces[index(pushed)] / (2.0 * over);
    }
  };
  displaced_q_ = q;
  displaced_Y_ = Y;
  for (int c = 0; c < layout_.size_Y(body); ++c) {
    for (const Side pushed : {Side::parent, Side::child}) {
      if (!applied.sits_on_moving_body(pushed)) continue;
      slopes.over_q[index(moved)][index(pushed)].col(c).setZero();
      slopes.over_Y[index(moved)][index(pushed)].col(c).setZero();
    }
    for (const double step : {kStep * units(c), -kStep * units(c)}) {
      layout_.displace_along(body, c, step, displaced_q_);
      put(displaced_q_, displaced_Y_);
      add(slopes.over_q[index(moved)], c, step);
      layout_.copy_body(body, q, displaced_q_);
    }
    double& speed = displaced_Y_(layout_.first_Y(body) + c);
    const double kept = speed;
    for (const double step : {kStep * rate * units(c), -kStep * rate * units(c)}) {
      speed = kept + step;
      put(displaced_q_, displaced_Y_);
      add(slopes.over_Y[index(moved)], c, step);
    }
    speed = kept;
  }
  put(displaced_q_, displaced_Y_);
}

/// dF/dx + c dF/dxdot without the terms that a short step makes small (how M, S and the direction of the constraint
/// forces change with position): enough for Newton's method. The visitor sees every entry, in the same order each
/// time.
template <class Visit>
void IdaJacobian::each_entry(double c, const Eigen::Ref<const VecX>& x, const Visit& visit) const {
  const auto q = x.head(places_.first_Y);
  const auto Y = x.segment(places_.first_Y, layout_.n_Y());
  for (const BodyIndex i : layout_.moving_bodies()) each_body_entry(i, c, q, Y, visit);
  const auto& blocks = own_.constraints().blocks();
  for (std::size_t b = 0; b < blocks.size(); ++b) each_row_entry(blocks[b], rates_over_q_[b], q, visit);
  const ByAppliedForce<AppliedForce>& applied_forces = own_.applied().applied_forces();
  for (const AppliedForceIndex a : applied_forces.indices()) each_force_entry(applied_forces[a], slopes_[a], q, visit);
  for (const RowIndex row : places_.rows()) {
    const double own = dynamics_.is_active(row) ? 0.0 : 1.0;
    visit(places_.at_lambda(row), places_.at_lambda(row), own);
    if (places_.has_mu(row)) visit(places_.at_mu(row), places_.at_mu(row), own);
  }
  visit(places_.at_work, places_.at_work, c);
}

template <class Q, class V, class Visit>
void IdaJacobian::each_body_entry(BodyIndex i, double c, const Q& q, const V& Y, const Visit& visit) const {
  const int m = layout_.n_modes(i);
  const int at_r = layout_.first_q(i);
  const int at_p = at_r + 3;
  const int at_a = at_r + 7;
  const int at_v = places_.first_Y + layout_.first_Y(i);
  const int at_omega = at_v + 3;
  const int at_adot = at_v + 6;
  const int at_nu = places_.at_nu(i);
  const Vec4 p = layout_.p(q, i);
  const Eigen::Matrix4d Omega_half = compute_Omega_half(layout_.omega(Y, i));
  const Mat34 E = compute_E(p);
  for (int k = 0; k < 3; ++k) {
    visit(at_r + k, at_r + k, c);
    visit(at_r + k, at_v + k, -1.0);
  }
  for (int row = 0; row < 4; ++row) {
    for (int k = 0; k < 4; ++k) visit(at_p + row, at_p + k, (row == k ? c : 0.0) - Omega_half(row, k));
    for (int k = 0; k < 3; ++k) visit(at_p + row, at_omega + k, -0.5 * E(k, row));
    visit(at_p + row, at_nu, -p(row));
    visit(at_nu, at_p + row, p(row));
  }
  const MatX& M = mass_matrices_[i];
  for (int column = 0; column < 6 + m; ++column) {
    for (int row = 0; row < 6 + m; ++row) {
      double value = c * M(row, column);
      if (row >= 6 && column >= 6) value += own_.inertia(i).damping()(row - 6, column - 6);
      visit(at_v + row, at_v + column, value);
    }
  }
  for (int k = 0; k < m; ++k) {
    visit(at_a + k, at_a + k, c);
    visit(at_a + k, at_adot + k, -1.0);
    for (int l = 0; l < m; ++l) visit(at_adot + k, at_a + l, own_.inertia(i).stiffness()(k, l));
  }
}

template <class Q, class Visit>
void IdaJacobian::each_row_entry(const RowBlock& block, const MatX& rates, const Q& q,
                                 const Visit& visit) const {  // (C62)
  const Eigen::Ref<const MatX> Phi_Y_transposed = own_.moving_constraints().columns(block);
  const BodyIndex body = block.body;
  const int at_q = layout_.first_q(body);
  const int at_Y = places_.first_Y + layout_.first_Y(body);
  const int m = layout_.n_modes(body);
  const Mat34 E = compute_E(layout_.p(q, body));
  const auto squared_units = own_.units().segment(layout_.first_Y(body), 6 + m).cwiseAbs2();
  for (int row = 0; row < block.n_rows; ++row) {
    const RowIndex place = block.row(row);
    const int at_lambda = places_.at_lambda(place);
    const double share = dynamics_.is_active(place) ? 1.0 : 0.0;
    const VecX Phi_Y = share * Phi_Y_transposed.col(row);
    for (int k = 0; k < 6 + m; ++k) {
      visit(at_Y + k, at_lambda, Phi_Y(k));
      visit(at_lambda, at_Y + k, Phi_Y(k));
    }
    const Vec4 over_p = 2.0 * E.transpose() * Phi_Y.segment<3>(3);  // dpi = 2 E dp
    const VecX rate = share * rates.row(row);
    const Vec4 rate_over_p = 2.0 * E.transpose() * rate.segment<3>(3);
    for (int k = 0; k < 3; ++k) visit(at_lambda, at_q + k, rate(k));
    for (int k = 0; k < 4; ++k) visit(at_lambda, at_q + 3 + k, rate_over_p(k));
    for (int k = 0; k < m; ++k) visit(at_lambda, at_q + 7 + k, rate(6 + k));
    if (!places_.has_mu(place)) continue;
    const int at_mu = places_.at_mu(place);
    for (int k = 0; k < 3; ++k) visit(at_mu, at_q + k, Phi_Y(k));
    for (int k = 0; k < 4; ++k) visit(at_mu, at_q + 3 + k, over_p(k));
    for (int k = 0; k < m; ++k) visit(at_mu, at_q + 7 + k, Phi_Y(6 + k));
    for (int k = 0; k < 3; ++k) visit(at_q + k, at_mu, -squared_units(k) * Phi_Y(k));
    for (int k = 0; k < 4; ++k) visit(at_q + 3 + k, at_mu, -0.25 * over_p(k));
    for (int k = 0; k < m; ++k) visit(at_q + 7 + k, at_mu, -squared_units(6 + k) * Phi_Y(6 + k));
  }
}

template <class Q, class Visit>
void IdaJacobian::each_force_entry(const AppliedForce& applied, const ForceSlopes& slopes, const Q& q,
                                   const Visit& visit) const {
  for (const Side moved : {Side::parent, Side::child}) {
    if (!applied.sits_on_moving_body(moved)) continue;
    const BodyIndex body = applied.body(moved);
    const int at_q = layout_.first_q(body);
    const int at_Y = places_.first_Y + layout_.first_Y(body);
    const Mat34 E = compute_E(layout_.p(q, body));
    for (const Side pushed : {Side::parent, Side::child}) {
      if (!applied.sits_on_moving_body(pushed)) continue;
      const int at_row = places_.first_Y + layout_.first_Y(applied.body(pushed));
      const MatX& over_q = slopes.over_q[index(moved)][index(pushed)];
      const MatX& over_Y = slopes.over_Y[index(moved)][index(pushed)];
      for (Eigen::Index row = 0; row < over_q.rows(); ++row) {
        const Vec4 over_p = 2.0 * E.transpose() * over_q.row(row).template segment<3>(3).transpose();  // dpi = 2 E dp
        for (int k = 0; k < 3; ++k) visit(at_row + row, at_q + k, -over_q(row, k));
        for (int k = 0; k < 4; ++k) visit(at_row + row, at_q + 3 + k, -over_p(k));
        for (int k = 6; k < over_q.cols(); ++k) visit(at_row + row, at_q + 1 + k, -over_q(row, k));
        for (int k = 0; k < over_Y.cols(); ++k) visit(at_row + row, at_Y + k, -over_Y(row, k));
      }
    }
  }
}

void IdaJacobian::update(double t, const VecX& q, const Eigen::Ref<const VecX>& Y) {
  own_.count_turns_and_hold_regimes_as(dynamics_.equations());
  own_.update(t, q, Y);
  own_.write_mass_matrices(mass_matrices_);
}

/// Freezes the pattern: every entry that each_entry() ever visits, in compressed columns.
void IdaJacobian::lay_out(const VecX& q, const VecX& Y) {
  update(0.0, q, Y);
  VecX x = VecX::Zero(places_.size);
  x.head(places_.first_Y) = q;
  std::vector<std::pair<int, int>> visited;  // (column, row)
  each_entry(1.0, x, [&](int row, int column, double) { visited.emplace_back(column, row); });
  std::vector<std::pair<int, int>> pattern = visited;
  std::sort(pattern.begin(), pattern.end());
  pattern.erase(std::unique(pattern.begin(), pattern.end()), pattern.end());
  for (const auto& entry : visited) {
    const auto found = std::lower_bound(pattern.begin(), pattern.end(), entry);
    slots_.push_back(static_cast<int>(found - pattern.begin()));
  }
  starts_.assign(places_.size + 1, 0);
  for (const auto& [column, row] : pattern) {
    ++starts_[column + 1];
    rows_.push_back(row);
  }
  for (int column = 0; column < places_.size; ++column) starts_[column + 1] += starts_[column];
}

void IdaJacobian::write(double t, double c, const Eigen::Ref<const VecX>& x, double rate, double* values) {
  const auto Y = x.segment(places_.first_Y, layout_.n_Y());
  unit_q_ = x.head(places_.first_Y);
  layout_.normalize(unit_q_);
  update(t, unit_q_, Y);
  differentiate_rates(unit_q_, Y);
  differentiate_forces(t, rate, unit_q_, Y);
  std::fill_n(values, rows_.size(), 0.0);
  std::size_t next = 0;
  each_entry(c, x, [&](int, int, double value) { values[slots_[next++]] += value; });
}

}  // namespace concord::cartesian
