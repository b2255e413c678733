#include "relative/bodies/mobilizer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "common/rotation.h"
#include "relative/bodies/exponential_map.h"
#include "relative/bodies/six_columns.h"
#include "relative/bodies/spatial_basis.h"
#include "relative/bodies/turns.h"

namespace concord::relative {

namespace {

/// The motion of the words read so far, extended by each word from the parent's frame on; q and u advance with it (R9).
struct Composition {
  const double* q;
  const double* u;
  JointMotion& motion;
  const double* turns;
  int column = 0;
  Vec3 omega = Vec3::Zero();  // of the frame reached so far

  void operator()(const joints::Slide& slide) {
    const int axis = index(slide.axis);
    motion.d(axis) += *q;
    motion.S.col(column) = Vec6::Unit(axis);
    motion.v_rel(axis) += *u;
    step(1, 1);
  }

  void operator()(const joints::Turn& turn) {
    const int axis = index(turn.axis);
    const Vec3 z = motion.R.col(axis);
    motion.S.col(column) << 0.0, 0.0, 0.0, z;
    motion.Sdot_u.tail<3>() += omega.cross(z) * *u;
    omega += z * *u;
    motion.v_rel.tail<3>() = omega;
    turn_frame(axis, *q);
    step(1, 1);
  }

  /// The turns so far swing the arm: ddot gets omega x e, its rate (domega/dt at udot = 0) x e + omega x (omega x e).
  void operator()(const joints::Arm& arm) {
    const Vec3 e = arm.length * motion.R.col(index(arm.axis));
    motion.d += e;
    for (int c = 0; c < column; ++c) motion.S.col(c).head<3>() += motion.S.col(c).tail<3>().cross(e);
    const Vec3 swing = omega.cross(e);
    motion.v_rel.head<3>() += swing;
    motion.Sdot_u.head<3>() += motion.Sdot_u.tail<3>().cross(e) + omega.cross(swing);
  }

  /// The child's orientation is the ball's alone: turns before it keep what their arms displace.
  void operator()(const joints::Ball& /*ball*/) {
    motion.R = rotation_from_euler_parameters(Vec4(q[0], q[1], q[2], q[3]));
    motion.S.block(3, 0, 3, column).setZero();
    motion.Sdot_u.tail<3>().setZero();
    for (int axis = 0; axis < 3; ++axis) motion.S.col(column + axis) = Vec6::Unit(3 + axis);
    omega = Vec3(u[0], u[1], u[2]);
    motion.v_rel.tail<3>() = omega;
    step(4, 3);
  }

  void operator()(const joints::ByMotion& by) {
    joints::FunctionOfCoordinates::Motion found;
    const int n = by.motion->n();
    std::array<double, 6> rounded{};
    JointVector rest(n);
    for (int c = 0; c < n; ++c) rounded[c] = add_turns(q[c], turns[c], rest(c));
    by.motion->evaluate(rounded.data(), u, found);
    const Vec6 beyond = found.S.leftCols(n).lazyProduct(rest);
    motion.d = found.placement.d + beyond.head<3>();
    motion.R = found.placement.R + skew(beyond.tail<3>()) * found.placement.R;
    motion.S.leftCols(n) = found.S.leftCols(n);
    motion.v_rel.noalias() = found.S.leftCols(n).lazyProduct(Eigen::Map<const VecX>(u, n));
    motion.Sdot_u = found.Sdot_u;
    step(n, n);
  }

 private:
  void step(int n_q, int n_u) {
    q += n_q;
    u += n_u;
    column += n_u;
  }

