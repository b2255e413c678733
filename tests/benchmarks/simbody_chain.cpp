// Compiled without NDEBUG, as the library itself is: its headers lay classes out differently with it.
#include "tests/benchmarks/simbody_chain.h"

#include <Simbody.h>

namespace concord::benchmarks {

namespace {

SimTK::Vec3 vector_of(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

SimTK::Rotation rotation_of(const Mat3& A) {
  return SimTK::Rotation(SimTK::Mat33(A(0, 0), A(0, 1), A(0, 2), A(1, 0), A(1, 1), A(1, 2), A(2, 0), A(2, 1), A(2, 2)));
}

SimTK::Transform frame_of(const Attachment& side) { return {rotation_of(side.C), vector_of(side.point_L)}; }

/// Simbody wants the inertia about the body's origin.
SimTK::MassProperties mass_of(const Body& body) {
  const Mat3& I = body.inertia_L;
  const SimTK::Vec3 center = vector_of(body.center_of_mass_L);
  const SimTK::Inertia about_center(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
  return {body.mass, center, about_center.shiftFromMassCenter(-center, body.mass)};
}

}  // namespace

struct SimbodyChain::Machine {
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter{system};
  SimTK::GeneralForceSubsystem forces{system};
  SimTK::Force::UniformGravity gravity;
  std::vector<SimTK::MobilizedBodyIndex> bodies;
  SimTK::State state;
  SimTK::Vector_<SimTK::SpatialVec> reactions;

  explicit Machine(const Model& model) : gravity(forces, matter, vector_of(model.gravity)) {}
};

SimbodyChain::SimbodyChain(const Chain& chain) : machine_(std::make_unique<Machine>(chain.model)) {
  SimTK::MobilizedBodyIndex parent = machine_->matter.getGround().getMobilizedBodyIndex();
  for (std::size_t k = 0; k < chain.model.joints.size(); ++k) {
    const Joint& joint = chain.model.joints[k];
    const SimTK::MobilizedBody::Pin pin(machine_->matter.updMobilizedBody(parent), frame_of(joint.on(Side::parent)),
                                        SimTK::Body::Rigid(mass_of(chain.model.bodies[k + 1])),
                                        frame_of(joint.on(Side::child)));
    parent = pin.getMobilizedBodyIndex();
    machine_->bodies.push_back(parent);
  }
  machine_->state = machine_->system.realizeTopology();
  machine_->system.realizeModel(machine_->state);
  for (std::size_t k = 0; k < machine_->bodies.size(); ++k) {
    const SimTK::MobilizedBody& body = machine_->matter.getMobilizedBody(machine_->bodies[k]);
    body.setOneQ(machine_->state, 0, chain.angles(static_cast<Eigen::Index>(k)));
    body.setOneU(machine_->state, 0, chain.speeds(static_cast<Eigen::Index>(k)));
  }
}

SimbodyChain::~SimbodyChain() = default;

void SimbodyChain::evaluate() {
  machine_->state.updQ();  // says that positions have changed: nothing is kept from the evaluation before
  machine_->system.realize(machine_->state, SimTK::Stage::Acceleration);
  machine_->matter.calcMobilizerReactionForces(machine_->state, machine_->reactions);
}

double SimbodyChain::acceleration(int joint) const {
  return machine_->matter.getMobilizedBody(machine_->bodies[joint]).getOneUDot(machine_->state, 0);
}

Wrench SimbodyChain::reaction(int joint) const {
  const SimTK::SpatialVec& both = machine_->reactions[machine_->bodies[joint]];
  const SimTK::Vec3& torque = both[0];
  const SimTK::Vec3& force = both[1];
  return {{force[0], force[1], force[2]}, {torque[0], torque[1], torque[2]}};
}

}  // namespace concord::benchmarks
