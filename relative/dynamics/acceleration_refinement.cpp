#include "relative/dynamics/acceleration_refinement.h"

namespace concord::relative {

AccelerationRefinement::AccelerationRefinement(const Kinematics& kinematics, const Closure& closure,
                                               const ArticulatedInertias& tree)
    : kinematics_(&kinematics), closure_(&closure), tau_(VecX::Zero(kinematics.topology().n_u)) {
  const Topology& topology = kinematics.topology();
  for (const LinkIndex l : upward<LinkIndex>(topology.links.size())) {
    const int m = topology.modes[topology.links[l].body].n_u;
    links_.push_back({Mat6X::Zero(6, 1), MatX::Zero(m, 1), MatX::Zero(tree.n_unknowns(l), 1)});
  }
}

void AccelerationRefinement::set_coordinate_forces(const AppliedForces& applied, const VecX& lambda) {
  tau_ = applied.tau();
  for (const SpeedConstraint& constraint : closure_->speed_constraints()) {
    for (const ConstrainedJoint& part : constraint.joints) {
      if (part.cut()) continue;
      const Span& span = kinematics_->topology().joints[part.joint];
      tau_.segment(span.first_u, span.n_u).noalias() -=
          part.C.lazyProduct(lambda.segment(constraint.first_row, constraint.n_rows));
    }
  }
}

/// tau - H^T rho of the free joint speeds, and -(rho_a - G_a^T [F; T]) of the modes.
void AccelerationRefinement::set_residual(const ArticulatedInertias& tree, const Reactions& reactions, LinkIndex l) {
  const ArticulatedBody& link = tree.link(l);
  const Mat6& H = tree.free_columns(l);
  auto residual = links_[l].response.col(0);
  for (int k = 0; k < link.n_free; ++k) residual(k) = tau_(link.free[k]) - H.col(k).dot(reactions.rho(l));
  residual.tail(links_[l].z_a.rows()) = -reactions.rho_a(l);
}

void AccelerationRefinement::refine(const ArticulatedInertias& tree, const Reactions& reactions,
                                    const AppliedForces& applied, const VecX& lambda,
                                    TreeAccelerations& accelerations) {  // (R77)
  set_coordinate_forces(applied, lambda);
  for (OfLink& link : links_) {
    link.z_r.setZero();
    link.z_a.setZero();
  }
  const Topology& topology = kinematics_->topology();
  for (const LinkIndex l : downward<LinkIndex>(links_.size())) {
    OfLink& link = links_[l];
    if (link.response.rows() > 0) {
      set_residual(tree, reactions, l);
      tree.propagate_force(l, link.z_r, link.z_a, link.response);
      accelerations.add_force(l, link.response.col(0));
    }
    const std::optional<LinkIndex> inward = topology.inward_link(l);
    if (inward) tree.add_passed_force(l, link.z_r, links_[*inward].z_r, links_[*inward].z_a);
  }
  accelerations.solve_again(tree);
}

}  // namespace concord::relative
