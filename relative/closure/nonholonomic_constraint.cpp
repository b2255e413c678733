#include "relative/closure/nonholonomic_constraint.h"

#include <fmt/format.h>

#include <stdexcept>
#include <variant>
#include <vector>

#include "common/error.h"
#include "common/overloaded.h"
#include "relative/bodies/six_columns.h"

namespace concord::relative {

namespace {

constexpr double kContradiction = 1e-9;  // of a column

struct MovingAxis {
  Vec3 e = Vec3::Zero();
  Vec3 edot = Vec3::Zero();
};

/// An axis of one side in the parent's joint frame; the child's turn with it.
MovingAxis axis_of(Side side, Axis axis, const JointMotion& at) {
  if (side == Side::parent) return {Vec3::Unit(index(axis)), Vec3::Zero()};
  const Vec3 e = at.R.col(index(axis));
  return {e, at.v_rel.tail<3>().cross(e)};
}

Vec6 stacked(const Vec3& linear, const Vec3& angular) {
  Vec6 both;
  both << linear, angular;
  return both;
}

/// Least squares with independent columns; once more for the round-off of the normal equations.
template <class Right>
Right fitted(const JointColumns& columns,
             const Eigen::Matrix<double, 6, Right::ColsAtCompileTime, 0, 6, Right::MaxColsAtCompileTime>& right) {
  const JointSquare normal = columns.transpose().lazyProduct(columns);
  const Eigen::LDLT<JointSquare> ldlt(normal);
  Right solution = ldlt.solve(Right(columns.transpose().lazyProduct(right)));
  solution += ldlt.solve(Right(columns.transpose().lazyProduct(right - columns.lazyProduct(solution))));
  return solution;
}

}  // namespace

NonholonomicConstraint::NonholonomicConstraint(const joints::JointType& type, const Mobilizer& mobilizer)
    : mobilizer_(&mobilizer), words_(type.permits_speeds), units_(JointVector::Ones(mobilizer.n_u())) {
  if (words_.empty()) return;
  n_rows_ = mobilizer.n_u() - static_cast<int>(words_.size());
  for (int c = 0; c < mobilizer.n_u(); ++c) {
    if (mobilizer.kind(c).is_length) units_(c) = mobilizer.length();
  }
  const VecX home = mobilizer.home();
  const VecX still = VecX::Zero(mobilizer.n_u());
  JointMotion at;
  mobilizer.evaluate(home.data(), still.data(), at);
  place_columns(at);
  const int n_u = mobilizer.n_u();
  JointColumns stated = S_v_;
  JointColumns outside = at.S.leftCols(n_u).lazyProduct(in_joint_speeds(at).topRows(n_u)) - S_v_;
  stated.topRows<3>() /= mobilizer.length();
  outside.topRows<3>() /= mobilizer.length();
  const auto allowed = kContradiction * stated.colwise().norm().array();
  if (n_rows_ > 0 && (outside.colwise().norm().array() <= allowed).all()) return;
  throw std::invalid_argument("joint type '" + type.name +
                              "': the permitted speeds must be fewer than those of the motion, and among them");
}

void NonholonomicConstraint::place_columns(const JointMotion& at) {  // (S15)
  const auto n = static_cast<Eigen::Index>(words_.size());
  S_v_.resize(6, n);
  rates_.resize(6, n);
  for (Eigen::Index c = 0; c < n; ++c) {
    std::visit(Overloaded{[&](const joints::SpeedAlong& along) {
                            const MovingAxis axis = axis_of(along.axis_of, along.axis, at);
                            S_v_.col(c) = stacked(axis.e, Vec3::Zero());
                            rates_.col(c) = stacked(axis.edot, Vec3::Zero());
                          },
                          [&](const joints::SpeedAbout& about) {
                            const MovingAxis axis = axis_of(about.axis_of, about.axis, at);
                            const Vec3 up = about.below * Vec3::UnitZ();
                            S_v_.col(c) = stacked(axis.e.cross(up), axis.e);
                            rates_.col(c) = stacked(axis.edot.cross(up), axis.edot);
                          }},
               words_[c]);
  }
}

/// P with S P = S_v (n_u x words) (R47).
JointColumns NonholonomicConstraint::in_joint_speeds(const JointMotion& at) const {
  JointColumns S = at.S.leftCols(mobilizer_->n_u());
  JointColumns S_v = S_v_;
  S.topRows<3>() /= mobilizer_->length();
  S_v.topRows<3>() /= mobilizer_->length();
  const JointColumns scaled = S * units_.asDiagonal();
  JointColumns P = JointColumns::Zero(6, S_v.cols());
  P.topRows(mobilizer_->n_u()) = units_.asDiagonal() * fitted<JointSquare>(scaled, S_v);
  return P;
}

/// w with S_v w = v_rel.
JointVector NonholonomicConstraint::speeds_of(const Vec6& v_rel) const {
  JointColumns S_v = S_v_;
  Vec6 v = v_rel;
  S_v.topRows<3>() /= mobilizer_->length();
  v.head<3>() /= mobilizer_->length();
  return fitted<JointVector>(S_v, v);
}

/// C: what is orthogonal to P among the joint's speeds. False if two columns of P are one.
bool NonholonomicConstraint::complete(const JointColumns& P) {
  const int n_u = mobilizer_->n_u();
  OrthonormalColumns directions;
  for (int beyond = n_u; beyond < 6; ++beyond) directions.add(Vec6::Unit(beyond));
  for (Eigen::Index c = 0; c < P.cols(); ++c) {
    Vec6 column = P.col(c);
    column.head(n_u).array() /= units_.array();
    const Vec6 rest = directions.rest(column);
    if (!(rest.norm() > kLeastOwnPart * column.norm())) return false;
    directions.add(rest);
  }
  directions.complete();
  C_ = directions.directions().rightCols(n_rows_).topRows(n_u);
  C_.array().colwise() /= units_.array();
  return true;
}

void NonholonomicConstraint::evaluate(const JointMotion& at, const std::string& owner) {  // (R48)
  place_columns(at);
  if (!complete(in_joint_speeds(at))) {
    throw SingularPose(fmt::format(
        "relative: joint '{}': two of the speeds that it permits are one in this pose: its velocity is singular there",
        owner));
  }
  const Vec6 misfit = at.Sdot_u - rates_.lazyProduct(speeds_of(at.v_rel));
  bias_.resize(n_rows_);
  for (int row = 0; row < n_rows_; ++row) {
    bias_(row) = mobilizer_->coordinate_wrench(at, JointVector(C_.col(row))).dot(misfit);
  }
}

}  // namespace concord::relative
