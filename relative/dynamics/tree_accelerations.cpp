#include "relative/dynamics/tree_accelerations.h"

#include "relative/dynamics/joint_factors.h"

namespace concord::relative {

TreeAccelerations::TreeAccelerations(const Kinematics& kinematics, const ArticulatedInertias& tree)
    : kinematics_(&kinematics),
      links_(tree.n_links()),
      flexible_of_link_(tree.n_links()),
      udot_(VecX::Zero(kinematics.topology().n_u)) {
  for (const LinkIndex l : upward<LinkIndex>(links_.size())) {
    const FlexibleArticulatedBody* flexible = tree.flexible(l);
    if (flexible == nullptr) continue;
    flexible_of_link_[l] = static_cast<int>(flexible_.size());
    const Eigen::Index n = flexible->uhat.size();
    flexible_.push_back({VecX::Zero(n), VecX::Zero(n), VecX::Zero(flexible->bias_force_a.size())});
  }
}

const Vec6& TreeAccelerations::of_body(BodyIndex body) const {
  return body == kGround ? ground_ : links_[*kinematics_->topology().link_of_body[body]].Vdot;
}

const VecX* TreeAccelerations::of_modes(BodyIndex body) const {
  if (body == kGround) return nullptr;
  const std::optional<int> flexible = flexible_of_link_[*kinematics_->topology().link_of_body[body]];
  return flexible ? &flexible_[*flexible].addot : nullptr;
}

Vec6 TreeAccelerations::of_point(JointIndex joint, Side side) const {
  const JointPoint& point = kinematics_->point(joint, side);
  const BodyIndex body(kinematics_->model().joints[joint].on(side).body);
  Vec6 Vdot = shift_motion(of_body(body), point.lever) + point.bias;
  if (const VecX* addot = of_modes(body)) Vdot.noalias() += point.Ga().lazyProduct(*addot);
  return Vdot;
}

void TreeAccelerations::solve(const ArticulatedInertias& tree, const VecX& udot) {
  udot_ = udot;
  for (const LinkIndex l : upward<LinkIndex>(links_.size())) {
    load(tree, l);
    solve_link(tree, l);
  }
}

void TreeAccelerations::solve_again(const ArticulatedInertias& tree) {
  for (const LinkIndex l : upward<LinkIndex>(links_.size())) solve_link(tree, l);
}

void TreeAccelerations::load(const ArticulatedInertias& tree, LinkIndex l) {
  if (flexible_of_link_[l]) {
    flexible_[*flexible_of_link_[l]].uhat = tree.flexible(l)->uhat;
  } else {
    links_[l].uhat = tree.link(l).uhat;
  }
}

void TreeAccelerations::add_force(LinkIndex link, const Eigen::Ref<const VecX>& response) {
  if (flexible_of_link_[link]) {
    flexible_[*flexible_of_link_[link]].uhat += response;
  } else {
    links_[link].uhat.head(response.size()) += response;
  }
}

void TreeAccelerations::solve_link(const ArticulatedInertias& tree, LinkIndex l) {
  const Vec6 A0 = acceleration_from_reference(l);
  const int n_free = tree.link(l).n_free;
  if (flexible_of_link_[l]) {
    solve_flexible(tree, l, A0);
  } else if (n_free == 0) {
    links_[l].Vdot = A0 + tree.link(l).c;
  } else {
    with_constant(n_free, [&](auto n) { solve_rigid<n()>(tree, l, A0); });
  }
}

Vec6 TreeAccelerations::acceleration_from_reference(LinkIndex l) const {
  const BodyIndex reference = kinematics_->topology().links[l].reference;
  if (reference == kGround) return Vec6::Zero();
  const LinkBlocks& blocks = kinematics_->blocks(l);
  Vec6 A0 = shift_motion(of_body(reference), blocks.rho);
  if (const VecX* addot = of_modes(reference)) A0.noalias() += blocks.Xa.lazyProduct(*addot);
  return A0;
}

template <int N>
void TreeAccelerations::solve_rigid(const ArticulatedInertias& tree, LinkIndex l, const Vec6& A0) {  // (R37)
  const ArticulatedBody& link = tree.link(l);
  // Apart, so that a joint which does not pass an acceleration leaves nothing of it.
  Vec6 by_forces;
  Vec6 by_reference;
  for (int i = 0; i < N; ++i) by_forces(i) = links_[l].uhat(i) / link.root(i);
  for (int i = 0; i < N; ++i) by_reference(i) = link.W.col(i).dot(A0);
  substitute_backward<N>(link.L, by_forces);
  substitute_backward<N>(link.L, by_reference);
  const Mat6& H = tree.free_columns(l);
  links_[l].Vdot = (A0 - combination<N>(H, by_reference)) + (link.c + combination<N>(H, by_forces));
  for (int k = 0; k < N; ++k) udot_(link.free[k]) = by_forces(k) - by_reference(k);
}

void TreeAccelerations::solve_flexible(const ArticulatedInertias& tree, LinkIndex l, const Vec6& A0) {  // (R37)
  const ArticulatedBody& link = tree.link(l);
  const FlexibleArticulatedBody& factors = *tree.flexible(l);
  OfFlexible& f = flexible_[*flexible_of_link_[l]];
  f.udot = f.uhat;
  f.udot.noalias() -= factors.Kt.lazyProduct(A0);
  factors.llt.matrixU().solveInPlace(f.udot);
  Vec6& Vdot = links_[l].Vdot;
  Vdot = A0 + link.c;
  Vdot.noalias() += factors.H.lazyProduct(f.udot);
  f.addot = f.udot.tail(f.addot.size());
  for (int k = 0; k < link.n_free; ++k) udot_(link.free[k]) = f.udot(k);
  const Span& modes = kinematics_->topology().modes[kinematics_->topology().links[l].body];
  udot_.segment(modes.first_u, modes.n_u) = f.addot;
}

}  // namespace concord::relative
