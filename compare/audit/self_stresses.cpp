#include "compare/audit/machine_rank.h"

namespace concord::compare {

namespace {

/// A wrench in the frame of its side, forces times the machine's length, in both frames.
SideWrench side_wrench(const VecX& wrench, double length, const Mat3& A) {
  SideWrench both;
  both.in_C = {wrench.head<3>() / length, wrench.tail<3>()};
  both.in_global = {A * both.in_C.force, A * both.in_C.torque};
  return both;
}

}  // namespace

std::vector<Evaluation> MachineConstraints::self_stresses(const State& state) const {
  std::vector<Evaluation> all(is_sure_ ? static_cast<std::size_t>(self_stresses_.cols()) : 0);
  for (std::size_t m = 0; m < all.size(); ++m) {
    const VecX multipliers = self_stresses_.col(static_cast<Eigen::Index>(m));
    for (std::size_t k = 0; k < joints_.size(); ++k) {
      const AtJoint& at = joints_[k];
      JointWrenches& joint = all[m].joints.emplace_back();
      for (const Side side : kSides) {
        const Attachment& attachment = model_.joints[k].on(side);
        const Mat3 A = place(attachment, state.bodies[attachment.body]).A_joint;
        const double sign = side == Side::child ? 1.0 : -1.0;  // what acts on the parent is opposite
        const MatX reaction = on_side(at, side, at.reaction * multipliers);
        const MatX coordinate = on_side(at, side, at.coordinate * multipliers);
        joint.reaction[index(side)] = side_wrench(sign * reaction.col(0), length_, A);
        joint.total[index(side)] = side_wrench(sign * (reaction + coordinate).col(0), length_, A);
      }
      joint.tau = at.tau * multipliers;
      for (VecX& share : joint.shares) share = VecX::Zero(joint.tau.size());
      joint.shares[index(Actor::driver)] = at.driver * multipliers;
    }
    for (const Eigen::Index column : couplings_) {
      all[m].couplings.push_back(multipliers(column) / sizes_(column));
    }
  }
  return all;
}

}  // namespace concord::compare
