// Compiled without NDEBUG and as C++17, as the library itself is: see CMakeLists.txt.
#include <Simbody.h>
#include <fmt/format.h>

#include "common/error.h"
#include "compare/oracle/recipes.h"
#include "compare/oracle/simbody_parts.h"

/// What acts on Simbody's machine, and what it answers: accelerations, reactions, forces of couplings.
namespace concord::compare::oracle {

namespace {

/// A wrench about one point, about another one: `from` is the vector from the new point to the old one.
Wrench shifted(const Wrench& wrench, const Vec3& from) {
  return {wrench.force, wrench.torque + from.cross(wrench.force)};
}

SideWrench in_both_frames(const Wrench& wrench, const Mat3& A_joint) {
  return {{A_joint.transpose() * wrench.force, A_joint.transpose() * wrench.torque}, wrench};
}

}  // namespace

void SimbodyMachine::Parts::apply(const State& given, const KnownForces& forces) {
  known_.clearAllForces(state_);
  for (std::size_t k = 1; k < model_.bodies.size(); ++k) {
    const Wrench& wrench = forces.on_bodies[k];
    known_.setOneBodyForce(
        state_, mobod(bodies_[k]),
        {to_simbody(Vec3(wrench.torque / units_.torque())), to_simbody(Vec3(wrench.force / units_.force()))});
  }
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    for (const Mobility& mobility : joints_[k].recipe->mobilities) {
      const double tau = forces.on_speeds[k](mobility.speed) / units_.of(mobility);
      if (tau == 0.0) continue;
      known_.setOneMobilityForce(state_, mobod(joints_[k].moved), MobilizerUIndex(mobility.number), tau);
    }
  }
  for (const BuiltDriver& driver : drivers_) {
    const SimTK::Constraint& constraint = matter_.getConstraint(driver.constraint);
    SimTK::Constraint::ConstantAcceleration::downcast(constraint)
        .setAcceleration(state_,
                         concord::evaluate(driver.driver->law, given.t).fddot / (driver.slides ? units_.length : 1.0));
  }
}

/// Column of the relative velocity [of the child's point; angular] that a mobility causes, global axes.
Vec6 SimbodyMachine::Parts::direction(const BuiltJoint& built, const Mobility& mobility) const {
  const MobilizedBody& moved = mobod(built.moved);
  const SimTK::Rotation R_GF = mobod(built.parent).getBodyRotation(state_) * moved.getDefaultInboardFrame().R();
  const SpatialVec column = moved.getH_FMCol(state_, MobilizerUIndex(mobility.number));
  SimTK::Vec3 velocity = R_GF * column[1];
  const SimTK::Vec3 turning = R_GF * column[0];
  if (built.has_link()) {
    const MobilizedBody& child = mobod(built.child);
    velocity += turning % (child.findStationLocationInGround(state_, child.getDefaultOutboardFrame().p()) -
                           moved.getBodyOriginLocation(state_));
  }
  Vec6 both;
  both << from_simbody(velocity) * (mobility.slides ? 1.0 : units_.length), from_simbody(turning);
  return both;
}

Wrench SimbodyMachine::Parts::total_on_child(const BuiltJoint& built) const {
  Wrench total = wrench_of(reactions_[built.child]);
  const MobilizedBody& child = mobod(built.child);
  const Vec3 arm = from_simbody(child.getBodyRotation(state_) * child.getDefaultOutboardFrame().p()) * units_.length;
  for (const SimTK::ConstraintIndex index : built.beside) {
    const SimTK::Constraint& constraint = matter_.getConstraint(index);
    const SimTK::Vector_<SpatialVec> forces = constraint.getConstrainedBodyForcesAsVector(state_);
    for (SimTK::ConstrainedBodyIndex k(0); k < constraint.getNumConstrainedBodies(); ++k) {
      if (constraint.getMobilizedBodyFromConstrainedBody(k).getMobilizedBodyIndex() != built.child) continue;
      const SpatialVec opposite = -forces[k];  // Simbody's constraint forces stand on the left of its equations
      total += shifted(wrench_of(opposite), -arm);
    }
  }
  return total;
}

