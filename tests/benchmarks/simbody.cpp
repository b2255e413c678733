// Compiled without NDEBUG, as the library itself is: its headers lay classes out differently with it.
#include <Simbody.h>

#include <Eigen/Geometry>

#include "tests/benchmarks/evaluators.h"

namespace concord::benchmarks {

namespace {

SimTK::Vec3 vector_of(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

SimTK::Rotation rotation_of(const Mat3& A) {
  return SimTK::Rotation(SimTK::Mat33(A(0, 0), A(0, 1), A(0, 2), A(1, 0), A(1, 1), A(1, 2), A(2, 0), A(2, 1), A(2, 2)));
}

Mat3 rotation_of(const BodyState& body) {
  return Eigen::Quaterniond(body.p(0), body.p(1), body.p(2), body.p(3)).toRotationMatrix();
}

SimTK::Transform frame_of(const Attachment& side) { return {rotation_of(side.C), vector_of(side.point_L)}; }

/// Simbody wants the inertia about the body's origin.
SimTK::MassProperties mass_of(const Body& body) {
  const Mat3& I = body.inertia_L;
  const SimTK::Vec3 center = vector_of(body.center_of_mass_L);
  const SimTK::Inertia about_center(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
  return {body.mass, center, about_center.shiftFromMassCenter(-center, body.mass)};
}

/// A joint whose child nothing carries yet becomes a mobilizer, another one constraints.
class Simbody : public Evaluator {
 public:
  explicit Simbody(const Machine& machine) : gravity_(forces_, matter_, vector_of(machine.model.gravity)) {
    bodies_.resize(machine.model.bodies.size());
    bodies_[kGround] = matter_.getGround().getMobilizedBodyIndex();
    for (const Joint& joint : machine.model.joints) {
      const bool carries = !bodies_[joint.on(Side::child).body].isValid();
      if (carries) add_mobilizer(machine.model, joint);
      if (!carries) add_constraints(joint);
      mobilizers_.push_back(carries ? bodies_[joint.on(Side::child).body] : SimTK::MobilizedBodyIndex());
    }
    state_ = system_.realizeTopology();
    system_.realizeModel(state_);
    for (std::size_t k = 0; k < mobilizers_.size(); ++k) {
      if (mobilizers_[k].isValid()) place(machine, machine.model.joints[k], mobilizers_[k]);
    }
  }

  void evaluate() override {
    state_.updQ();  // says that positions have changed: nothing is kept from the evaluation before
    system_.realize(state_, SimTK::Stage::Acceleration);
    matter_.calcMobilizerReactionForces(state_, reactions_);
  }

  [[nodiscard]] std::optional<Wrench> reaction(std::size_t k) const override {
    if (!mobilizers_[k].isValid()) return std::nullopt;
    const SimTK::SpatialVec& both = reactions_[mobilizers_[k]];
    return Wrench{{both[1][0], both[1][1], both[1][2]}, {both[0][0], both[0][1], both[0][2]}};
  }

 private:
  SimTK::MobilizedBody& body_on(const Joint& joint, Side side) {
    return matter_.updMobilizedBody(bodies_[joint.on(side).body]);
  }

  void add_mobilizer(const Model& model, const Joint& joint) {
    const auto add = [&](auto make) {
      const int child = joint.on(Side::child).body;
      bodies_[child] = make(body_on(joint, Side::parent), frame_of(joint.on(Side::parent)),
                            SimTK::Body::Rigid(mass_of(model.bodies[child])), frame_of(joint.on(Side::child)))
                           .getMobilizedBodyIndex();
    };
    if (joint.type->name == "revolute") add([](auto&&... words) { return SimTK::MobilizedBody::Pin(words...); });
    if (joint.type->name == "spherical") add([](auto&&... words) { return SimTK::MobilizedBody::Ball(words...); });
  }

  void add_constraints(const Joint& joint) {
    const Attachment& on_parent = joint.on(Side::parent);
    const Attachment& on_child = joint.on(Side::child);
    SimTK::MobilizedBody& parent = body_on(joint, Side::parent);
    SimTK::MobilizedBody& child = body_on(joint, Side::child);
    const SimTK::Constraint::Ball same_place(parent, vector_of(on_parent.point_L), child, vector_of(on_child.point_L));
    const SimTK::UnitVec3 x(vector_of(on_parent.C.col(0)));
    const SimTK::UnitVec3 y(vector_of(on_child.C.col(1)));
    if (joint.type->name == "universal") const SimTK::Constraint::ConstantAngle across(parent, x, child, y);
  }

  /// Coordinates and speeds of a mobilizer from how its bodies stand and turn.
  void place(const Machine& machine, const Joint& joint, SimTK::MobilizedBodyIndex k) {
    const BodyState& parent = machine.state.bodies[joint.on(Side::parent).body];
    const BodyState& child = machine.state.bodies[joint.on(Side::child).body];
    const Mat3 F = rotation_of(parent) * joint.on(Side::parent).C;
    const Mat3 M = rotation_of(child) * joint.on(Side::child).C;
    SimTK::MobilizedBody& moved = matter_.updMobilizedBody(k);
    moved.setQToFitRotation(state_, rotation_of(Mat3(F.transpose() * M)));
    moved.setUToFitAngularVelocity(state_, vector_of(F.transpose() * (child.omega - parent.omega)));
  }

  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_{system_};
  SimTK::GeneralForceSubsystem forces_{system_};
  SimTK::Force::UniformGravity gravity_;
  std::vector<SimTK::MobilizedBodyIndex> bodies_;
  std::vector<SimTK::MobilizedBodyIndex> mobilizers_;  // by joint
  SimTK::State state_;
  SimTK::Vector_<SimTK::SpatialVec> reactions_;
};

}  // namespace

std::unique_ptr<Evaluator> make_simbody(const Machine& machine) { return std::make_unique<Simbody>(machine); }

}  // namespace concord::benchmarks
