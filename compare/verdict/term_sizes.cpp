#include "compare/verdict/term_sizes.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/laws/force_elements.h"
#include "common/results.h"
#include "compare/audit/free_body.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/places.h"
#include "compare/verdict/spring_terms.h"
#include "compare/verdict/way_to_ground.h"

namespace concord::compare {

namespace {

/// Loads on a body in one state.
struct BodyLoad {
  double mass = 0.0;
  double least_inertia = 0.0;    // about any axis through the centre of mass, kg m2
  double largest_inertia = 0.0;  // the same
  double eccentricity = 0.0;     // distance of the centre of mass from the origin, m
  double force = 0.0;
  double torque = 0.0;  // about the body's origin
  VecX modal;           // generalized forces by mode
  VecX modal_mass;
};

/// Accelerations that the neighbours nearer to the ground carry a body with [rad/s2, m/s2]. In joint coordinates its
/// own is theirs and its joints': a ring that hangs loose on a shaft stays at rest as the difference of two large
/// numbers. Depths are those of the machine with all joints; a tree that cuts some of them may carry a body otherwise.
struct Carried {
  double turning = 0.0;
  double moving = 0.0;
};

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

class Loads {
 public:
  Loads(const Model& model, const SharedState& shared)
      : model_(model),
        shared_(shared),
        bodies_(model.bodies.size()),
        depths_(depths(model)),
        carried_(carried_by_joints(model, shared, depths_)),
        beyond_(model.bodies.size()) {
    for (std::size_t i = 1; i < bodies_.size(); ++i) add_inertia(static_cast<int>(i));
    for (const Evaluation& evaluation : shared.evaluations) {
      add_wrenches(evaluation);
      add_coordinate_forces(evaluation);
    }
    add_springs();
    pass_on_to_ground();
  }

  [[nodiscard]] const BodyLoad& of(int body) const { return bodies_[body]; }
  [[nodiscard]] const SpringTerms& of_element(int element) const { return elements_[element]; }
  [[nodiscard]] const Carried& carried(int body) const { return carried_[body]; }
  /// What acts on the neighbours beyond a body is taken apart into what moves them and what their joints pass on to it:
  /// its round-off acts on the body even where a joint passes next to nothing, as a slide along which a spring pulls.
  [[nodiscard]] const SpringTerms& beyond(int body) const { return beyond_[body]; }

