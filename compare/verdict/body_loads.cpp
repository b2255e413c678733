#include "compare/verdict/body_loads.h"

#include <algorithm>
#include <cmath>

#include "common/elements/force_element.h"
#include "compare/audit/free_body.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/places.h"
#include "compare/verdict/observe.h"
#include "compare/verdict/way_to_ground.h"

namespace concord::compare {

namespace {

std::vector<Carried> carried_by_joints(const Model& model, const SharedState& shared, const std::vector<int>& depth) {
  std::vector<Carried> all(model.bodies.size());
  for (const Joint& joint : model.joints) {
    const auto bodies = near_and_far(joint, depth);
    if (!bodies) continue;
    const auto [near, far] = *bodies;
    const double lever = (shared.state.bodies[far].r - shared.state.bodies[near].r).norm();
    for (const Evaluation& evaluation : shared.evaluations) {
      const BodyAcceleration& its = evaluation.bodies[near];
      const double turning = its.omegadot.norm();
      all[far].turning = std::max(all[far].turning, turning);
      all[far].moving = std::max(all[far].moving, its.vdot.norm() + lever * turning);
    }
  }
  return all;
}

void take_inertia(const Mat3& inertia, BodyLoad& load) {
  load.inertia = inertia;
  load.least_inertia = std::max(0.0, inertia.diagonal().minCoeff());
  load.largest_inertia = inertia.diagonal().maxCoeff();
}

void take_force(BodyLoad& load, double force, double reach) {
  load.force = std::max(load.force, force);
  load.torque = std::max(load.torque, reach * force);
}

}  // namespace

BodyLoads::BodyLoads(const Model& model, const SharedState& shared)
    : model_(model),
      shared_(shared),
      bodies_(model.bodies.size()),
      depths_(depths(model)),
      carried_(carried_by_joints(model, shared, depths_)),
      beyond_(model.bodies.size()),
      driven_(model.bodies.size(), 0.0) {
  for (std::size_t i = 1; i < bodies_.size(); ++i) add_inertia(static_cast<int>(i));
  for (const Evaluation& evaluation : shared.evaluations) {
    add_wrenches(evaluation);
    add_coordinate_forces(evaluation);
  }
  add_springs();
  for (std::size_t k = 0; k < model.joints.size(); ++k) take_forces_on_speeds(static_cast<int>(k));
  pass_on_to_ground();
  carry_on();
}

void BodyLoads::add_inertia(int i) {
  const Body& body = model_.bodies[i];
  const BodyState& state = shared_.state.bodies[i];
  BodyLoad& load = bodies_[i];
  const bool flexible = body.modal.has_value();
  load.mass = flexible ? body.modal->G(0, 0) : body.mass;
  load.modal = load.modal_mass = VecX::Zero(body.n_modes());
  double reach = body.center_of_mass_L.norm();
  if (flexible) {
    for (const MassPoint& point : body.modal->mass_points) reach = std::max(reach, point.s0_L.norm());
    load.modal_mass = modal_masses(*body.modal);
    load.modal = (body.modal->stiffness.cwiseAbs() * state.a.cwiseAbs()) +
                 (body.modal->damping.cwiseAbs() * state.adot.cwiseAbs());
    const Vec3 center = body.modal->G.block<3, 1>(1, 0) / load.mass;
    load.eccentricity = center.norm();
    const Mat3 second = body.modal->G.block<3, 3>(1, 1) - load.mass * center * center.transpose();
    take_inertia(second.trace() * Mat3::Identity() - second, load);
  } else {
    load.eccentricity = body.center_of_mass_L.norm();
    take_inertia(body.inertia_L, load);
  }
  for (const Evaluation& evaluation : shared_.evaluations) {
    const BodyAcceleration& acceleration = evaluation.bodies[i];
    const double turning = std::max(acceleration.omegadot.norm(), carried_[i].turning) + state.omega.squaredNorm();
    const double moving = std::max(acceleration.vdot.norm(), carried_[i].moving);
    const double size = model_.gravity.norm() + moving + reach * turning;
    // Inertia of the modes' accelerations, by its mass points: where modes move no mass on the whole, as those of a
    // body that floats, these add up to their round-off.
    const VecX of_modes = load.modal_mass.cwiseSqrt().cwiseProduct(acceleration.addot.cwiseAbs());
    take_force(load, load.mass * size + std::sqrt(load.mass) * of_modes.sum(), reach);
    load.torque = std::max(load.torque, load.largest_inertia * turning +  // I omegadot + omega x (I omega)
                                            std::sqrt(load.largest_inertia) * of_modes.sum());
    load.modal += (load.mass * load.modal_mass).cwiseSqrt() * size;
  }
}

void BodyLoads::take_wrench(const Attachment& side, const Wrench& wrench) {
  if (side.body == kGround) return;
  BodyLoad& load = bodies_[side.body];
  const double force = wrench.force.norm();
  take_force(load, force, side.point_L.norm());
  load.torque = std::max(load.torque, wrench.torque.norm());
  if (load.modal.size() > 0) {
    load.modal += force * side.Psi_t_L.colwise().norm().transpose() +
                  wrench.torque.norm() * side.Psi_r_L.colwise().norm().transpose();
  }
}

void BodyLoads::add_wrenches(const Evaluation& evaluation) {
  for (std::size_t k = 0; k < model_.joints.size(); ++k) {
    for (const Side side : kSides) {
      take_wrench(model_.joints[k].on(side), evaluation.joints[k].total_on(side).in_C);
      take_wrench(model_.joints[k].on(side), evaluation.joints[k].reaction_on(side).in_C);
    }
  }
  for (std::size_t e = 0; e < model_.elements.size(); ++e) {
    for (const Side side : kSides) {
      if (const Attachment* end = end_of(model_.elements[e], side)) {
        take_wrench(*end, evaluation.elements[e].on_side(side).in_C);
      }
    }
  }
}

void BodyLoads::take_terms(const Attachment& side, const SpringTerms& terms) {
  if (side.body == kGround) return;
  BodyLoad& load = bodies_[side.body];
  take_force(load, terms.force, side.point_L.norm());
  load.torque = std::max(load.torque, terms.torque);
  // What turns a body beside its centre of mass pulls at the place about which it turns.
  const double moment = load.mass * load.eccentricity;
  if (moment > 0.0) {
    load.force = std::max(load.force, terms.torque * moment / (moment * load.eccentricity + load.least_inertia));
  }
}

/// Sizes of what acts on the speeds of a joint [N or N m].
VecX BodyLoads::forces_on_speeds(int joint) const {
  const std::vector<bool> turns = turning_speeds(*model_.joints[joint].type);
  VecX forces(static_cast<Eigen::Index>(turns.size()));
  for (std::size_t u = 0; u < turns.size(); ++u) {
    forces(static_cast<Eigen::Index>(u)) = turns[u] ? springs_[joint].torque : springs_[joint].force;
  }
  for (const Evaluation& evaluation : shared_.evaluations) {
    forces = forces.cwiseMax(evaluation.joints[joint].tau.cwiseAbs());
  }
  return forces;
}

/// A speed that moves and turns a body at once, as that of a screw, makes of a torque a force and of a force a torque,
/// by the shares of the inertia that it moves.
void BodyLoads::take_forces_on_speeds(int joint) {
  const VecX forces = forces_on_speeds(joint);
  if (!(forces.size() > 0 && forces.maxCoeff() > 0.0)) return;
  const Joint& its = model_.joints[joint];
  const Mat6X S = read_motion(*its.type, relative_motion_of(its, shared_.state), shared_.state.q[joint]).S;
  const Attachment& parent = its.on(Side::parent);
  const Mat3 A = place(parent, shared_.state.bodies[parent.body]).A_joint;
  for (Eigen::Index u = 0; u < forces.size(); ++u) {
    const double moves = S.col(u).head<3>().norm();
    const Vec3 axis = A * S.col(u).tail<3>();
    if (!(moves > 0.0 && axis.norm() > 0.0)) continue;
    for (const Attachment& side : its.sides) {
      if (side.body == kGround) continue;
      BodyLoad& load = bodies_[side.body];
      const Vec3 axis_L = rotation_of(shared_.state.bodies[side.body].p).transpose() * axis;
      const double turned = axis_L.dot(load.inertia * axis_L);
      const double inertia = load.mass * moves * moves + turned;
      if (!(inertia > 0.0)) continue;
      const double acceleration = moves * forces(u) / inertia;
      take_force(load, load.mass * acceleration, side.point_L.norm());
      load.torque = std::max(load.torque, forces(u) * turned / (inertia * axis.norm()));
      driven_[side.body] = std::max(driven_[side.body], acceleration);
    }
  }
}

/// Neighbours farther from the ground are moved along; what that takes does not act on the nearer ones once more.
void BodyLoads::carry_on() {
  bool is_news = std::any_of(driven_.begin(), driven_.end(), [](double driven) { return driven > 0.0; });
  while (is_news) {
    is_news = false;
    for (const Joint& joint : model_.joints) {
      const auto bodies = near_and_far(joint, depths_);
      if (!bodies || driven_[bodies->first] <= driven_[bodies->second]) continue;
      driven_[bodies->second] = driven_[bodies->first];
      is_news = true;
    }
  }
  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    if (!(driven_[i] > 0.0)) continue;
    carried_[i].moving = std::max(carried_[i].moving, driven_[i]);
    take_force(bodies_[i], bodies_[i].mass * driven_[i], bodies_[i].eccentricity);
  }
}

