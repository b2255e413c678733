#include "compare/audit/joint_power.h"

#include <limits>

#include "common/decompositions.h"

namespace concord::compare {

namespace {

/// Of motors, springs and dampers, one below the other.
VecX stacked(const std::array<VecX, kActors.size()>& shares) {
  VecX all(3 * shares.front().size());
  all << shares[index(Actor::motor)], shares[index(Actor::spring)], shares[index(Actor::damper)];
  return all;
}

Vec6 in_parent_frame(const std::array<PlacedFrame, 2>& frames, const Wrench& wrench) {
  const Mat3 to_parent = frames[index(Side::parent)].A_joint.transpose();
  return Wrench{to_parent * wrench.force, to_parent * wrench.torque}.vector();
}

}  // namespace

JointPower::JointPower(const Joint& joint, const std::vector<LawOfForce>& springs,
                       const std::array<PlacedFrame, 2>& frames, const JointWrenches& wrenches, const VecX& coupled,
                       const VecX& hint, double t)
    : relative_(relative_motion(frames[index(Side::parent)], frames[index(Side::child)])),
      motion_(read_motion(*joint.type, relative_, hint)),
      total_(in_parent_frame(frames, wrenches.total_on(Side::child).in_global)),
      reaction_(in_parent_frame(frames, wrenches.reaction_on(Side::child).in_global)),
      wrenches_(wrenches),
      coupled_(coupled),
      by_laws_(stacked(shares_by_laws(joint, springs, motion_, t))),
      directions_(coordinate_wrench_directions(*joint.type, relative_, motion_.S)) {}

VecX JointPower::of_reaction() const { return motion_.free.transpose() * (motion_.S.transpose() * reaction_); }

VecX JointPower::beyond_tau() const {
  return motion_.free.transpose() * (motion_.S.transpose() * total_ - wrenches_.tau);
}

Vec6 JointPower::outside_coordinates(double length) const {
  Vec6 rest = total_ - reaction_;
  if (directions_.cols() == 0) return rest;
  const Vec6 weights = (Vec6() << Vec3::Constant(length), Vec3::Ones()).finished();
  const Mat6X weighted = weights.asDiagonal() * directions_;
  rest -= directions_ * least_squares(weighted, weights.asDiagonal() * rest);
  return rest;
}

VecX JointPower::beyond_law() const {
  VecX residuals(by_laws_.size() + coupled_.size());
  residuals << stacked(wrenches_.shares) - by_laws_, wrenches_.tau - coupled_;
  for (const VecX& share : wrenches_.shares) residuals.tail(coupled_.size()) -= share;
  return residuals;
}

VecX JointPower::sizes_of_laws(const Joint& joint, const std::vector<LawOfForce>& springs, double t) const {
  return coupled_.cwiseAbs().cwiseMax(sizes_of_springs(joint, springs, motion_, t)).cwiseMax(wrenches_.tau.cwiseAbs());
}

VecX JointPower::change_with_last_digits(const Joint& joint, const std::vector<LawOfForce>& springs, double t) const {
  JointMotion moved = motion_;
  moved.q *= 1.0 + 4.0 * std::numeric_limits<double>::epsilon();
  return change_of_laws(stacked(shares_by_laws(joint, springs, moved, t)));
}

VecX JointPower::change_of_laws(const VecX& there) const {
  VecX change = VecX::Zero(by_laws_.size() + coupled_.size());
  change.head(by_laws_.size()) = (by_laws_ - there).cwiseAbs();
  return change;
}

}  // namespace concord::compare