/// Of the total wrench on the child, the part that the forces tau on the mobilities make up: in the span of the
/// directions along which they act, and S^T of it is tau. Forces that act on no mobility are none.
Vec6 SimbodyMachine::Parts::coordinate_wrench(const BuiltJoint& built, const VecX& tau) const {
  const Eigen::Index n = tau.size();
  if (n == 0) return Vec6::Zero();
  MatX S(6, n);
  MatX acting = MatX::Zero(6, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Mobility& mobility = built.recipe->mobilities[k];
    S.col(k) = direction(built, mobility);
    if (mobility.slides || built.has_link()) {
      acting.col(k).head<3>() = S.col(k).head<3>();
    } else {
      acting.col(k).tail<3>() = S.col(k).tail<3>();
    }
  }
  return acting * (S.transpose() * acting).partialPivLu().solve(tau);
}

/// Forces on the recipe's mobilities: what moves in a mobilizer is part of Simbody's reaction there.
VecX SimbodyMachine::Parts::forces_on_mobilities(const BuiltJoint& built) const {
  const auto n = static_cast<Eigen::Index>(built.recipe->mobilities.size());
  const SimTK::Rotation R_GF =
      mobod(built.parent).getBodyRotation(state_) * mobod(built.moved).getDefaultInboardFrame().R();
  const SpatialVec& reaction = reactions_[built.moved];
  VecX tau = VecX::Zero(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    if (!built.is_forced[k]) continue;
    const SpatialVec column =
        mobod(built.moved).getH_FMCol(state_, MobilizerUIndex(built.recipe->mobilities[k].number));
    tau(k) = units_.of(built.recipe->mobilities[k]) *
             (SimTK::dot(R_GF * column[0], reaction[0]) + SimTK::dot(R_GF * column[1], reaction[1]));
  }
  return tau;
}

JointWrenches SimbodyMachine::Parts::read_joint(const BuiltJoint& built, const State& given) const {
  const Joint& joint = *built.joint;
  const Wrench total = total_on_child(built);
  const VecX tau = forces_on_mobilities(built);
  const Vec6 known = coordinate_wrench(built, tau);
  Wrench reaction = total;
  reaction += {-known.head<3>(), -known.tail<3>()};
  JointWrenches found;
  found.tau = VecX::Zero(joint.type->n_u());
  for (Eigen::Index k = 0; k < tau.size(); ++k) found.tau(built.recipe->mobilities[k].speed) = tau(k);
  found.shares.fill(VecX::Zero(joint.type->n_u()));  // springs are given to it, as in force elements: it has no opinion
  std::array<Mat3, 2> A_joint;
  std::array<Vec3, 2> point;
  for (const Side side : kSides) {
    const Attachment& at = joint.on(side);
    const Mat3 A = rotation_of_state(given.bodies[at.body]);
    A_joint[index(side)] = A * at.C;
    point[index(side)] = given.bodies[at.body].r + A * at.point_L;
  }
  const auto write = [&](const Wrench& on_child, std::array<SideWrench, 2>& both) {
    const Wrench opposite{-on_child.force, -on_child.torque};
    both[index(Side::child)] = in_both_frames(on_child, A_joint[index(Side::child)]);
    both[index(Side::parent)] = in_both_frames(
        shifted(opposite, point[index(Side::child)] - point[index(Side::parent)]), A_joint[index(Side::parent)]);
  };
  write(total, found.total);
  write(reaction, found.reaction);
  return found;
}

void SimbodyMachine::Parts::read(const State& given, Evaluation& found) {
  matter_.calcMobilizerReactionForces(state_, reactions_);
  found.bodies.resize(model_.bodies.size());
  for (std::size_t k = 1; k < bodies_.size(); ++k) {
    found.bodies[k].vdot = from_simbody(mobod(bodies_[k]).getBodyOriginAcceleration(state_)) * units_.length;
    found.bodies[k].omegadot = from_simbody(mobod(bodies_[k]).getBodyAngularAcceleration(state_));
    if (found.bodies[k].vdot.allFinite() && found.bodies[k].omegadot.allFinite()) continue;
    throw SolverError(
        fmt::format("simbody: t = {:g} s: the acceleration of body {} is not finite", given.t, model_.bodies[k].name));
  }
  for (const BuiltJoint& built : joints_) found.joints.push_back(read_joint(built, given));
  for (const SimTK::ConstraintIndex index : couplings_) {
    // A multiplier stands on the left of Simbody's equations: it pushes the sum to fall.
    found.couplings.push_back(-units_.torque() * matter_.getConstraint(index).getMultipliersAsVector(state_)[0]);
  }
}

}  // namespace concord::compare::oracle
