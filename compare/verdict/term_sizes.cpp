#include "compare/verdict/term_sizes.h"

#include <algorithm>
#include <cmath>

#include "common/elements/force_element.h"
#include "common/results.h"
#include "compare/audit/places.h"
#include "compare/verdict/body_loads.h"

namespace concord::compare {

namespace {

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
  BodyLoads loads_;
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
