#pragma once

#include <Simbody.h>

#include <vector>

#include "compare/oracle/plan.h"
#include "compare/oracle/recipes.h"
#include "compare/oracle/simbody_machine.h"

/// A machine as it stands in Simbody. Only for sources that are compiled as the library is: see CMakeLists.txt.
namespace concord::compare::oracle {

using SimTK::MobilizedBody;
using SimTK::MobilizedBodyIndex;
using SimTK::MobilizerUIndex;
using SimTK::SpatialVec;
using SimTK::Transform;

inline SimTK::Vec3 to_simbody(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline Vec3 from_simbody(const SimTK::Vec3& v) { return {v[0], v[1], v[2]}; }

inline SimTK::Rotation to_simbody(const Mat3& A) {
  return SimTK::Rotation(SimTK::Mat33(A(0, 0), A(0, 1), A(0, 2), A(1, 0), A(1, 1), A(1, 2), A(2, 0), A(2, 1), A(2, 2)));
}

/// Simbody weighs rows of lengths against rows of angles when it seeks the rank of the constraints, so a machine is
/// handed over in lengths and masses of its own; the second stays.
struct Units {
  double length = 1.0;  // m
  double mass = 1.0;    // kg

  [[nodiscard]] double force() const { return mass * length; }
  [[nodiscard]] double torque() const { return mass * length * length; }
  /// Of the force on a joint speed.
  [[nodiscard]] double of(const Mobility& mobility) const { return mobility.slides ? force() : torque(); }
  [[nodiscard]] SimTK::Vec3 place(const Vec3& in_m) const { return to_simbody(Vec3(in_m / length)); }
};

/// Unit quaternion to rotation; the scalar stands first in both.
inline Mat3 rotation_of_state(const BodyState& body) {
  const Vec4 p = body.p.normalized();
  return Eigen::Quaterniond(p(0), p(1), p(2), p(3)).toRotationMatrix();
}

/// The lead of a screw, as the joint's own type states it.
double lead_of(const joints::JointType& type);

/// The mobilizers that hold a joint's frame on the parent and its frame on the child: two where there is a link.
struct Frames {
  MobilizedBodyIndex from;
  MobilizedBodyIndex to;
};

/// A joint as it stands in Simbody.
struct BuiltJoint {
  const Joint* joint = nullptr;
  const Recipe* recipe = nullptr;
  MobilizedBodyIndex moved;   // whose mobilizer has the recipe's mobilities: the child's part, or the link
  MobilizedBodyIndex child;   // the child's part
  MobilizedBodyIndex parent;  // the parent itself
  std::vector<SimTK::ConstraintIndex> beside;
  std::vector<bool> is_forced;  // whether something acts on each of the recipe's mobilities

  [[nodiscard]] bool has_link() const { return recipe->link >= 0; }
  [[nodiscard]] Frames frames() const { return {moved, child}; }
  [[nodiscard]] int body_on(Side side) const { return joint->on(side).body; }
};

/// A driven coordinate.
struct BuiltDriver {
  const Driver* driver = nullptr;
  bool slides = false;
  SimTK::ConstraintIndex constraint;
};

/// A mobilizer that lets a body go free.
struct Carrier {
  int body = 0;
  MobilizedBodyIndex moved;
};

struct SimbodyMachine::Parts {
  explicit Parts(const Model& stated);

  Evaluation evaluate(const State& state, const KnownForces& forces);

 private:
  void check_expressible() const;
  void check_parts(const std::vector<int>& parts) const;
  void build_bystander();
  void build();
  void build_step(const Step& step, const std::vector<int>& parts);
  void build_joint(BuiltJoint& built, const SimTK::Body& body, int k);
  void build_beside(BuiltJoint& built);
  void build_driver(int k, const Driver& driver);
  void build_coupling(const Coupling& coupling);

  /// The mobility of the speed that a word's coordinate has.
  [[nodiscard]] const Mobility& mobility_of(int k, int word, int component) const;
  [[nodiscard]] const MobilizedBody& mobod(MobilizedBodyIndex k) const { return matter_.getMobilizedBody(k); }

  // In one state:
  void place(const State& given);
  void place_link(const BuiltJoint& built, const Transform& X_FM, double turn);
  void set_in_motion(const State& given);
  void move_link(const BuiltJoint& built, const SpatialVec& velocity);
  [[nodiscard]] Transform relative_place(const Frames& frames, const Transform& parent, const Transform& child) const;
  [[nodiscard]] SpatialVec relative_velocity(const Frames& frames, const BodyState& parent,
                                             const BodyState& child) const;
  void check_places(const State& given) const;
  void apply(const State& given, const KnownForces& forces);
  void read(const State& given, Evaluation& found);
  [[nodiscard]] JointWrenches read_joint(const BuiltJoint& built, const State& given) const;
  [[nodiscard]] Vec6 coordinate_wrench(const BuiltJoint& built, const VecX& tau) const;
  [[nodiscard]] VecX forces_on_mobilities(const BuiltJoint& built) const;
  [[nodiscard]] Wrench total_on_child(const BuiltJoint& built) const;
  [[nodiscard]] Vec6 direction(const BuiltJoint& built, const Mobility& mobility) const;

  [[nodiscard]] Transform place_of(const BodyState& body) const {
    return {to_simbody(rotation_of_state(body)), units_.place(body.r)};
  }
  [[nodiscard]] SpatialVec velocity_of(const BodyState& body) const {
    return {to_simbody(body.omega), units_.place(body.v)};
  }
  [[nodiscard]] Wrench wrench_of(const SpatialVec& in_own_units) const {
    return {from_simbody(in_own_units[1]) * units_.force(), from_simbody(in_own_units[0]) * units_.torque()};
  }

  const Model& model_;
  Units units_;
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_{system_};
  SimTK::GeneralForceSubsystem forces_{system_};
  SimTK::Force::Gravity gravity_;
  SimTK::Force::DiscreteForces known_{forces_, matter_};
  std::vector<MobilizedBodyIndex> bodies_;  // the main part of each
  std::vector<BuiltJoint> joints_;
  std::vector<Carrier> carriers_;
  std::vector<BuiltDriver> drivers_;
  std::vector<SimTK::ConstraintIndex> couplings_;
  SimTK::State state_;
  SimTK::Vector_<SpatialVec> reactions_;
};

}  // namespace concord::compare::oracle
