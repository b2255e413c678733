#include "cartesian/dynamics/equations.h"

#include <fmt/format.h>

#include <cmath>

namespace concord::cartesian {

namespace {

ByBody<BodyInertia> make_inertias(const Model& model) {
  ByBody<BodyInertia> inertias;
  for (const Body& body : model.bodies) inertias.add(BodyInertia(body));
  return inertias;
}

ByBody<DeformedInertia> make_deformed(const ByBody<BodyInertia>& inertias) {
  ByBody<DeformedInertia> deformed;
  for (const BodyInertia& body : inertias) deformed.add(DeformedInertia(body));
  return deformed;
}

}  // namespace

Equations::Equations(const Model& model)
    : model_(model),
      layout_(model),
      inertias_(make_inertias(model)),
      scales_(model, layout_, inertias_),
      deformed_(make_deformed(inertias_)),
      constraints_(Constraints::make(model, layout_)),
      applied_(model, layout_),
      Y_(VecX::Zero(layout_.n_Y())),
      forces_(VecX::Zero(layout_.n_Y())),
      residual_(VecX::Zero(constraints_->n_rows())),
      velocity_residual_(VecX::Zero(constraints_->n_rows())),
      row_sizes_(VecX::Zero(constraints_->n_rows())) {}

void Equations::count_turns_from(const std::vector<VecX>& q) {
  applied_.count_turns_from(q);
  constraints_->count_turns_from(q);
}

void Equations::count_turns_from(const State& state) {
  count_turns_from(state.q);
  applied_.count_spring_turns_from(state);
}

void Equations::count_turns_and_hold_regimes_as(const Equations& other) {
  applied_.count_turns_and_hold_regimes_as(other.applied_);
  constraints_->count_turns_as(*other.constraints_);
}

void Equations::update(double t, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y) {
  try {
    update_at(t, q, Y);
  } catch (const LargeRotation& turned) {
    throw LargeRotation(turned.of, turned.angle, fmt::format(" at t = {:.6g} s", t));
  }
}

void Equations::update_at(double t, const Eigen::Ref<const VecX>& q, const Eigen::Ref<const VecX>& Y) {
  t_ = t;
  Y_ = Y;
  moving_ = &constraints_->place_and_move(q, Y);
  has_residuals_ = has_row_sizes_ = false;
  for (const BodyIndex i : layout_.moving_bodies()) deformed_[i].update(layout_.a(q, i), layout_.adot(Y, i));
  for (const BodyIndex i : layout_.moving_bodies()) {
    deformed_[i].write_forces(moving_->rotation(i), layout_.omega(Y, i), model_.gravity, layout_.a(q, i),
                              layout_.adot(Y, i), forces_.segment(layout_.first_Y(i), layout_.size_Y(i)));
  }
  applied_.update(*moving_, t, q, Y);
  applied_.add_to(forces_);
}

void Equations::compute_residuals() const {
  moving_->write_residual(t_, residual_);
  moving_->write_velocity_residual(t_, velocity_residual_);
  has_residuals_ = true;
}

/// Of a row among a joint's (C45).
double Equations::size_of(JointIndex joint, int own) const {
  double squared = 0.0;
  for (const Side side : {Side::parent, Side::child}) {
    const BodyIndex body = body_of(pick(model_.joints, joint).on(side));
    if (is_ground(body)) continue;
    const auto over_Y = moving_->joint(joint).Phi_Y_transposed[index(side)].col(own);
    squared += over_Y.cwiseProduct(units().segment(layout_.first_Y(body), over_Y.size())).squaredNorm();
  }
  return std::sqrt(squared);
}

void Equations::measure_rows() const {  // (C45)
  for (const JointIndex k : constraints_->joints()) {
    const JointLayout& joint = constraints_->joint(k);
    for (int own = 0; own < joint.n_rows; ++own) row_sizes_(joint.row(own).value) = size_of(k, own);
  }
  for (const CouplingIndex g : constraints_->couplings()) {
    const CouplingLayout& coupling = constraints_->coupling(g);
    double sum = 0.0;
    for (const CouplingEquations::Term& term : coupling.terms)
      sum += std::abs(term.factor) * size_of(term.joint, term.row);
    row_sizes_(coupling.row.value) = sum;
  }
  has_row_sizes_ = true;
}

void Equations::write_mass_matrices(ByBody<MatX>& M) const {
  for (const BodyIndex i : layout_.moving_bodies()) deformed_[i].write_mass_matrix(moving_->rotation(i), M[i]);
}

double Equations::power_of(const Eigen::Ref<const VecX>& lambda) const {
  double sum = applied_.power(Y_);
  for (const JointIndex k : constraints_->joints()) {
    const JointLayout& joint = constraints_->joint(k);
    for (int own = joint.first_driver; own < joint.n_rows; ++own) {
      const Driver& driver = pick(model_.joints, k).drivers[own - joint.first_driver];
      sum -= lambda(joint.row(own).value) * evaluate(driver.law, t_).fdot;
    }
  }
  for (const BodyIndex i : layout_.moving_bodies()) sum -= inertias_[i].damping_power(layout_.adot(Y_, i));
  return sum;
}

ByBody<MatX> modal_masses(const Equations& equations) {
  ByBody<MatX> masses(equations.layout().n_bodies());
  for (const BodyIndex i : equations.layout().moving_bodies()) masses[i] = equations.inertia(i).modal_mass();
  return masses;
}

ByBody<MatX> make_mass_matrices(const Layout& layout) {
  ByBody<MatX> M(layout.n_bodies());
  for (const BodyIndex i : layout.moving_bodies()) M[i].setZero(layout.size_Y(i), layout.size_Y(i));
  return M;
}

void write_mass_times(const Layout& layout, const ByBody<MatX>& M, const Eigen::Ref<const VecX>& x,
                      Eigen::Ref<VecX> product) {
  for (const BodyIndex i : layout.moving_bodies()) {
    product.segment(layout.first_Y(i), layout.size_Y(i)).noalias() =
        M[i] * x.segment(layout.first_Y(i), layout.size_Y(i));
  }
}

}  // namespace concord::cartesian
