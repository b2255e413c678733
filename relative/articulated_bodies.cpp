#include "relative/articulated_bodies.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "common/decompositions.h"

namespace concord::relative {

namespace {

/// Pivots below this part of the terms they are made of are round-off.
constexpr double kRoundOff = 1e-13;

template <int Rows, int Columns>
using Fixed = Eigen::Matrix<double, Rows, Columns>;

/// Cholesky factor of the symmetric D (lower triangle read) in place of D; false if D is not positive definite.
template <int N>
bool factorize(Fixed<N, N>& D) {
  for (int j = 0; j < N; ++j) {
    double pivot = D(j, j);
    for (int k = 0; k < j; ++k) pivot -= D(j, k) * D(j, k);
    if (!(pivot > kRoundOff * D(j, j))) return false;
    pivot = std::sqrt(pivot);
    D(j, j) = pivot;
    for (int i = j + 1; i < N; ++i) {
      double entry = D(i, j);
      for (int k = 0; k < j; ++k) entry -= D(i, k) * D(j, k);
      D(i, j) = entry / pivot;
    }
  }
  return true;
}

// Substitution by loops of fixed length: Eigen's triangular solvers unroll by templates, and took most of the time that
// this file needs to compile.

/// L^-1 x in place of x, L lower triangular.
template <int N, class Lower, class Vector>
void substitute_forward(const Lower& L, Vector& x) {
  for (int i = 0; i < N; ++i) {
    for (int k = 0; k < i; ++k) x(i) -= L(i, k) * x(k);
    x(i) /= L(i, i);
  }
}

/// L^-T x in place of x.
template <int N, class Lower, class Vector>
void substitute_backward(const Lower& L, Vector& x) {
  for (int i = N - 1; i >= 0; --i) {
    for (int k = i + 1; k < N; ++k) x(i) -= L(k, i) * x(k);
    x(i) /= L(i, i);
  }
}

/// U L^-T in place of U, column by column.
template <int N, class Lower, class Columns>
void divide_by_transpose(const Lower& L, Columns& U) {
  for (int i = 0; i < N; ++i) {
    for (int k = 0; k < i; ++k) U.col(i) -= L(i, k) * U.col(k);
    U.col(i) /= L(i, i);
  }
}

/// Whether no pivot of the factor of D is round-off.
bool has_pivots(const Eigen::LLT<MatX>& llt, const MatX& D) {
  return (llt.matrixLLT().diagonal().array().square() > kRoundOff * D.diagonal().array()).all();
}

}  // namespace

ArticulatedBodies::ArticulatedBodies(const Kinematics& kinematics, const PrescribedMask& driven)
    : kinematics_(&kinematics),
      links_(kinematics.topology().links.size()),
      flexible_of_link_(kinematics.topology().links.size()) {
  const Topology& topology = kinematics.topology();
  for (std::size_t l = 0; l < links_.size(); ++l) {
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
    const int m = topology.modes[topology.links[l].body].n_u;
    if (m == 0) continue;
    flexible_of_link_[l] = static_cast<int>(flexible_.size());
    const int n = link.n_free + m;
    flexible_.push_back({Mat6X::Zero(6, m), MatX::Zero(m, m), VecX::Zero(m), Mat6X::Zero(6, n), Mat6X::Zero(6, n),
                         MatX::Zero(m, n), MatX::Zero(n, n), Eigen::LLT<MatX>(MatX::Identity(n, n)), MatX::Zero(n, 6),
                         VecX::Zero(n), VecX::Zero(n), VecX::Zero(m)});
  }
}

const Vec6& ArticulatedBodies::acceleration(int body) const {
  return body == kGround ? ground_ : links_[*kinematics_->topology().link_of_body[body]].Vdot;
}

const VecX* ArticulatedBodies::modal_acceleration(int body) const {
  if (body == kGround) return nullptr;
  const std::optional<int> flexible = flexible_of_link_[*kinematics_->topology().link_of_body[body]];
  return flexible ? &flexible_[*flexible].addot : nullptr;
}

Vec6 ArticulatedBodies::acceleration_of_point(int joint, Side side) const {
  const JointPoint& point = kinematics_->point(joint, side);
  const int body = kinematics_->model().joints[joint].on(side).body;
  Vec6 Vdot = shift_motion(acceleration(body), point.lever) + point.bias;
  if (const VecX* addot = modal_acceleration(body)) Vdot.noalias() += point.Ga().lazyProduct(*addot);
  return Vdot;
}

int ArticulatedBodies::n_unknowns(int link) const {
  const std::optional<int> flexible = flexible_of_link_[link];
  return flexible ? static_cast<int>(flexible_[*flexible].uhat.size()) : links_[link].n_free;
}

void ArticulatedBodies::load_bodies(const std::vector<BodyInertia>& inertias) {
  for (std::size_t l = 0; l < links_.size(); ++l) {
    inertias[l].moments().fill(links_[l].articulated_inertia);
    links_[l].bias_force = inertias[l].p();
    if (flexible_of_link_[l]) load_flexible(static_cast<int>(l), inertias[l]);
  }
}

void ArticulatedBodies::subtract_applied(const AppliedForces& applied) {
  if (!applied.any()) return;
  for (int l = 0; l < static_cast<int>(links_.size()); ++l) {
    ArticulatedBody& link = links_[l];
    link.bias_force -= applied.on_body(l);
    for (int k = 0; k < link.n_free; ++k) link.tau(k) = applied.tau()(link.free[k]);
    if (flexible_of_link_[l]) flexible_[*flexible_of_link_[l]].bias_force_a -= applied.on_modes(l);
  }
}

void ArticulatedBodies::load_flexible(int l, const BodyInertia& inertia) {
  FlexibleArticulatedBody& flexible = flexible_[*flexible_of_link_[l]];
  flexible.inertia_ra = inertia.flexible()->M_ra();
  flexible.inertia_aa = inertia.flexible()->M_aa();
  flexible.bias_force_a = inertia.flexible()->p_a();
}

void ArticulatedBodies::gather_columns(int l, const VecX& udot) {  // (R33)
  ArticulatedBody& link = links_[l];
  const LinkBlocks& blocks = kinematics_->blocks(l);
  link.c = blocks.D;
  if (link.n_driven == 0) return;
  for (int k = 0; k < link.n_driven; ++k) link.c += blocks.H.col(link.driven_column[k]) * udot(link.driven[k]);
  for (int k = 0; k < link.n_free; ++k) link.H_free.col(k) = blocks.H.col(link.free_column[k]);
}

const double* ArticulatedBodies::free_columns(int l) const {
  return links_[l].n_driven == 0 ? kinematics_->blocks(l).H.data() : links_[l].H_free.data();
}

void ArticulatedBodies::backward_pass(const std::vector<BodyInertia>& inertias, const AppliedForces& applied,
                                      const VecX& udot) {
  load_bodies(inertias);
  subtract_applied(applied);
  for (int l = static_cast<int>(links_.size()) - 1; l >= 0; --l) {
    gather_columns(l, udot);
    if (flexible_of_link_[l]) {
      eliminate_flexible(l);
    } else {
      dispatch_rigid(l);
    }
  }
}

void ArticulatedBodies::dispatch_rigid(int l) {
  switch (links_[l].n_free) {
    case 0:
      return add_to_reference_body(l, links_[l].articulated_inertia,
                                   links_[l].bias_force + links_[l].articulated_inertia * links_[l].c);
    case 1:
      return eliminate_rigid<1>(l);
    case 2:
      return eliminate_rigid<2>(l);
    case 3:
      return eliminate_rigid<3>(l);
    case 4:
      return eliminate_rigid<4>(l);
    case 5:
      return eliminate_rigid<5>(l);
    default:
      return eliminate_rigid<6>(l);
  }
}

template <int N>
void ArticulatedBodies::eliminate_rigid(int l) {  // (R34), (R35)
  ArticulatedBody& link = links_[l];
  const Eigen::Map<const Fixed<6, N>> H(free_columns(l));
  Eigen::Map<Fixed<6, N>> K(link.K.data());
  Eigen::Map<Fixed<N, N>> stored_L(link.L.data());
  const Vec6 p = link.bias_force + link.articulated_inertia * link.c;
  const Fixed<6, N> U = link.articulated_inertia * H;
  Fixed<N, N> L = H.transpose() * U;
  if (!factorize<N>(L)) throw_indefinite(l);
  Fixed<N, 1> uhat = link.tau.template head<N>() - H.transpose() * p;
  substitute_forward<N>(L, uhat);
  K = U;
  divide_by_transpose<N>(L, K);
  stored_L = L;
  link.uhat.template head<N>() = uhat;
  if (kinematics_->topology().links[l].reference == kGround) return;
  add_to_reference_body(l, link.articulated_inertia - K * K.transpose(), p + K * uhat);
}

void ArticulatedBodies::eliminate_flexible(int l) {  // (R34), (R35)
  ArticulatedBody& link = links_[l];
  FlexibleArticulatedBody& f = flexible_[*flexible_of_link_[l]];
  const Eigen::Index m = f.bias_force_a.size();
  const Eigen::Index n_free = link.n_free;
  f.H.leftCols(n_free) = Eigen::Map<const Mat6X>(free_columns(l), 6, n_free);
  f.H.rightCols(m) = -kinematics_->blocks(l).Ha;
  f.U.noalias() = link.articulated_inertia * f.H;
  f.U.rightCols(m) += f.inertia_ra;
  f.U_a.noalias() = f.inertia_ra.transpose() * f.H;
  f.U_a.rightCols(m) += f.inertia_aa;
  f.D.noalias() = f.H.transpose() * f.U;
  f.D.bottomRows(m) += f.U_a;
  const Vec6 p = link.bias_force + link.articulated_inertia * link.c;
  f.uhat.noalias() = f.H.transpose().lazyProduct(-p);
  f.uhat.head(n_free) += link.tau.head(n_free);
  f.uhat.tail(m) -= f.bias_force_a;
  f.uhat.tail(m).noalias() -= f.inertia_ra.transpose() * link.c;
  if (f.llt.compute(f.D).info() != Eigen::Success || !has_pivots(f.llt, f.D)) throw_indefinite(l);
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

/// Adds what is left of a link's inertia and bias force to its reference body: Sh^T I Sh, Sh^T p, and the same through
/// Xa for the modal speeds of the reference body (R36).
void ArticulatedBodies::add_to_reference_body(int l, const Mat6& I, const Vec6& p) {
  const Link& step = kinematics_->topology().links[l];
  if (step.reference == kGround) return;
  const int reference = *kinematics_->topology().link_of_body[step.reference];
  const LinkBlocks& blocks = kinematics_->blocks(l);
  const Vec3& rho = blocks.rho;
  ArticulatedBody& to = links_[reference];
  // I Sh: the right half is [B; C] - [A; B^T] rho~, where a row x^T times rho~ is (x cross rho)^T.
  const Mat3 A = I.topLeftCorner<3, 3>();
  Mat3 B = I.topRightCorner<3, 3>();
  Mat3 C = I.bottomRightCorner<3, 3>();
  const auto times_rho_tilde = [&rho](const Mat3& X) {
    Mat3 result;
    result.col(0) = X.col(1) * rho.z() - X.col(2) * rho.y();
    result.col(1) = X.col(2) * rho.x() - X.col(0) * rho.z();
    result.col(2) = X.col(0) * rho.y() - X.col(1) * rho.x();
    return result;
  };
  C -= times_rho_tilde(B.transpose());
  B -= times_rho_tilde(A);
  // rho~ B = -(B^T rho~)^T.
  C -= times_rho_tilde(B.transpose()).transpose();
  to.articulated_inertia.topLeftCorner<3, 3>() += A;
  to.articulated_inertia.topRightCorner<3, 3>() += B;
  to.articulated_inertia.bottomLeftCorner<3, 3>() += B.transpose();
  to.articulated_inertia.bottomRightCorner<3, 3>() += C;
  to.bias_force += shift_wrench(p, rho);
  if (!flexible_of_link_[reference]) return;
  FlexibleArticulatedBody& f = flexible_[*flexible_of_link_[reference]];
  for (Eigen::Index k = 0; k < blocks.Xa.cols(); ++k) {
    const Vec6 IX = I * blocks.Xa.col(k);
    f.inertia_ra.col(k) += shift_wrench(IX, rho);
    f.inertia_aa.col(k).noalias() += blocks.Xa.transpose().lazyProduct(IX);
  }
  f.bias_force_a.noalias() += blocks.Xa.transpose().lazyProduct(p);
}

Vec6 ArticulatedBodies::acceleration_from_reference(int l) const {
  const int reference = kinematics_->topology().links[l].reference;
  if (reference == kGround) return Vec6::Zero();
  const LinkBlocks& blocks = kinematics_->blocks(l);
  Vec6 A0 = shift_motion(acceleration(reference), blocks.rho);
  if (const VecX* addot = modal_acceleration(reference)) A0.noalias() += blocks.Xa.lazyProduct(*addot);
  return A0;
}

void ArticulatedBodies::forward_pass(VecX& udot) {
  for (int l = 0; l < static_cast<int>(links_.size()); ++l) {
    const Vec6 A0 = acceleration_from_reference(l);
    if (flexible_of_link_[l]) {
      solve_flexible(l, A0, udot);
      continue;
    }
    switch (links_[l].n_free) {
      case 0:
        links_[l].Vdot = A0 + links_[l].c;
        break;
      case 1:
        solve_rigid<1>(l, A0, udot);
        break;
      case 2:
        solve_rigid<2>(l, A0, udot);
        break;
      case 3:
        solve_rigid<3>(l, A0, udot);
        break;
      case 4:
        solve_rigid<4>(l, A0, udot);
        break;
      case 5:
        solve_rigid<5>(l, A0, udot);
        break;
      default:
        solve_rigid<6>(l, A0, udot);
    }
  }
}

template <int N>
void ArticulatedBodies::solve_rigid(int l, const Vec6& A0, VecX& udot) {  // (R37)
  ArticulatedBody& link = links_[l];
  const Eigen::Map<const Fixed<6, N>> H(free_columns(l));
  const Eigen::Map<const Fixed<6, N>> K(link.K.data());
  const Eigen::Map<const Fixed<N, N>> L(link.L.data());
  Fixed<N, 1> solution = link.uhat.template head<N>() - K.transpose() * A0;
  substitute_backward<N>(L, solution);
  link.Vdot = A0 + link.c + H * solution;
  for (int k = 0; k < N; ++k) udot(link.free[k]) = solution(k);
}

void ArticulatedBodies::solve_flexible(int l, const Vec6& A0, VecX& udot) {  // (R37)
  ArticulatedBody& link = links_[l];
  FlexibleArticulatedBody& f = flexible_[*flexible_of_link_[l]];
  f.udot = f.uhat;
  f.udot.noalias() -= f.Kt.lazyProduct(A0);
  f.llt.matrixU().solveInPlace(f.udot);
  link.Vdot = A0 + link.c;
  link.Vdot.noalias() += f.H.lazyProduct(f.udot);
  f.addot = f.udot.tail(f.addot.size());
  for (int k = 0; k < link.n_free; ++k) udot(link.free[k]) = f.udot(k);
  const Span& modes = kinematics_->topology().modes[kinematics_->topology().links[l].body];
  udot.segment(modes.first_u, modes.n_u) = f.addot;
}

void ArticulatedBodies::add_coordinate_forces(int link, const Eigen::Ref<const MatX>& forces,
                                              Eigen::Ref<MatX> on_unknowns) const {
  const ArticulatedBody& factors = links_[link];
  for (int k = 0; k < factors.n_free; ++k) on_unknowns.row(k) += forces.row(factors.free_column[k]);
}

void ArticulatedBodies::propagate_force(int link, Mat6X& z_r, const MatX& z_a, MatX& response) const {
  if (flexible_of_link_[link]) {
    const FlexibleArticulatedBody& f = flexible_[*flexible_of_link_[link]];
    response.noalias() += f.H.transpose() * z_r;
    response.bottomRows(z_a.rows()) += z_a;
    f.llt.matrixL().solveInPlace(response);
    z_r.noalias() -= f.Kt.transpose() * response;
    return;
  }
  switch (links_[link].n_free) {
    case 0:
      return;
    case 1:
      return propagate_force_rigid<1>(link, z_r, response);
    case 2:
      return propagate_force_rigid<2>(link, z_r, response);
    case 3:
      return propagate_force_rigid<3>(link, z_r, response);
    case 4:
      return propagate_force_rigid<4>(link, z_r, response);
    case 5:
      return propagate_force_rigid<5>(link, z_r, response);
    default:
      return propagate_force_rigid<6>(link, z_r, response);
  }
}

template <int N>
void ArticulatedBodies::propagate_force_rigid(int l, Mat6X& z_r, MatX& response) const {
  const ArticulatedBody& link = links_[l];
  const Eigen::Map<const Fixed<6, N>> H(free_columns(l));
  const Eigen::Map<const Fixed<6, N>> K(link.K.data());
  const Eigen::Map<const Fixed<N, N>> L(link.L.data());
  for (Eigen::Index c = 0; c < z_r.cols(); ++c) {
    Eigen::Map<Vec6> z(z_r.col(c).data());
    Eigen::Map<Fixed<N, 1>> along(response.col(c).data());
    along.noalias() += H.transpose() * z;
    substitute_forward<N>(L, along);
    z.noalias() -= K * along;
  }
}

void ArticulatedBodies::add_force(int link, const Eigen::Ref<const VecX>& response) {
  if (flexible_of_link_[link]) {
    flexible_[*flexible_of_link_[link]].uhat += response;
  } else {
    links_[link].uhat.head(response.size()) += response;
  }
}

/// The least eigenvalue of H^T I H, its columns scaled by the terms that their inertia is made of.
std::optional<MotionWithoutInertia> ArticulatedBodies::motion_without_inertia() const {
  constexpr double kLeast = 4.0 * kRoundOff;  // a pivot at round-off must be found here
  for (int l = static_cast<int>(links_.size()) - 1; l >= 0; --l) {
    const ArticulatedBody& link = links_[l];
    if (link.n_free == 0) continue;
    const Eigen::Map<const Mat6X> H(free_columns(l), 6, link.n_free);
    const MatX terms = H.cwiseAbs().transpose() * link.articulated_inertia.cwiseAbs() * H.cwiseAbs();
    const VecX units = terms.diagonal().unaryExpr([](double size) { return size > 0.0 ? 1.0 / std::sqrt(size) : 1.0; });
    const MatX scaled = units.asDiagonal() * H.transpose() * link.articulated_inertia * H * units.asDiagonal();
    const SymmetricEigenpairs spectrum = symmetric_eigenpairs(scaled);
    if (spectrum.values(0) > kLeast) continue;
    MotionWithoutInertia found{l, JointVector::Zero(link.n_free + link.n_driven)};
    for (int k = 0; k < link.n_free; ++k) found.u(link.free_column[k]) = units(k) * spectrum.vectors(k, 0);
    return found;
  }
  return std::nullopt;
}

void ArticulatedBodies::throw_indefinite(int l) const {
  const Link& link = kinematics_->topology().links[l];
  throw SolverError(
      fmt::format("relative: body '{}' and all that it carries have no inertia against the motion of joint '{}'",
                  kinematics_->model().bodies[link.body].name, kinematics_->model().joints[link.joint].name));
}

}  // namespace concord::relative
