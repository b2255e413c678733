#include "relative/equations.h"

namespace concord::relative {

Equations::Equations(const Model& model)
    : model_(&model),
      kinematics_(model),
      driven_(driven_speeds(model, kinematics_.topology())),
      closure_(kinematics_, driven_),
      applied_(kinematics_, closure_),
      articulated_bodies_(kinematics_, driven_),
      loops_(kinematics_, closure_, articulated_bodies_),
      reactions_(kinematics_, closure_, articulated_bodies_, applied_),
      q_(VecX::Zero(kinematics_.topology().n_q)),
      u_(VecX::Zero(kinematics_.topology().n_u)),
      udot_(VecX::Zero(kinematics_.topology().n_u)) {
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const Joint& joint = model.joints[k];
    const Span& span = topology().joints[k];
    for (const Driver& driver : joint.drivers) {
      drivers_.push_back({&driver.law, static_cast<int>(k),
                          span.first_q + first_q(*joint.type, driver.word) + driver.component,
                          span.first_u + first_u(*joint.type, driver.word) + driver.component});
    }
  }
  for (const Link& link : topology().links) inertias_.emplace_back(model.bodies[link.body]);
}

VecX Equations::home() const {
  VecX q = VecX::Zero(topology().n_q);
  for (std::size_t k = 0; k < model_->joints.size(); ++k) {
    const Span& span = topology().joints[k];
    q.segment(span.first_q, span.n_q) = kinematics_.mobilizer(static_cast<int>(k)).home();
  }
  return q;
}

void Equations::prescribe(double t, const Kinematics& counted, VecX& q, VecX& u) const {
  for (const Prescription& driver : drivers_) {
    const TimeFunctionValue value = evaluate(*driver.law, t);
    q(driver.q) = counted.without_turns(driver.q, value.f);
    u(driver.u) = value.fdot;
  }
}

void Equations::move(double t, const VecX& q, const VecX& u) {
  q_ = q;
  u_ = u;
  prescribe(t, q_, u_);
  kinematics_.update(q_, u_);
  closure_.measure(q_, u_);
}

void Equations::update_inertias() {
  for (std::size_t l = 0; l < inertias_.size(); ++l) {
    const int body = topology().links[l].body;
    const Span& modes = topology().modes[body];
    inertias_[l].update(q_.data() + modes.first_q, u_.data() + modes.first_u, kinematics_.body(body).A,
                        kinematics_.body(body).omega, model_->gravity);
  }
}

void Equations::compute_accelerations(double t, const VecX& q, const VecX& u) {
  move(t, q, u);
  for (const Prescription& driver : drivers_) udot_(driver.u) = evaluate(*driver.law, t).fddot;
  update_inertias();
  applied_.update(t, q_, u_);
  articulated_bodies_.backward_pass(inertias_, applied_, udot_);
  articulated_bodies_.forward_pass(udot_);
  loops_.close(udot_);
}

void Equations::update_forces(double t, const VecX& q, const VecX& u) {
  move(t, q, u);
  applied_.update(t, q_, u_);
}

std::optional<MotionWithoutInertia> Equations::find_motion_without_inertia(double t, const VecX& q, const VecX& u) {
  move(t, q, u);
  update_inertias();
  try {
    articulated_bodies_.backward_pass(inertias_, applied_, udot_);
  } catch (const SolverError&) {
    const auto found = articulated_bodies_.motion_without_inertia();
    if (!found) throw;
    return found;
  }
  return articulated_bodies_.motion_without_inertia();
}

void Equations::compute_reactions() { reactions_.compute(inertias_, loops_.lambda()); }

void Equations::compute_qdot(VecX& qdot) const {
  for (std::size_t k = 0; k < model_->joints.size(); ++k) {
    const Span& span = topology().joints[k];
    kinematics_.mobilizer(static_cast<int>(k))
        .compute_qdot(q_.data() + span.first_q, u_.data() + span.first_u, qdot.data() + span.first_q);
  }
  for (const Span& modes : topology().modes) {
    qdot.segment(modes.first_q, modes.n_q) = u_.segment(modes.first_u, modes.n_u);
  }
}

BodyAcceleration Equations::acceleration(int body) const {
  const Vec6& Vdot = articulated_bodies_.acceleration(body);
  const VecX* addot = articulated_bodies_.modal_acceleration(body);
  return {Vdot.head<3>(), Vdot.tail<3>(), addot == nullptr ? VecX() : *addot};
}

double Equations::power() const {
  double power = applied_.power();
  for (const Prescription& driver : drivers_) {
    const VecX& tau = reactions_.joints()[driver.joint].tau;
    // A spring on the same coordinate has its share in tau, and has been counted; a coupling has no power in all.
    const double of_driver = tau(driver.u - topology().joints[driver.joint].first_u) - applied_.tau()(driver.u) -
                             reactions_.coupling_tau()(driver.u);
    power += of_driver * u_(driver.u);
  }
  for (const BodyInertia& inertia : inertias_) {
    if (const FlexibleInertia* flexible = inertia.flexible()) power -= flexible->dissipation();
  }
  return power;
}

}  // namespace concord::relative
