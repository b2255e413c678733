#include "compare/resolution/term_sizes.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "common/results.h"
#include "compare/audit/free_body.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/places.h"
#include "compare/resolution/spring_terms.h"

namespace concord::compare {

namespace {

constexpr double kLeastLever = 1e-6;  // of the machine's length

/// Of a body, or of what is on it: forces, and torques, the machine's length times forces among them.
struct Load {
  double force = 0.0;   // N
  double torque = 0.0;  // N m

  void take(double new_force, double new_torque, double length) {
    force = std::max(force, new_force);
    torque = std::max({torque, new_torque, force * length});
  }
  void take(const Load& other) { take(other.force, other.torque, 0.0); }
};

/// The loads on each body in one state, the larger of both solvers'.
class Loads {
 public:
  Loads(const Model& model, const SharedState& shared)
      : model_(model),
        shared_(shared),
        length_(model.length_scale()),
        loads_(model.bodies.size()),
        shares_(model.bodies.size()),
        accelerations_(model.bodies.size(), 0.0),
        modal_(model.bodies.size()) {
    const FreeBodies free_bodies(model);
    for (std::size_t i = 1; i < loads_.size(); ++i) add_body(static_cast<int>(i), free_bodies);
    for (std::size_t k = 0; k < model.joints.size(); ++k) add_shares(static_cast<int>(k));
    shake();
    carry_massless();
    add_up();
  }

  /// In the quantity's unit.
  [[nodiscard]] double of(const Quantity& quantity) const {
    if (quantity.kind == Kind::coupling) return on_coupling(model_.couplings[quantity.owner]);
    const std::string unit = unit_of(model_, quantity);
    if (quantity.kind == Kind::acceleration) {
      if (quantity.component >= 6) return modal_[quantity.owner](quantity.component - 6);
      return accelerations_[quantity.owner] / (unit == "rad/s2" ? length_ : 1.0);
    }
    const Load load = on_owner(quantity);
    return unit == "N m" ? load.torque : load.force;
  }

 private:
  void add_body(int i, const FreeBodies& free_bodies) {
    const Body& body = model_.bodies[i];
    VecX sizes = VecX::Zero(6 + body.n_modes());
    for (const Evaluation& evaluation : shared_.evaluations) {
      sizes = sizes.cwiseMax(free_bodies.balance_of(i, shared_.state, evaluation).scales);
    }
    loads_[i].take(sizes.head<3>().maxCoeff(), sizes.segment<3>(3).maxCoeff(), length_);
    modal_[i] = sizes.tail(body.n_modes());
    if (!body.modal) return;
    const VecX masses = modal_masses(*body.modal);
    modal_[i] = (masses.array() > 0.0).select(modal_[i].cwiseQuotient(masses), 0.0);
  }

  /// What springs, dampers, actuators, couplings and drivers share of a joint's coordinate forces, however much of it
  /// cancels: along a permitted direction [v; omega] a coordinate force tau is a force tau / |v| or a torque tau /
  /// |omega|.
  void add_shares(int k) {
    const Joint& joint = model_.joints[k];
    const auto at = static_cast<std::size_t>(k);
    const SpringTerms springs = spring_terms(joint, shared_.state.q[at], shared_.state.u[at], shared_.state.t);
    const std::vector<bool> turning = turning_speeds(*joint.type);
    VecX tau(joint.type->n_u());
    for (Eigen::Index speed = 0; speed < tau.size(); ++speed) {
      tau(speed) = turning[static_cast<std::size_t>(speed)] ? springs.torque : springs.force;
    }
    for (const Evaluation& evaluation : shared_.evaluations) {
      tau = tau.cwiseMax(evaluation.joints[k].tau.cwiseAbs());
      tau = tau.cwiseMax(coupled_tau(model_, k, evaluation.couplings).cwiseAbs());
    }
    const JointMotion motion = read_motion(*joint.type, relative_motion_of(joint, shared_.state), shared_.state.q[at]);
    Load shares;
    for (Eigen::Index speed = 0; speed < tau.size(); ++speed) {
      const double moves = motion.S.col(speed).head<3>().norm();
      const double turns = motion.S.col(speed).tail<3>().norm();
      if (moves > kLeastLever * turns * length_) shares.take(tau(speed) / moves, 0.0, length_);
      if (turns * length_ > kLeastLever * moves) shares.take(0.0, tau(speed) / turns, length_);
    }
    for (const Side side : kSides) {
      loads_[joint.on(side).body].take(shares);
      shares_[joint.on(side).body].take(shares);
    }
  }

