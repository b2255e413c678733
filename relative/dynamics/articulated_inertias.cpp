#include "relative/dynamics/articulated_inertias.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/products.h"
#include "relative/dynamics/joint_factors.h"

namespace concord::relative {

namespace {

/// The least pivot of the factor of D, in parts of the terms that it is made of.
double least_pivot_of(const Eigen::LLT<MatX>& llt, const MatX& D) {
  return (llt.matrixLLT().diagonal().array().square() / D.diagonal().array()).minCoeff();
}

}  // namespace

ArticulatedInertias::ArticulatedInertias(const Kinematics& kinematics, const PrescribedMask& driven)
    : kinematics_(&kinematics),
      links_(kinematics.topology().links.size()),
      flexible_of_link_(kinematics.topology().links.size()) {
  const Topology& topology = kinematics.topology();
  for (const LinkIndex l : upward<LinkIndex>(links_.size())) {
    ArticulatedBody& link = links_[l];
    const Span& span = topology.joints[topology.links[l].joint];
    for (int c = 0; c < span.n_u; ++c) {
      if (driven[span.first_u + c] != 0) {
        link.driven_column[link.n_driven] = c;
        link.driven[link.n_driven++] = span.first_u + c;
      } else {
        link.free_column[link.n_free] = c;
        link.free[link.n_free++] = span.first_u + c;
      }
    }
    reference_of_link_.push_back(topology.inward_link(l));
    const int m = topology.modes[topology.links[l].body].n_u;
    const Link& way = topology.links[l];
    link.only_turns = link.n_free == 1 && kinematics.mobilizer(way.joint).only_turn() >= 0 &&
                      kinematics.point(way.joint, way.own_side()).is_reference_point();
    if (m == 0) continue;
    flexible_of_link_[l] = static_cast<int>(flexible_.size());
    const int n = link.n_free + m;
    flexible_.push_back({Mat6X::Zero(6, m), MatX::Zero(m, m), VecX::Zero(m), Mat6X::Zero(6, n), Mat6X::Zero(6, n),
                         MatX::Zero(m, n), MatX::Zero(n, n), Eigen::LLT<MatX>(MatX(MatX::Identity(n, n))),
                         MatX::Zero(n, 6), VecX::Zero(n)});
  }
}

int ArticulatedInertias::n_unknowns(LinkIndex link) const {
  const std::optional<int> flexible = flexible_of_link_[link];
  return flexible ? static_cast<int>(flexible_[*flexible].uhat.size()) : links_[link].n_free;
}

void ArticulatedInertias::load_bodies(const std::vector<BodyInertia>& inertias) {
  for (const LinkIndex l : upward<LinkIndex>(links_.size())) {
    inertias[l].moments().fill(links_[l].articulated_inertia);
    links_[l].bias_force = inertias[l].p();
    if (flexible_of_link_[l]) load_flexible(l, inertias[l]);
  }
}

void ArticulatedInertias::subtract_applied(const AppliedForces& applied) {
  if (!applied.any()) return;
  for (const LinkIndex l : upward<LinkIndex>(links_.size())) {
    ArticulatedBody& link = links_[l];
    link.bias_force -= applied.on_body(l);
    for (int k = 0; k < link.n_free; ++k) link.tau(k) = applied.tau()(link.free[k]);
    if (flexible_of_link_[l]) flexible_[*flexible_of_link_[l]].bias_force_a -= applied.on_modes(l);
  }
}

void ArticulatedInertias::load_flexible(LinkIndex l, const BodyInertia& inertia) {
  FlexibleArticulatedBody& flexible = flexible_[*flexible_of_link_[l]];
  flexible.inertia_ra = inertia.flexible()->M_ra();
  flexible.inertia_aa = inertia.flexible()->M_aa();
  flexible.bias_force_a = inertia.flexible()->p_a();
}

void ArticulatedInertias::gather_columns(LinkIndex l, const VecX& udot) {  // (R33)
  ArticulatedBody& link = links_[l];
  const LinkBlocks& blocks = kinematics_->blocks(l);
  link.c = blocks.D;
  for (int k = 0; k < link.n_driven; ++k) link.c += blocks.H.col(link.driven_column[k]) * udot(link.driven[k]);
  for (int k = 0; k < link.n_free; ++k) link.H_free.col(k) = blocks.H.col(link.free_column[k]);
}

/// Adds what is left of a link's inertia (its upper triangle) and bias force to its reference body: Sh^T I Sh, Sh^T p
/// (R36).
void ArticulatedInertias::add_to_reference_body(LinkIndex l, const Mat6& I, const Vec6& p) {
  const std::optional<LinkIndex> reference = reference_of_link_[l];
  if (!reference) return;
  const Vec3& rho = kinematics_->blocks(l).rho;
  ArticulatedBody& to = links_[*reference];
  add_shifted(I, rho, to.articulated_inertia);
  to.bias_force += shift_wrench(p, rho);
  if (flexible_of_link_[*reference]) add_to_reference_modes(l, *reference, I, p);
}

void ArticulatedInertias::compute(const std::vector<BodyInertia>& inertias, const AppliedForces& applied,
                                  const VecX& udot) {
  least_pivot_ = 1.0;
  load_bodies(inertias);
  subtract_applied(applied);
  for (const LinkIndex l : downward<LinkIndex>(links_.size())) {
    if (links_[l].n_driven > 0) gather_columns(l, udot);
    if (flexible_of_link_[l]) {
      eliminate_flexible(l);
    } else if (links_[l].n_free == 0) {
      const ArticulatedBody& link = links_[l];
      add_to_reference_body(l, link.articulated_inertia,
                            link.bias_force + link.articulated_inertia * given_acceleration(l));
    } else if (links_[l].only_turns) {
      eliminate_rigid<1, true>(l);
    } else {
      with_constant(links_[l].n_free, [&](auto n) { eliminate_rigid<n(), false>(l); });
    }
  }
}

template <int N, bool kOnlyTurns>
void ArticulatedInertias::eliminate_rigid(LinkIndex l) {  // (R34), (R35)
  ArticulatedBody& link = links_[l];
  const Mat6& H = free_columns(l);
  Vec6 p = link.bias_force;
  Mat6 V;
  Vec6 w;
  multiply_both<kOnlyTurns>(link.articulated_inertia, given_acceleration(l), H.data(), p, V.data());
#pragma GCC unroll 6
  for (int j = 1; j < N; ++j) V.col(j) = times(link.articulated_inertia, H.col(j));
#pragma GCC unroll 6
  for (int j = 0; j < N; ++j) {
#pragma GCC unroll 6
    for (int i = j; i < N; ++i) link.L(i, j) = scalar_product<kOnlyTurns>(H.col(i).data(), V.col(j));
  }
  if (!factorize<N>(link.L)) throw_indefinite(l);
#pragma GCC unroll 6
  for (int i = 0; i < N; ++i) w(i) = link.tau(i) - scalar_product<kOnlyTurns>(H.col(i).data(), p);
  substitute_forward<N>(link.L, w);
  divide_by_transpose<N>(link.L, V);
#pragma GCC unroll 6
  for (int j = 0; j < N; ++j) {
    link.W.col(j) = V.col(j) / link.L(j, j);
    link.root(j) = std::sqrt(link.L(j, j));
    link.uhat(j) = w(j) / link.root(j);
  }
  if (reference_of_link_[l]) pass_on<N>(l, V, p + combination<N>(link.W, w));
}

/// What the joint leaves of the inertia, and the bias force p, to the reference body (R36).
template <int N>
void ArticulatedInertias::pass_on(LinkIndex l, const Mat6& V, const Vec6& p) {
  const ArticulatedBody& link = links_[l];
  Mat6 left;
  take_off_products<N>(link.articulated_inertia, V, link.W, left);
  add_to_reference_body(l, left, p);
}

void ArticulatedInertias::eliminate_flexible(LinkIndex l) {  // (R34), (R35)
  ArticulatedBody& link = links_[l];
  FlexibleArticulatedBody& f = flexible_[*flexible_of_link_[l]];
  const Eigen::Index m = f.bias_force_a.size();
  const Eigen::Index n_free = link.n_free;
  f.H.leftCols(n_free) = free_columns(l).leftCols(n_free);
  f.H.rightCols(m) = -kinematics_->blocks(l).Ha;
  f.U.noalias() = link.articulated_inertia * f.H;
  f.U.rightCols(m) += f.inertia_ra;
  f.U_a.noalias() = f.inertia_ra.transpose() * f.H;
  f.U_a.rightCols(m) += f.inertia_aa;
  f.D.noalias() = f.H.transpose() * f.U;
  f.D.bottomRows(m) += f.U_a;
  const Vec6& c = given_acceleration(l);
  const Vec6 p = link.bias_force + link.articulated_inertia * c;
  f.uhat.noalias() = f.H.transpose().lazyProduct(-p);
  f.uhat.head(n_free) += link.tau.head(n_free);
  f.uhat.tail(m) -= f.bias_force_a;
  f.uhat.tail(m).noalias() -= f.inertia_ra.transpose() * c;
  if (f.llt.compute(f.D).info() != Eigen::Success) throw_indefinite(l);
  const double pivot = least_pivot_of(f.llt, f.D);
  if (!(pivot > kRoundOffOfPivot)) throw_indefinite(l);
  least_pivot_ = std::min(least_pivot_, pivot);
  f.llt.matrixL().solveInPlace(f.uhat);
  f.Kt = f.U.transpose();
  f.llt.matrixL().solveInPlace(f.Kt);
  Mat6 I = link.articulated_inertia;
  I.noalias() -= f.Kt.transpose().lazyProduct(f.Kt);
  Vec6 p_left = p;
  // What the modal rows still push: their bias force is part of uhat, of which K^T takes the share of the body.
  p_left.noalias() += f.Kt.transpose().lazyProduct(f.uhat);
  add_to_reference_body(l, I, p_left);
}

/// The same through Xa for the modal speeds of the reference body (R36).
void ArticulatedInertias::add_to_reference_modes(LinkIndex l, LinkIndex reference, const Mat6& I, const Vec6& p) {
  FlexibleArticulatedBody& f = flexible_[*flexible_of_link_[reference]];
  const LinkBlocks& blocks = kinematics_->blocks(l);
  const Mat6 I_full = I.selfadjointView<Eigen::Upper>();
  for (Eigen::Index k = 0; k < blocks.Xa.cols(); ++k) {
    const Vec6 IX = times(I_full, blocks.Xa.col(k));
    f.inertia_ra.col(k) += shift_wrench(IX, blocks.rho);
    f.inertia_aa.col(k).noalias() += blocks.Xa.transpose().lazyProduct(IX);
  }
  f.bias_force_a.noalias() += blocks.Xa.transpose().lazyProduct(p);
}

void ArticulatedInertias::add_coordinate_forces(LinkIndex link, const Eigen::Ref<const MatX>& forces,
                                                Eigen::Ref<MatX> on_unknowns) const {
  const ArticulatedBody& factors = links_[link];
  for (int k = 0; k < factors.n_free; ++k) on_unknowns.row(k) += forces.row(factors.free_column[k]);
}

void ArticulatedInertias::propagate_force(LinkIndex link, Mat6X& z_r, const MatX& z_a, MatX& response) const {
  if (flexible_of_link_[link]) {
    const FlexibleArticulatedBody& f = flexible_[*flexible_of_link_[link]];
    response.noalias() += f.H.transpose() * z_r;
    response.bottomRows(z_a.rows()) += z_a;
    f.llt.matrixL().solveInPlace(response);
    z_r.noalias() -= f.Kt.transpose() * response;
    return;
  }
  if (links_[link].n_free == 0) return;
  with_constant(links_[link].n_free, [&](auto n) { propagate_force_rigid<n()>(link, z_r, response); });
}

template <int N>
void ArticulatedInertias::propagate_force_rigid(LinkIndex l, Mat6X& z_r, MatX& response) const {
  const ArticulatedBody& link = links_[l];
  const Mat6& H = free_columns(l);
  for (Eigen::Index c = 0; c < z_r.cols(); ++c) {
    Vec6 z = z_r.col(c);
    auto along = response.col(c);
    for (int i = 0; i < N; ++i) along(i) += H.col(i).dot(z);
    substitute_forward<N>(link.L, along);
    z_r.col(c) = z - combination<N>(link.W, along);
    for (int i = 0; i < N; ++i) along(i) /= link.root(i);
  }
}

void ArticulatedInertias::add_passed_force(LinkIndex link, const Mat6X& z_r, Mat6X& zj_r, MatX& zj_a) const {
  const LinkBlocks& blocks = kinematics_->blocks(link);
  for (Eigen::Index c = 0; c < z_r.cols(); ++c) zj_r.col(c) += shift_wrench(z_r.col(c), blocks.rho);
  zj_a.noalias() += blocks.Xa.transpose().lazyProduct(z_r);
}

void ArticulatedInertias::throw_indefinite(LinkIndex l) const {
  const Link& link = kinematics_->topology().links[l];
  throw SolverError(
      fmt::format("relative: body '{}' and all that it carries have no inertia against the motion of joint '{}'",
                  kinematics_->model().bodies[link.body].name, kinematics_->model().joints[link.joint].name));
}

/// The least eigenvalue of H^T I H, its columns scaled by the terms that their inertia is made of.
std::optional<MotionWithoutInertia> find_motion_without_inertia(const ArticulatedInertias& tree) {
  constexpr double kLeast = 4.0 * kRoundOffOfPivot;  // a pivot at round-off must be found here
  for (const LinkIndex l : downward<LinkIndex>(tree.n_links())) {
    const ArticulatedBody& link = tree.link(l);
    if (link.n_free == 0) continue;
    const Eigen::Map<const Mat6X> H(tree.free_columns(l).data(), 6, link.n_free);
    const VecX terms = diagonal_of_congruence(H.cwiseAbs(), link.articulated_inertia.cwiseAbs());
    const VecX units = terms.unaryExpr([](double size) { return size > 0.0 ? 1.0 / std::sqrt(size) : 1.0; });
    const MatX scaled = units.asDiagonal() * congruence(H, link.articulated_inertia) * units.asDiagonal();
    const SymmetricEigenpairs spectrum = symmetric_eigenpairs(scaled);
    if (spectrum.values(0) > kLeast) continue;
    MotionWithoutInertia found{l, JointVector::Zero(link.n_free + link.n_driven)};
    for (int k = 0; k < link.n_free; ++k) found.u(link.free_column[k]) = units(k) * spectrum.vectors(k, 0);
    return found;
  }
  return std::nullopt;
}

}  // namespace concord::relative