 private:
  void add_inertia(int i) {
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

  static void take_inertia(const Mat3& inertia, BodyLoad& load) {
    load.least_inertia = std::max(0.0, inertia.diagonal().minCoeff());
    load.largest_inertia = inertia.diagonal().maxCoeff();
  }

  static void take_force(BodyLoad& load, double force, double reach) {
    load.force = std::max(load.force, force);
    load.torque = std::max(load.torque, reach * force);
  }

  void take_wrench(const Attachment& side, const Wrench& wrench) {
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

  void add_wrenches(const Evaluation& evaluation) {
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

  void take_terms(const Attachment& side, const SpringTerms& terms) {
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

  /// What acts on joint coordinates: all together, and couplings by themselves, which may pass on what a motor exerts.
  void add_coordinate_forces(const Evaluation& evaluation) {
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

  void add_springs() {
    for (std::size_t k = 0; k < model_.joints.size(); ++k) {
      const SpringTerms terms = spring_terms(model_.joints[k], shared_.state.q[k], shared_.state.u[k], shared_.state.t);
      for (const Attachment& side : model_.joints[k].sides) take_terms(side, terms);
    }
    for (const ForceElement& element : model_.elements) {
      elements_.push_back(spring_terms(element, shared_.state));
      for (const Side side : kSides) {
        if (const Attachment* end = end_of(element, side)) take_terms(*end, elements_.back());
      }
    }
  }

  /// After all loads are known.
  void pass_on_to_ground() {
    for (const Joint& joint : model_.joints) {
      const auto bodies = near_and_far(joint, depths_);
      if (!bodies || joint.type->rows() == 0) continue;
      const BodyLoad& load = bodies_[bodies->second];
      SpringTerms& terms = beyond_[bodies->first];
      terms = {std::max(terms.force, load.force), std::max(terms.torque, load.torque)};
    }
  }

  const Model& model_;
  const SharedState& shared_;
  std::vector<BodyLoad> bodies_;
  std::vector<int> depths_;
  std::vector<Carried> carried_;
  std::vector<SpringTerms> beyond_;
  std::vector<SpringTerms> elements_;
};

/// The size of the terms of each quantity, from the loads on the bodies.
class TermSizes {
 public:
  TermSizes(const Model& model, const SharedState& shared)
      : model_(model), shared_(shared), loads_(model, shared), length_(model.length_scale()) {}

  [[nodiscard]] double of(const Quantity& quantity) const {
    const bool is_torque = unit_of(model_, quantity) == "N m";
    switch (quantity.kind) {
      case Kind::coupling:
        return of_coupling(model_.couplings[quantity.owner]);
      case Kind::element:
        return of_element(quantity.owner, is_torque);
      case Kind::body_sum:
        return of_sum(quantity.owner, is_torque);
      case Kind::acceleration:
        return of_acceleration(quantity.owner, quantity.component);
      default:
        return of_joint(quantity.owner, is_torque);
    }
  }

 private:
  /// How far apart two ends stand, at least the machine's length [m]: a force on one is a torque about the other. A
  /// load has one end. Far from the origin levers are differences of places, which are rounded as the distance is.
  [[nodiscard]] double reach(const Attachment* one, const Attachment* other) const {
    constexpr double kRounding = 0.125;  // places round by half a unit at most, and several lever arms seldom add up
    if (one == nullptr || other == nullptr) return length_;
    const auto& bodies = shared_.state.bodies;
    const Vec3 from = place(*one, bodies[one->body]).r_P;
    const Vec3 to = place(*other, bodies[other->body]).r_P;
    return std::max({length_, (from - to).norm(), kRounding * from.norm()});
  }

  /// What a joint passes is the rest of the loads on its bodies, and of what couplings bring from other joints.
  [[nodiscard]] double of_bodies(int k, bool is_torque) const {
    double force = 0.0;
    double torque = 0.0;
    for (const Attachment& side : model_.joints[k].sides) {
      if (side.body == kGround) continue;
      force = std::max(force, loads_.of(side.body).force);
      torque = std::max(torque, loads_.of(side.body).torque);
    }
    return is_torque ? std::max(torque, force * reach(&model_.joints[k].sides[0], &model_.joints[k].sides[1])) : force;
  }

  /// A joint's force is known as well as the loads on its bodies, and takes its round-off to the origin by its lever:
  /// of a body that falls, with next to nothing in its joint, that is more than what the joint passes. Couplings on one
  /// joint may balance each other.
  [[nodiscard]] double of_sum(int body, bool is_torque) const {
    double size = on_and_beyond(body, is_torque);
    for (std::size_t k = 0; k < model_.joints.size(); ++k) {
      for (const Attachment& side : model_.joints[k].sides) {
        if (side.body != body) continue;
        const int joint = static_cast<int>(k);
        size = std::max(size, of_couplings_on(joint, is_torque));
        if (is_torque) size = std::max(size, of_bodies(joint, false) * side.point_L.norm());
      }
    }
    return size;
  }

  [[nodiscard]] double of_coupling(const Coupling& coupling) const {
    double size = 0.0;
    for (const CouplingTerm& term : coupling.terms) {
      size = std::max(size, of_bodies(term.joint, is_turn(model_, term)) / std::abs(term.factor));
    }
    return size;
  }

  [[nodiscard]] double of_couplings_on(int k, bool is_torque) const {
    double size = 0.0;
    for (const Coupling& coupling : model_.couplings) {
      for (const CouplingTerm& term : coupling.terms) {
        if (term.joint != k || is_turn(model_, term) != is_torque) continue;
        size = std::max(size, of_coupling(coupling) * std::abs(term.factor));
      }
    }
    return size;
  }

  [[nodiscard]] double of_joint(int k, bool is_torque) const {
    return std::max(of_bodies(k, is_torque), of_couplings_on(k, is_torque));
  }

  [[nodiscard]] double of_element(int k, bool is_torque) const {
    const ForceElement& element = model_.elements[k];
    const double lever = reach(end_of(element, Side::parent), end_of(element, Side::child));
    const SpringTerms& terms = loads_.of_element(k);
    double size = is_torque ? std::max(terms.torque, terms.force * lever) : terms.force;
    for (const SideWrench& side : shared_.evaluations[0].elements[k].on) {
      const double force = side.in_C.force.norm();
      size = std::max(size, is_torque ? std::max(side.in_C.torque.norm(), force * lever) : force);
    }
    return size;
  }

  /// Loads on a body and on its neighbours beyond it.
  [[nodiscard]] double on_and_beyond(int body, bool is_torque) const {
    const BodyLoad& load = loads_.of(body);
    const SpringTerms& beyond = loads_.beyond(body);
    return is_torque ? std::max(load.torque, beyond.torque) : std::max(load.force, beyond.force);
  }

  [[nodiscard]] double by_loads(int body, bool angular) const {
    const BodyLoad& load = loads_.of(body);
    const double inertia = angular ? load.least_inertia : load.mass;
    return inertia > 0.0 ? on_and_beyond(body, angular) / inertia : 0.0;
  }

  /// A coupling passes the accelerations of its other coordinates on, by the ratio of their factors.
  [[nodiscard]] double through_couplings(int body, bool angular) const {
    double largest = 0.0;
    for (const Coupling& coupling : model_.couplings) {
      for (const CouplingTerm& own : coupling.terms) {
        const auto& sides = model_.joints[own.joint].sides;
        if (is_turn(model_, own) != angular || (sides[0].body != body && sides[1].body != body)) continue;
        for (const CouplingTerm& other : coupling.terms) {
          if (&other == &own) continue;
          for (const Attachment& side : model_.joints[other.joint].sides) {
            largest =
                std::max(largest, std::abs(other.factor / own.factor) * by_loads(side.body, is_turn(model_, other)));
          }
        }
      }
    }
    return largest;
  }

  [[nodiscard]] double through_joints(int body, bool angular) const {
    const Carried& carried = loads_.carried(body);
    return angular ? carried.turning : carried.moving;
  }

  [[nodiscard]] double of_acceleration(int body, int component) const {
    if (component < 6) {
      const bool angular = component >= 3;
      return std::max({by_loads(body, angular), through_couplings(body, angular), through_joints(body, angular)});
    }
    const BodyLoad& load = loads_.of(body);
    const double mass = load.modal_mass(component - 6);
    return mass > 0.0 ? load.modal(component - 6) / mass : 0.0;
  }

  const Model& model_;
  const SharedState& shared_;
  Loads loads_;
  double length_;
};

}  // namespace

VecX term_sizes(const QuantityLayout& layout, const SharedState& shared) {
  const TermSizes sizes(layout.model(), shared);
  VecX all(static_cast<Eigen::Index>(layout.quantities().size()));
  for (std::size_t row = 0; row < layout.quantities().size(); ++row) {
    all(static_cast<Eigen::Index>(row)) = sizes.of(layout.quantities()[row]);
  }
  return all;
}

}  // namespace concord::compare