/// What acts on joint coordinates: all together, and couplings by themselves, which may pass on what a motor exerts.
void BodyLoads::add_coordinate_forces(const Evaluation& evaluation) {
  const auto take = [this](int joint, double force, bool is_torque) {
    const SpringTerms terms = is_torque ? SpringTerms{0.0, force} : SpringTerms{force, 0.0};
    for (const Attachment& side : model_.joints[joint].sides) take_terms(side, terms);
  };
  for (std::size_t k = 0; k < model_.joints.size(); ++k) {
    const VecX& tau = evaluation.joints[k].tau;
    const std::vector<bool> turns = turning_speeds(*model_.joints[k].type);
    for (Eigen::Index u = 0; u < tau.size(); ++u) {
      take(static_cast<int>(k), std::abs(tau(u)), turns[static_cast<std::size_t>(u)]);
    }
  }
  for (std::size_t c = 0; c < evaluation.couplings.size(); ++c) {
    for (const CouplingTerm& term : model_.couplings[c].terms) {
      take(term.joint, std::abs(evaluation.couplings[c] * term.factor), is_turn(model_, term));
    }
  }
}

void BodyLoads::add_springs() {
  for (std::size_t k = 0; k < model_.joints.size(); ++k) {
    springs_.push_back(spring_terms(model_.joints[k], shared_.state.q[k], shared_.state.u[k], shared_.state.t));
    for (const Attachment& side : model_.joints[k].sides) take_terms(side, springs_.back());
  }
  for (const ForceElement& element : model_.elements) {
    elements_.push_back(spring_terms(element, shared_.state, shared_.state.known_angle(elements_.size())));
    for (const Side side : kSides) {
      if (const Attachment* end = end_of(element, side)) take_terms(*end, elements_.back());
    }
  }
}

/// After all loads but those of being moved along are known.
void BodyLoads::pass_on_to_ground() {
  for (const Joint& joint : model_.joints) {
    const auto bodies = near_and_far(joint, depths_);
    if (!bodies || joint.type->rows() == 0) continue;
    const BodyLoad& load = bodies_[bodies->second];
    SpringTerms& terms = beyond_[bodies->first];
    terms = {std::max(terms.force, load.force), std::max(terms.torque, load.torque)};
  }
}

}  // namespace concord::compare
