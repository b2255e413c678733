// Compiled without NDEBUG and as C++17, as the library itself is: see CMakeLists.txt.
#include <Simbody.h>
#include <fmt/format.h>

#include <cmath>

#include "common/error.h"
#include "compare/oracle/recipes.h"
#include "compare/oracle/simbody_parts.h"

/// Brings Simbody's machine into a given state.
namespace concord::compare::oracle {

namespace {

/// Where Simbody places a body further from the given place than this part of the machine's length, or by this angle
/// [rad], the translation is at fault: states are closed to 1e-13.
constexpr double kMisplaced = 1e-10;

/// The angle of the frames, with as many turns as the place on the thread tells.
double turn_of_screw(const Transform& X_FM, double lead) {
  const SimTK::Mat33& R = X_FM.R().asMat33();
  const double angle = std::atan2(R(1, 0), R(0, 0));
  const double turn = 2.0 * SimTK::Pi;
  return angle + turn * std::round((X_FM.p()[2] / lead - angle) / turn);
}

}  // namespace

/// From the joint's frame on the parent to its frame on the child, whose mobilizers are `from` and `to`.
Transform SimbodyMachine::Parts::relative_place(const Frames& frames, const Transform& parent,
                                                const Transform& child) const {
  return ~(parent * mobod(frames.from).getDefaultInboardFrame()) * (child * mobod(frames.to).getDefaultOutboardFrame());
}

/// The rate of relative_place() in the frame on the parent: angular velocity, and that of the point.
SpatialVec SimbodyMachine::Parts::relative_velocity(const Frames& frames, const BodyState& parent,
                                                    const BodyState& child) const {
  const Transform X_GP = place_of(parent);
  const Transform X_GB = place_of(child);
  const Transform X_GF = X_GP * mobod(frames.from).getDefaultInboardFrame();
  const Transform X_GM = X_GB * mobod(frames.to).getDefaultOutboardFrame();
  const SpatialVec V_P = velocity_of(parent);
  const SpatialVec V_B = velocity_of(child);
  // The point of the child as seen from the parent, wherever on the parent it stands.
  const SimTK::Vec3 passing = V_P[1] + V_P[0] % (X_GM.p() - X_GP.p());
  const SimTK::Vec3 v_M = V_B[1] + V_B[0] % (X_GM.p() - X_GB.p());
  return {~X_GF.R() * (V_B[0] - V_P[0]), ~X_GF.R() * (v_M - passing)};
}

void SimbodyMachine::Parts::place(const State& given) {
  for (const Carrier& carrier : carriers_) {
    mobod(carrier.moved).setQToFitTransform(state_, place_of(given.bodies[carrier.body]));
  }
  for (const BuiltJoint& built : joints_) {
    const Transform X_FM = relative_place(built.frames(), place_of(given.bodies[built.body_on(Side::parent)]),
                                          place_of(given.bodies[built.body_on(Side::child)]));
    const MobilizedBody& moved = mobod(built.moved);
    if (built.has_link()) {
      const int k = static_cast<int>(&built - joints_.data());
      const bool has_hint = !given.q.empty() && given.q[k].size() > 1;
      place_link(built, X_FM, has_hint ? given.q[k](1) : 0.0);
    } else if (built.recipe->mobilizer == Mobilizer::screw) {
      moved.setOneQ(state_, 0, turn_of_screw(X_FM, lead_of(*built.joint->type) / units_.length));
    } else {
      moved.setQToFitTransform(state_, X_FM);
    }
  }
  system_.realize(state_, SimTK::Stage::Position);
}

/// Turns a link so that it points to the child's point, and then the ball at its end. `turn`: the link's second turn
/// roughly, because two pairs of turns of a universal joint point along the same line.
void SimbodyMachine::Parts::place_link(const BuiltJoint& built, const Transform& X_FM, double turn) {
  const MobilizedBody& link = mobod(built.moved);
  const SimTK::Vec3& gap = X_FM.p();
  SimTK::Rotation R_FL;
  if (built.recipe->mobilizer == Mobilizer::pin) {
    link.setOneQ(state_, 0, std::atan2(gap[1], gap[0]));
    R_FL.setRotationFromAngleAboutZ(link.getOneQ(state_, 0));
  } else {
    const double side = std::cos(turn) < 0.0 ? -1.0 : 1.0;
    link.setOneQ(state_, 0, std::atan2(-side * gap[1], side * gap[2]));
    link.setOneQ(state_, 1, std::atan2(gap[0], side * std::hypot(gap[1], gap[2])));
    R_FL.setRotationFromTwoAnglesTwoAxes(SimTK::BodyRotationSequence, link.getOneQ(state_, 0), SimTK::XAxis,
                                         link.getOneQ(state_, 1), SimTK::YAxis);
  }
  mobod(built.child).setQToFitRotation(state_, ~R_FL * X_FM.R());
}

void SimbodyMachine::Parts::set_in_motion(const State& given) {
  for (const Carrier& carrier : carriers_) {
    const SpatialVec velocity =
        relative_velocity({carrier.moved, carrier.moved}, given.bodies[kGround], given.bodies[carrier.body]);
    mobod(carrier.moved).setUToFitVelocity(state_, velocity);
  }
  for (const BuiltJoint& built : joints_) {
    const SpatialVec velocity = relative_velocity(built.frames(), given.bodies[built.body_on(Side::parent)],
                                                  given.bodies[built.body_on(Side::child)]);
    system_.realize(state_, SimTK::Stage::Position);  // setting speeds takes places back
    if (built.has_link()) {
      move_link(built, velocity);
    } else if (built.recipe->mobilizer == Mobilizer::screw) {
      mobod(built.moved).setUToFitAngularVelocity(state_, velocity[0]);
    } else {
      mobod(built.moved).setUToFitVelocity(state_, velocity);
    }
  }
}

/// The turning speeds of a link, and then those of the ball at its end, so that the child moves with `velocity` in the
/// frame on the parent.
void SimbodyMachine::Parts::move_link(const BuiltJoint& built, const SpatialVec& velocity) {
  const MobilizedBody& link = mobod(built.moved);
  const SimTK::Rotation R_FL = link.getMobilizerTransform(state_).R();
  const Vec3 end = from_simbody(R_FL * mobod(built.child).getDefaultInboardFrame().p());
  const auto n = static_cast<Eigen::Index>(built.recipe->mobilities.size());
  Mat3X axes(3, n);
  Mat3X levers(3, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    axes.col(k) = from_simbody(link.getH_FMCol(state_, MobilizerUIndex(built.recipe->mobilities[k].number))[0]);
    levers.col(k) = axes.col(k).cross(end);
  }
  const VecX speeds = (levers.transpose() * levers).ldlt().solve(levers.transpose() * from_simbody(velocity[1]));
  for (Eigen::Index k = 0; k < n; ++k) link.setOneU(state_, built.recipe->mobilities[k].number, speeds(k));
  system_.realize(state_, SimTK::Stage::Position);
  mobod(built.child).setUToFitAngularVelocity(state_, ~R_FL * (velocity[0] - to_simbody(Vec3(axes * speeds))));
}

void SimbodyMachine::Parts::check_places(const State& given) const {
  const auto check = [&](MobilizedBodyIndex part, int body) {
    const Transform is = mobod(part).getBodyTransform(state_);
    const Transform should_be = place_of(given.bodies[body]);
    const double off = (is.p() - should_be.p()).norm();
    const double turned = (is.R().asMat33() - should_be.R().asMat33()).norm();
    const double size = 1.0 + should_be.p().norm();
    if (off <= kMisplaced * size && turned <= kMisplaced) return;
    throw SolverError(
        fmt::format("simbody: t = {:g} s: the mobilizers leave body {} {:.1e} lengths and {:.1e} rad from "
                    "its place",
                    given.t, model_.bodies[body].name, off, turned));
  };
  for (const BuiltJoint& built : joints_) check(built.child, built.joint->on(Side::child).body);
}

}  // namespace concord::compare::oracle