  /// A body is shaken by the loads on it, and by what cancels on its neighbours.
  void shake() {
    shaken_ = loads_;
    for (const Joint& joint : model_.joints) {
      const auto [parent, child] = std::pair(joint.on(Side::parent).body, joint.on(Side::child).body);
      shaken_[parent].take(shares_[child]);
      shaken_[child].take(shares_[parent]);
    }
    for (std::size_t i = 1; i < shaken_.size(); ++i) {
      const double mass = mass_of(model_.bodies[i]);
      if (mass > 0.0) accelerations_[i] = std::max(shaken_[i].force, shaken_[i].torque / length_) / mass;
    }
  }

  /// A body without mass is moved by what it is joined to.
  void carry_massless() {
    for (bool is_news = true; is_news;) {
      is_news = false;
      for (const Joint& joint : model_.joints) {
        const auto [parent, child] = std::pair(joint.on(Side::parent).body, joint.on(Side::child).body);
        for (const auto& [body, by] : {std::pair(parent, child), std::pair(child, parent)}) {
          if (body == kGround || mass_of(model_.bodies[body]) > 0.0) continue;
          if (accelerations_[body] >= accelerations_[by]) continue;
          accelerations_[body] = accelerations_[by];
          is_news = true;
        }
      }
    }
  }

  /// A body's sum is known as the wrenches of its joints are, each to the loads on both bodies.
  void add_up() {
    summed_.resize(loads_.size());
    for (std::size_t k = 0; k < model_.joints.size(); ++k) {
      for (const Side side : kSides) summed_[model_.joints[k].on(side).body].take(on_joint(static_cast<int>(k)));
    }
  }

  [[nodiscard]] Load on_joint(int k) const {
    Load load = loads_[model_.joints[k].on(Side::parent).body];
    load.take(loads_[model_.joints[k].on(Side::child).body]);
    return load;
  }

  [[nodiscard]] double on_coupling(const Coupling& coupling) const {
    double size = 0.0;
    for (const CouplingTerm& term : coupling.terms) {
      const Load load = on_joint(term.joint);
      size = std::max(size, (is_turn(model_, term) ? load.torque : load.force) / std::abs(term.factor));
    }
    return size;
  }

  /// What a force element exerts follows from the state alone: nothing cancels in it but what draws of the state show,
  /// and what the levers of its force make of its torque.
  [[nodiscard]] Load on_element(int k) const {
    double lever = length_;
    const Attachment* one = end_of(model_.elements[k], Side::parent);
    const Attachment* other = end_of(model_.elements[k], Side::child);
    if (one != nullptr && other != nullptr) {
      const auto& bodies = shared_.state.bodies;
      lever = std::max(lever, (place(*one, bodies[one->body]).r_P - place(*other, bodies[other->body]).r_P).norm());
    }
    Load load;
    for (const Evaluation& evaluation : shared_.evaluations) {
      for (const SideWrench& side : evaluation.elements[k].on) {
        load.torque = std::max(load.torque, side.in_C.force.norm() * lever);
      }
    }
    return load;
  }

  [[nodiscard]] Load on_owner(const Quantity& quantity) const {
    if (quantity.kind == Kind::body_sum) return summed_[quantity.owner];
    if (quantity.kind == Kind::element) return on_element(quantity.owner);
    return on_joint(quantity.owner);
  }

  const Model& model_;
  const SharedState& shared_;
  double length_;
  std::vector<Load> loads_;
  std::vector<Load> shares_;           // those of add_shares() alone
  std::vector<Load> shaken_;           // the loads, and the shares on neighbours
  std::vector<Load> summed_;           // what the joints on a body add up
  std::vector<double> accelerations_;  // m/s2
  std::vector<VecX> modal_;            // accelerations by mode
};

}  // namespace

VecX term_sizes(const QuantityLayout& layout, const SharedState& shared) {
  const Loads loads(layout.model(), shared);
  VecX sizes(static_cast<Eigen::Index>(layout.quantities().size()));
  for (std::size_t row = 0; row < layout.quantities().size(); ++row) {
    sizes(static_cast<Eigen::Index>(row)) = loads.of(layout.quantities()[row]);
  }
  return sizes;
}

}  // namespace concord::compare