  /// R <- R rotation(axis, angle): mixes the two other columns.
  void turn_frame(int axis, double angle) const {
    double s = 0.0;
    double c = 0.0;
    ::sincos(angle, &s, &c);
    const int second = (axis + 1) % 3;
    const int third = (axis + 2) % 3;
    const Vec3 b = motion.R.col(second);
    const Vec3 n = motion.R.col(third);
    motion.R.col(second) = c * b + s * n;
    motion.R.col(third) = c * n - s * b;
  }
};

/// pdot of one ball: E^T omega / 2, E = [-e, e0 1 + e~].
Vec4 euler_parameter_rate(const Vec4& p, const Vec3& omega) {
  const Vec3 e = p.tail<3>();
  Vec4 rate;
  rate << -0.5 * e.dot(omega), 0.5 * (p(0) * omega + omega.cross(e));
  return rate;
}

/// Applies one function to single coordinates and another to orientations, walking along q and along numbers of n_u.
template <class OnScalar, class OnOrientation>
void walk(const std::vector<joints::CoordinateKind>& kinds, OnScalar on_scalar, OnOrientation on_orientation) {
  int first_q = 0;
  int first_u = 0;
  for (const joints::CoordinateKind kind : kinds) {
    switch (kind) {
      case joints::CoordinateKind::angle:
      case joints::CoordinateKind::length:
        on_scalar(first_q, first_u);
        break;
      case joints::CoordinateKind::orientation:
        on_orientation(first_q, first_u);
        break;
    }
    first_q += joints::n_q(kind);
    first_u += joints::n_u(kind);
  }
}

}  // namespace

Mobilizer::Mobilizer(const joints::JointType& type, double length)
    : words_(type.permits), structure_(structure_of(type)), length_(length), n_q_(type.n_q()), n_u_(type.n_u()) {
  for (const joints::Permit& word : words_) {
    for (const joints::StatedCoordinate& one : stated_coordinates(word)) coordinates_.push_back(one.kind);
  }
  for (int c = 0; c < n_u_; ++c) couples_ = couples_ || (kind(c).displaces && kind(c).rotates);
  require_three_of_a_kind(type.name);
  const bool only_turns = n_u_ == 1 && kind(0).rotates && !kind(0).displaces;
  if (only_turns && !is_by_functions()) only_turn_ = kind(0).axis;
  if (!is_by_functions()) return;
  for (const joints::Read& read : type.reads) {
    if (const joints::WrenchesOfPlacement stated = stated_wrenches(read)) stated_wrenches_ = stated;
  }
}

/// Where no speed both displaces and rotates, a fourth of either kind depends on the others in every pose.
void Mobilizer::require_three_of_a_kind(const std::string& name) const {
  if (couples_) return;
  const auto displacing =
      std::count_if(structure_.kinds.begin(), structure_.kinds.begin() + n_u_, [](auto k) { return k.displaces; });
  if (displacing <= 3 && n_u_ - displacing <= 3) return;
  throw std::invalid_argument("joint type '" + name + "': " + std::to_string(displacing) +
                              " of its speeds displace and " + std::to_string(n_u_ - displacing) +
                              " rotate; more than three of either are one motion said twice");
}

void Mobilizer::count_turns(const double* turns) {
  if (is_by_functions()) std::copy_n(turns, n_q_, turns_.begin());
}

void Mobilizer::evaluate(const double* q, const double* u, JointMotion& motion) const {
  motion.d.setZero();
  motion.R.setIdentity();
  motion.v_rel.setZero();
  motion.Sdot_u.setZero();
  Composition composition{q, u, motion, turns_.data()};
  for (const joints::Permit& word : words_) std::visit(composition, word);
}

bool Mobilizer::columns_are_dependent(const JointMotion& motion) const {
  return couples_ ? depend_together(motion) : depend_separately(motion);
}

/// A column of S in units that compare: displacements in parts of the length, per unit of its own coordinate.
Vec6 Mobilizer::comparable(const JointMotion& motion, int column) const {
  Vec6 result = motion.S.col(column);
  result.head<3>() /= length_;
  if (kind(column).is_length) result *= length_;
  return result;
}

/// Each speed either displaces or rotates.
bool Mobilizer::depend_separately(const JointMotion& motion) const {
  std::array<Mat3, 2> parts{Mat3::Zero(), Mat3::Zero()};
  std::array<int, 2> n{};
  double largest = 0.0;
  for (int c = 0; c < n_u_; ++c) {
    const int part = kind(c).displaces ? 0 : 1;
    parts[part].col(n[part]) = comparable(motion, c).segment<3>(3 * part);
    largest = std::max(largest, parts[part].col(n[part]++).norm());
  }
  const double least = std::min(least_independent_part(parts[0], n[0]), least_independent_part(parts[1], n[1]));
  return !(least > kLeastOwnPart * largest);
}

bool Mobilizer::depend_together(const JointMotion& motion) const {
  OrthonormalColumns found;
  double largest = 0.0;
  std::array<Vec6, 6> columns;
  for (int c = 0; c < n_u_; ++c) {
    columns[c] = comparable(motion, c);
    largest = std::max(largest, columns[c].norm());
  }
  // The longest first, so that the last one tells how independent they are.
  while (found.size() < n_u_) {
    Vec6 longest = Vec6::Zero();
    for (int c = 0; c < n_u_; ++c) {
      const Vec6 rest = found.rest(columns[c]);
      if (rest.squaredNorm() > longest.squaredNorm()) longest = rest;
    }
    if (!(longest.norm() > kLeastOwnPart * largest)) return true;
    found.add(longest);
  }
  return false;
}

/// D with w_d = D (S^T D)^-1 tau.
JointColumns Mobilizer::wrench_columns(const JointMotion& motion) const {
  if (stated_wrenches_ != nullptr) return stated_wrenches_({motion.d, motion.R});
  JointColumns D = JointColumns::Zero(6, n_u_);
  for (int c = 0; c < n_u_; ++c) {
    const bool as_torque = is_by_functions() ? !kind(c).is_length : kind(c).rotates;
    const int row = as_torque ? 3 : 0;
    D.block<3, 1>(row, c) = motion.S.block<3, 1>(row, c);
  }
  return D;
}

Vec6 Mobilizer::coordinate_wrench(const JointMotion& motion, const JointVector& tau) const {
  const JointColumns D = wrench_columns(motion);
  const JointSquare powers = motion.S.leftCols(n_u_).transpose().lazyProduct(D);
  return D.lazyProduct(JointVector(powers.partialPivLu().solve(tau)));
}

/// Gives the elevation of a link to the wanted side of a quarter turn and all turns to those nearest to `near`.
void Mobilizer::rename(double* q, const double* near, bool on_far_side) const {
  constexpr double kPi = std::numbers::pi;
  if (structure_.elevation >= 0 && (std::cos(q[structure_.elevation]) < 0.0) != on_far_side) {
    q[structure_.elevation - 1] += kPi;
    q[structure_.elevation] = kPi - q[structure_.elevation];
  }
  for (int c = 0; c < structure_.n_scalars; ++c) {
    if (kind(c).is_length) continue;
    q[c] += 2.0 * kPi * std::round((near[c] - q[c]) / (2.0 * kPi));
  }
}

void Mobilizer::choose_chart(double* q, const double* near) const {
  if (is_by_functions()) return;
  rename(q, near, structure_.elevation >= 0 && std::cos(near[structure_.elevation]) < 0.0);
}

void Mobilizer::choose_canonical_chart(double* q) const {
  if (structure_.elevation < 0 ||
      (std::cos(q[structure_.elevation]) >= 0.0 && std::abs(q[structure_.elevation]) <= 0.5 * std::numbers::pi))
    return;
  std::array<double, 6> wanted{};
  std::copy_n(q, structure_.n_scalars, wanted.begin());
  wanted[structure_.elevation] = 0.0;
  rename(q, wanted.data(), false);
}

bool Mobilizer::is_on_branch_of(const double* q, const double* near) const {
  if (structure_.elevation >= 0)
    return (std::cos(q[structure_.elevation]) < 0.0) == (std::cos(near[structure_.elevation]) < 0.0);
  if (!is_by_functions()) return true;
  for (int c = 0; c < n_u_; ++c) {
    if (!kind(c).is_length && std::abs(q[c] - near[c]) > std::numbers::pi) return false;
  }
  return true;
}

void Mobilizer::compute_qdot(const double* q, const double* u, double* qdot) const {
  walk(
      coordinates_, [&](int iq, int iu) { qdot[iq] = u[iu]; },
      [&](int iq, int iu) {
        Eigen::Map<Vec4>(qdot + iq) =
            euler_parameter_rate(Eigen::Map<const Vec4>(q + iq), Eigen::Map<const Vec3>(u + iu));
      });
}

void Mobilizer::advance(double* q, const double* step) const {
  walk(
      coordinates_, [&](int iq, int iu) { q[iq] += step[iu]; },
      [&](int iq, int iu) {
        Eigen::Map<Vec4> p(q + iq);
        const Vec3 turn = Eigen::Map<const Vec3>(step + iu);
        const double angle = turn.norm();
        const double scale = angle > 1e-4 ? std::sin(0.5 * angle) / angle : 0.5 - angle * angle / 48.0;
        const Eigen::Quaterniond first(p(0), p(1), p(2), p(3));
        const Eigen::Quaterniond then(std::cos(0.5 * angle), scale * turn.x(), scale * turn.y(), scale * turn.z());
        const Eigen::Quaterniond reached = (then * first).normalized();
        p << reached.w(), reached.x(), reached.y(), reached.z();
      });
}

void Mobilizer::normalize(double* q) const {
  walk(
      coordinates_, [](int, int) {}, [&](int iq, int) { Eigen::Map<Vec4>(q + iq).normalize(); });
}

VecX Mobilizer::home() const {
  VecX q = VecX::Zero(n_q_);
  walk(
      coordinates_,
      [&](int iq, int) {
        if (has_range(iq)) q(iq) = std::clamp(0.0, structure_.ranges[iq][0], structure_.ranges[iq][1]);
      },
      [&](int iq, int) { q(iq) = 1.0; });
  return q;
}

bool Mobilizer::has_trials(int c) const {
  if (kind(c).is_length) return has_range(c);
  return c < structure_.n_scalars;
}

double Mobilizer::trial(int c, int k, double given) const {
  if (!kind(c).is_length) return given + 0.5 * std::numbers::pi * k;
  const auto& [least, greatest] = structure_.ranges[c];
  return least + (greatest - least) * (2 * k + 1) / 8.0;
}

}  // namespace concord::relative
