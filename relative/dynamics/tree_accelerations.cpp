#include "relative/dynamics/tree_accelerations.h"

#include "relative/dynamics/joint_factors.h"

namespace concord::relative {

TreeAccelerations::TreeAccelerations(const Kinematics& kinematics, const ArticulatedInertias& tree)
    : kinematics_(&kinematics),
      links_(tree.n_links() + 1),
      place_of_body_(kinematics.model().bodies.size(), tree.n_links()),
      flexible_of_link_(tree.n_links()),
      udot_(VecX::Zero(kinematics.topology().n_u)) {
  for (const LinkIndex l : upward<LinkIndex>(flexible_of_link_.size())) {
    const Link& link = kinematics.topology().links[l];
    place_of_reference_.push_back(place_of_body_[link.reference]);
    place_of_body_[link.body] = l;
    const FlexibleArticulatedBody* flexible = tree.flexible(l);
    if (flexible == nullptr) continue;
    flexible_of_link_[l] = static_cast<int>(flexible_.size());
    const Eigen::Index n = flexible->uhat.size();
    flexible_.push_back({VecX::Zero(n), VecX::Zero(n), VecX::Zero(flexible->bias_force_a.size())});
  }
}

const VecX* TreeAccelerations::of_modes(BodyIndex body) const {
  if (body == kGround) return nullptr;
  const std::optional<int> flexible = flexible_of_link_[place_of_body_[body]];
  return flexible ? &flexible_[*flexible].addot : nullptr;
}

Vec6 TreeAccelerations::of_point(JointIndex joint, Side side) const {
  const JointPoint& point = kinematics_->point(joint, side);
  const BodyIndex body(kinematics_->model().joints[joint].on(side).body);
  Vec6 Vdot = shift_motion(of_body(body), point.lever) + point.bias;
  if (const VecX* addot = of_modes(body)) Vdot.noalias() += point.Ga().lazyProduct(*addot);
  return Vdot;
}

void TreeAccelerations::load(const ArticulatedInertias& tree, LinkIndex l) {
  if (flexible_of_link_[l]) {
    flexible_[*flexible_of_link_[l]].uhat = tree.flexible(l)->uhat;
  } else {
    links_[l].uhat = tree.link(l).uhat;
  }
}

void TreeAccelerations::solve(const ArticulatedInertias& tree, const VecX& udot) {
  udot_ = udot;
  for (const LinkIndex l : upward<LinkIndex>(flexible_of_link_.size())) {
    load(tree, l);
    solve_link(tree, l);
  }
}

void TreeAccelerations::solve_again(const ArticulatedInertias& tree) {
  for (const LinkIndex l : upward<LinkIndex>(flexible_of_link_.size())) solve_link(tree, l);
}

void TreeAccelerations::add_force(LinkIndex link, const Eigen::Ref<const VecX>& response) {
  if (flexible_of_link_[link]) {
    flexible_[*flexible_of_link_[link]].uhat += response;
  } else {
    links_[link].uhat.head(response.size()) += response;
  }
}

Vec6 TreeAccelerations::acceleration_from_reference(LinkIndex l) const {
  const LinkBlocks& blocks = kinematics_->blocks(l);
  Vec6 A0 = shift_motion(links_[place_of_reference_[l]].Vdot, blocks.rho);
  if (blocks.Xa.cols() > 0)
    A0.noalias() += blocks.Xa.lazyProduct(flexible_[*flexible_of_link_[place_of_reference_[l]]].addot);
  return A0;
}

template <int N>
void TreeAccelerations::solve_rigid(const ArticulatedInertias& tree, LinkIndex l, const Vec6& A0) {  // (R37)
  const ArticulatedBody& link = tree.link(l);
  // Apart, so that a joint which does not pass an acceleration leaves nothing of it.
  Vec6 by_forces;
  Vec6 by_reference;
#pragma GCC unroll 6
  for (int i = 0; i < N; ++i) by_forces(i) = links_[l].uhat(i) / link.root(i);
#pragma GCC unroll 6
  for (int i = 0; i < N; ++i) by_reference(i) = link.W.col(i).dot(A0);
  substitute_backward<N>(link.L, by_forces);
  substitute_backward<N>(link.L, by_reference);
  const Mat6& H = tree.free_columns(l);
  links_[l].Vdot = (A0 - combination<N>(H, by_reference)) + (tree.given_acceleration(l) + combination<N>(H, by_forces));
#pragma GCC unroll 6
  for (int k = 0; k < N; ++k) udot_(link.free[k]) = by_forces(k) - by_reference(k);
}

void TreeAccelerations::solve_link(const ArticulatedInertias& tree, LinkIndex l) {
  const Vec6 A0 = acceleration_from_reference(l);
  const int n_free = tree.link(l).n_free;
  if (tree.link(l).only_turns) {
    solve_rigid<1>(tree, l, A0);
  } else if (flexible_of_link_[l]) {
    solve_flexible(tree, l, A0);
  } else if (n_free == 0) {
    links_[l].Vdot = A0 + tree.given_acceleration(l);
  } else {
    with_constant(n_free, [&](auto n) { solve_rigid<n()>(tree, l, A0); });
  }
}

void TreeAccelerations::solve_flexible(const ArticulatedInertias& tree, LinkIndex l, const Vec6& A0) {  // (R37)
  const ArticulatedBody& link = tree.link(l);
  const FlexibleArticulatedBody& factors = *tree.flexible(l);
  OfFlexible& f = flexible_[*flexible_of_link_[l]];
  f.udot = f.uhat;
  f.udot.noalias() -= factors.Kt.lazyProduct(A0);
  factors.llt.matrixU().solveInPlace(f.udot);
  Vec6& Vdot = links_[l].Vdot;
  Vdot = A0 + tree.given_acceleration(l);
  Vdot.noalias() += factors.H.lazyProduct(f.udot);
  f.addot = f.udot.tail(f.addot.size());
  for (int k = 0; k < link.n_free; ++k) udot_(link.free[k]) = f.udot(k);
  const Span& modes = kinematics_->topology().modes[kinematics_->topology().links[l].body];
  udot_.segment(modes.first_u, modes.n_u) = f.addot;
}

}  // namespace concord::relative
