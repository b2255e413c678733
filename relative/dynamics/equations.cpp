#include "relative/dynamics/equations.h"

#include <stdexcept>

namespace concord::relative {

namespace {

/// Below this least pivot of a flexible link, accelerations hold noise that integrators meet.
constexpr double kNoisy = 1e-6;

}  // namespace

Equations::Equations(const Model& model)
    : model_(&model),
      kinematics_(model),
      driven_(driven_speeds(model, kinematics_.topology())),
      closure_(kinematics_, driven_),
      applied_(kinematics_, closure_),
      tree_(kinematics_, driven_),
      accelerations_(kinematics_, tree_),
      loops_(kinematics_, closure_, tree_),
      reactions_(kinematics_, closure_),
      refinement_(kinematics_, closure_, tree_),
      prescribed_udot_(VecX::Zero(kinematics_.topology().n_u)),
      motion_(kinematics_.topology()),
      evaluated_(kinematics_, accelerations_, loops_.solution(), applied_, inertias_) {
  for (const JointIndex k : upward<JointIndex>(model.joints.size())) {
    const Joint& joint = model.joints[k];
    const Span& span = topology().joints[k];
    for (const Driver& driver : joint.drivers) {
      drivers_.push_back({&driver.law, k, span.first_q + first_q(*joint.type, driver.word) + driver.component,
                          span.first_u + first_u(*joint.type, driver.word) + driver.component});
    }
  }
  for (const Link& link : topology().links) {
    inertias_.emplace_back(model.bodies[link.body], topology().reference_points_L[link.body]);
  }
}

VecX Equations::home() const {
  VecX q = VecX::Zero(topology().n_q);
  for (const JointIndex k : upward<JointIndex>(model_->joints.size())) {
    const Span& span = topology().joints[k];
    q.segment(span.first_q, span.n_q) = kinematics_.mobilizer(k).home();
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

void Equations::count_turns_as(const Equations& other) {
  count_turns(other.kinematics_.turns());
  applied_.count_turns_as(other.applied_);
}

void Equations::place(double t, const VecX& q, const VecX& u) {
  ++motion_.number_;
  stands_ = false;
  motion_.at_.t = t;
  motion_.at_.q = q;
  motion_.at_.u = u;
  prescribe(t, motion_.at_.q, motion_.at_.u);
  kinematics_.update(motion_.q(), motion_.u());
}

const Motion& Equations::move(double t, const VecX& q, const VecX& u) {
  if (keeps_pose_ && stands_ && t == motion_.t() && q == motion_.q() && u == motion_.u()) return motion_;
  place(t, q, u);
  closure_.measure(motion_.at_.q, motion_.at_.u);
  stands_ = true;
  return motion_;
}

void Equations::update_inertias() {
  for (std::size_t l = 0; l < inertias_.size(); ++l) {
    const BodyIndex body = topology().links[l].body;
    const Span& modes = topology().modes[body];
    inertias_[l].update(motion_.q().data() + modes.first_q, motion_.u().data() + modes.first_u,
                        kinematics_.body(body).A, kinematics_.body(body).omega, model_->gravity);
  }
}

const Evaluated& Equations::compute_accelerations(double t, const VecX& q, const VecX& u) {
  return compute(t, q, u, kNoisy);
}

const Evaluated& Equations::compute_refined_accelerations(double t, const VecX& q, const VecX& u) {
  return compute(t, q, u, 1.0);
}

const Evaluated& Equations::compute(double t, const VecX& q, const VecX& u, double refined_below) {
  move(t, q, u);
  for (const Prescription& driver : drivers_) prescribed_udot_(driver.u) = evaluate(*driver.law, t).fddot;
  update_inertias();
  applied_.update(motion_);
  tree_.compute(inertias_, applied_, prescribed_udot_);
  accelerations_.solve(tree_, prescribed_udot_);
  loops_.close(tree_, accelerations_);
  if (tree_.least_pivot() < refined_below) refine_accelerations();
  evaluated_.motion_ = motion_.number_;
  return evaluated_;
}

void Equations::refine_accelerations() {
  constexpr int kRounds = 2;
  const VecX& lambda = loops_.solution().lambda;
  for (int round = 0; round < kRounds; ++round) {
    reactions_.compute(inertias_, accelerations_, applied_, lambda);
    refinement_.refine(tree_, reactions_, applied_, lambda, accelerations_);
    loops_.close_again(tree_, accelerations_);
  }
}

const AppliedForces& Equations::update_forces(double t, const VecX& q, const VecX& u) {
  move(t, q, u);
  applied_.update(motion_);
  return applied_;
}

std::optional<MotionWithoutInertia> Equations::find_motion_without_inertia(double t, const VecX& q, const VecX& u) {
  move(t, q, u);
  update_inertias();
  try {
    tree_.compute(inertias_, applied_, prescribed_udot_);
  } catch (const SolverError&) {
    auto found = relative::find_motion_without_inertia(tree_);
    if (!found) throw;
    return found;
  }
  return relative::find_motion_without_inertia(tree_);
}

/// What was computed in another pose does not go with what the machine is now.
void Equations::require_current(const Evaluated& evaluated) const {
  if (evaluated.accelerations_ == &accelerations_ && evaluated.motion_ == motion_.number_) return;
  throw std::logic_error("relative: accelerations of another pose: the machine has been moved since");
}

const JointReactions& Equations::compute_reactions(const Evaluated& evaluated) {
  require_current(evaluated);
  const JointReactions& found = reactions_.compute(inertias_, accelerations_, applied_, evaluated.loops().lambda);
  reactions_.share_out_springs(applied_);
  return found;
}

const JointReactions& Equations::compute_self_stress(const Motion& /*motion*/, const VecX& lambda) {
  return reactions_.compute_self_stress(lambda);
}

void Equations::compute_qdot(const Motion& motion, VecX& qdot) const {
  for (const JointIndex k : upward<JointIndex>(model_->joints.size())) {
    const Span& span = topology().joints[k];
    kinematics_.mobilizer(k).compute_qdot(motion.q().data() + span.first_q, motion.u().data() + span.first_u,
                                          qdot.data() + span.first_q);
  }
  for (const Span& modes : topology().modes) {
    qdot.segment(modes.first_q, modes.n_q) = motion.u().segment(modes.first_u, modes.n_u);
  }
}

double Equations::power(const Evaluated& evaluated) {
  require_current(evaluated);
  double power = applied_.power();
  if (has_drivers()) {
    const JointReactions& reactions =
        reactions_.compute_driver_forces(inertias_, accelerations_, applied_, evaluated.loops().lambda);
    for (const Prescription& driver : drivers_) {
      const VecX& of_driver = reactions.joints[driver.joint].share_of(Actor::driver);
      power += of_driver(driver.u - topology().joints[driver.joint].first_u) * motion_.u()(driver.u);
    }
  }
  for (const BodyInertia& inertia : inertias_) {
    if (const FlexibleInertia* flexible = inertia.flexible()) power -= flexible->dissipation();
  }
  return power;
}

}  // namespace concord::relative
