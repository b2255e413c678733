#include "compare/oracle/simbody_oracle.h"

#include <cmath>

#include "compare/audit/element_laws.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/places.h"
#include "compare/oracle/simbody_machine.h"

namespace concord::compare::oracle {

namespace {

/// A joint whose coordinates have springs, with their laws.
struct SprungJoint {
  int joint = 0;
  std::vector<LawOfForce> laws;
};

class SimbodyOracle final : public ThirdOpinion {
 public:
  explicit SimbodyOracle(const Model& model) : model_(model), machine_(model) {
    for (const ForceElement& element : model.elements) elements_.emplace_back(element, elements_.size());
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      if (model.joints[k].springs.empty()) continue;
      SprungJoint sprung{static_cast<int>(k), {}};
      for (const JointSpring& spring : model.joints[k].springs) sprung.laws.emplace_back(spring.law);
      sprung_.push_back(std::move(sprung));
    }
  }

  [[nodiscard]] std::string_view name() const override { return "simbody"; }

  Evaluation evaluate(const State& state) override {
    std::vector<ElementWrenches> exerted;
    const KnownForces forces = forces_in(state, exerted);
    Evaluation found = machine_.evaluate(state, forces);
    found.elements = std::move(exerted);
    return found;
  }

 private:
  KnownForces forces_in(const State& state, std::vector<ElementWrenches>& exerted) const {
    KnownForces forces;
    forces.on_bodies.resize(model_.bodies.size());
    for (const Joint& joint : model_.joints) forces.on_speeds.emplace_back(VecX::Zero(joint.type->n_u()));
    for (std::size_t k = 0; k < elements_.size(); ++k) {
      exerted.push_back(add_element(model_.elements[k], elements_[k].wrenches(state), state, forces.on_bodies));
    }
    for (const SprungJoint& sprung : sprung_) forces.on_speeds[sprung.joint] = tau_of(sprung, state);
    return forces;
  }

  /// Adds the element's wrenches to its bodies, and returns them in the frames of its ends too.
  static ElementWrenches add_element(const ForceElement& element, const std::array<Wrench, 2>& wrenches,
                                     const State& state, std::vector<Wrench>& on_bodies) {
    ElementWrenches both;
    for (const Side side : kSides) {
      const Attachment* end = end_of(element, side);
      if (end == nullptr) continue;
      const PlacedFrame at = place(*end, state.bodies[end->body]);
      const Wrench& wrench = wrenches[index(side)];
      on_bodies[end->body] += {wrench.force, wrench.torque + at.lever.cross(wrench.force)};
      both.on[index(side)] = {{at.A_joint.transpose() * wrench.force, at.A_joint.transpose() * wrench.torque}, wrench};
    }
    return both;
  }

  /// What the springs of a joint exert. Of a coordinate that is driven too the driver's force is whatever is left:
  /// there the spring is left out.
  [[nodiscard]] VecX tau_of(const SprungJoint& sprung, const State& state) const {
    const Joint& joint = model_.joints[sprung.joint];
    const VecX hint = state.q.empty() ? VecX() : state.q[sprung.joint];
    const JointMotion motion = read_motion(*joint.type, relative_motion_of(joint, state), hint);
    VecX tau = tau_by_laws(joint, sprung.laws, motion, state.t);
    return tau.unaryExpr([](double value) { return std::isnan(value) ? 0.0 : value; });
  }

  const Model& model_;
  SimbodyMachine machine_;
  std::vector<ElementLaw> elements_;
  std::vector<SprungJoint> sprung_;
};

}  // namespace

std::unique_ptr<ThirdOpinion> make_simbody(const Model& model) { return std::make_unique<SimbodyOracle>(model); }

}  // namespace concord::compare::oracle
