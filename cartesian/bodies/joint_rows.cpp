#include "cartesian/bodies/joint_rows.h"

#include <array>
#include <cmath>

#include "cartesian/bodies/small_products.h"
#include "common/error.h"

namespace concord::cartesian {

namespace {

using joints::BearingOfGap;
using joints::ByReading;
using joints::ByResidual;
using joints::Coincide;
using joints::ElevationOfGap;
using joints::KeepDistance;
using joints::NoGapAlong;
using joints::NoSlip;
using joints::OrientationOf;
using joints::Perpendicular;
using joints::SameDirection;
using joints::SameOrientation;
using joints::SlideAlong;
using joints::TurnOfChildAxis;
using joints::TurnOfParentAxis;

const std::array<Vec3, 3> kUnits{Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
const Vec3& unit(Axis axis) { return kUnits[index(axis)]; }

Axis next(Axis axis) { return static_cast<Axis>((index(axis) + 1) % 3); }

/// d . e: gap along an axis of the parent (C16).
ConstraintRow gap_row(const Vec3& e, const RelativeMotion& motion) {
  ConstraintRow row;
  row.value = e.dot(motion.d);
  row.over_d = e;
  return row;
}

/// m . (R n) for a vector m fixed on the parent and n fixed on the child (C17).
ConstraintRow dot_row(const Vec3& m, const Vec3& n, const RelativeMotion& motion) {
  const Vec3 R_n = times(motion.R, n);
  const Vec3 swing = cross(motion.omega, R_n);
  ConstraintRow row;
  row.value = m.dot(R_n);
  row.over_rho = cross(R_n, m);
  row.bias = motion.omega.dot(cross(swing, m));
  return row;
}

/// atan2(y, x) of two rows (C18).
ConstraintRow angle_row(const ConstraintRow& y, const ConstraintRow& x, const RelativeMotion& motion) {
  const double square = x.value * x.value + y.value * y.value;
  const double xdot = rate_of(x, motion);
  const double ydot = rate_of(y, motion);
  const double turning = x.value * ydot - y.value * xdot;
  ConstraintRow row;
  row.value = std::atan2(y.value, x.value);
  row.over_d = (x.value * y.over_d - y.value * x.over_d) / square;
  row.over_rho = (x.value * y.over_rho - y.value * x.over_rho) / square;
  row.bias = (x.value * y.bias - y.value * x.bias) / square -
             turning * 2.0 * (x.value * xdot + y.value * ydot) / (square * square);
  return row;
}

/// |d - (d . e) e|: distance of the child's point from the parent's axis e (C19).
ConstraintRow distance_from_axis_row(const Vec3& e, const RelativeMotion& motion) {
  const Vec3 across = motion.d - motion.d.dot(e) * e;
  const Vec3 across_dot = motion.ddot - motion.ddot.dot(e) * e;
  ConstraintRow row;
  row.value = across.norm();
  row.over_d = across / row.value;
  const double rate = row.over_d.dot(across_dot);
  row.bias = (across_dot.squaredNorm() - rate * rate) / row.value;
  return row;
}

ConstraintRow row_of(const joints::FunctionOfPlacement::Rows& rows, int k) {
  return {rows.value(k), rows.gradient.col(k).head<3>(), rows.gradient.col(k).tail<3>(), rows.bias(k)};
}

joints::FunctionOfPlacement::Rows evaluate_function(const joints::FunctionOfPlacement& function,
                                                    const RelativeMotion& motion) {
  joints::FunctionOfPlacement::Rows rows;
  Vec6 v_rel;
  v_rel << motion.ddot, motion.omega;
  function.evaluate({motion.d, motion.R}, v_rel, rows);
  return rows;
}

int write(const Coincide&, const RelativeMotion& motion, ConstraintRow* rows) {
  for (int k = 0; k < 3; ++k) rows[k] = gap_row(unit(static_cast<Axis>(k)), motion);
  return 3;
}

int write(const NoGapAlong& word, const RelativeMotion& motion, ConstraintRow* rows) {
  rows[0] = gap_row(unit(word.axis), motion);
  return 1;
}

int write(const Perpendicular& word, const RelativeMotion& motion, ConstraintRow* rows) {
  rows[0] = dot_row(unit(word.on_parent), unit(word.on_child), motion);
  return 1;
}

int write(const SameDirection& word, const RelativeMotion& motion, ConstraintRow* rows) {
  const Vec3& axis = unit(word.axis);
  rows[0] = dot_row(unit(next(word.axis)), axis, motion);
  rows[1] = dot_row(unit(next(next(word.axis))), axis, motion);
  return 2;
}

int write(const SameOrientation&, const RelativeMotion& motion, ConstraintRow* rows) {
  evaluate_orientation(Mat3::Identity(), motion, rows);
  return 3;
}

int write(const KeepDistance& word, const RelativeMotion& motion, ConstraintRow* rows) {  // (C20)
  rows[0].value = (motion.d.squaredNorm() - word.length * word.length) / (2.0 * word.length);
  rows[0].over_d = motion.d / word.length;
  rows[0].over_rho.setZero();
  rows[0].bias = motion.ddot.squaredNorm() / word.length;
  return 1;
}

int write(const ByResidual& word, const RelativeMotion& motion, ConstraintRow* rows) {
  const joints::FunctionOfPlacement::Rows found = evaluate_function(*word.residual, motion);
  for (int k = 0; k < found.n; ++k) rows[k] = row_of(found, k);
  return found.n;
}

/// e . (ddot + omega x c), c = -below e_z fixed on the parent; e fixed there or carried by the child (C22).
ConstraintRow write(const NoSlip& word, const RelativeMotion& motion) {
  const Vec3 contact = -word.below * Vec3::UnitZ();
  const bool turns = word.axis_of == Side::child;
  const Vec3 e = turns ? Vec3(motion.R * unit(word.axis)) : unit(word.axis);
  const Vec3 edot = turns ? Vec3(motion.omega.cross(e)) : Vec3(Vec3::Zero());
  ConstraintRow row;
  row.over_d = e;
  row.over_rho = contact.cross(e);
  row.bias = edot.dot(motion.ddot + motion.omega.cross(contact));
  return row;
}

bool branch(const Coincide&, const RelativeMotion&) { return true; }
bool branch(const NoGapAlong&, const RelativeMotion&) { return true; }
bool branch(const Perpendicular&, const RelativeMotion&) { return true; }
bool branch(const SameDirection& word, const RelativeMotion& at) {
  return at.R(index(word.axis), index(word.axis)) > 0.0;
}
bool branch(const SameOrientation&, const RelativeMotion& at) { return at.R.trace() > 1.0; }
bool branch(const KeepDistance&, const RelativeMotion&) { return true; }
bool branch(const ByResidual& word, const RelativeMotion& at) {
  return word.on_branch == nullptr || word.on_branch({at.d, at.R});
}

ConstraintRow read(const SlideAlong& word, int, const RelativeMotion& motion) {
  return gap_row(unit(word.axis), motion);
}

/// The child's axis e seen from the parent: from e towards about x e.
ConstraintRow read(const TurnOfChildAxis& word, int, const RelativeMotion& motion) {
  const Vec3 e = unit(word.of_child_axis);
  return angle_row(dot_row(unit(word.about).cross(e), e, motion), dot_row(e, e, motion), motion);
}

/// The parent's axis e seen from the child turns the other way.
ConstraintRow read(const TurnOfParentAxis& word, int, const RelativeMotion& motion) {
  const Vec3 e = unit(word.of_parent_axis);
  return angle_row(dot_row(e, e.cross(unit(word.about)), motion), dot_row(e, e, motion), motion);
}

/// An orientation is no single number: callers use evaluate_orientation().
ConstraintRow read(const OrientationOf&, int, const RelativeMotion&) { return {}; }

ConstraintRow read(const BearingOfGap& word, int, const RelativeMotion& motion) {
  const Vec3 e = unit(word.from);
  ConstraintRow row = angle_row(gap_row(unit(word.about).cross(e), motion), gap_row(e, motion), motion);
  if (motion.is_beyond_upright) row.value += row.value > 0.0 ? -EIGEN_PI : EIGEN_PI;
  return row;
}

ConstraintRow read(const ElevationOfGap& word, int, const RelativeMotion& motion) {
  const Vec3 e = unit(word.towards);
  ConstraintRow row = angle_row(gap_row(e, motion), distance_from_axis_row(e, motion), motion);
  if (!motion.is_beyond_upright) return row;
  return {static_cast<double>(EIGEN_PI) - row.value, -row.over_d, -row.over_rho, -row.bias};
}

ConstraintRow read(const ByReading& word, int component, const RelativeMotion& motion) {
  return row_of(evaluate_function(*word.reading, motion), component);
}

/// Columns of the motion, 6 x n_u, in fixed memory.
using Columns = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6>;

struct ColumnWriter {
  const RelativeMotion& motion;
  Mat6& columns;
  int count = 0;

  void operator()(const SlideAlong& word) { put(unit(word.axis), Vec3::Zero()); }
  void operator()(const TurnOfChildAxis& word) { put(Vec3::Zero(), unit(word.about)); }
  void operator()(const TurnOfParentAxis& word) { put(Vec3::Zero(), motion.R * unit(word.about)); }
  void operator()(const OrientationOf&) {
    for (int k = 0; k < 3; ++k) put(Vec3::Zero(), Vec3::Unit(k));
  }
  void operator()(const BearingOfGap& word) { put(unit(word.about).cross(motion.d), Vec3::Zero()); }
  void operator()(const ElevationOfGap& word) {
    const Vec3 e = unit(word.towards);
    const Vec3 across = motion.d - motion.d.dot(e) * e;
    const Vec3 upward = across.norm() * e - motion.d.dot(e) * across.normalized();
    put(motion.is_beyond_upright ? Vec3(-upward) : upward, Vec3::Zero());
  }
  void operator()(const ByReading& word) {
    if (word.wrenches == nullptr) {
      throw SolverError(
          "cartesian: a reading by functions states no coordinate wrenches, but its coordinate is pushed");
    }
    const joints::Wrenches found = word.wrenches({motion.d, motion.R});
    for (Eigen::Index k = 0; k < found.cols(); ++k) put(found.col(k).head<3>(), found.col(k).tail<3>());
  }

 private:
  void put(const Vec3& force, const Vec3& torque) { columns.col(count++) << force, torque; }
};

/// Whether a reading changes by more than a turn where the child moves far without turning: an angle that is known but
/// for turns does not.
bool goes_beyond_turns(const joints::Read& word, int component) {
  constexpr double kTurn = 2.0 * EIGEN_PI;
  RelativeMotion at;
  const Vec3 place(0.37, 0.21, 0.53);
  at.d = place;
  const double here = evaluate_read(word, component, at).value;
  for (const double far : {1e6, 1e50, 1e150}) {  // m: beyond two turns of any thread
    for (int axis = 0; axis < 3; ++axis) {
      at.d = place + far * Vec3::Unit(axis);
      if (std::abs(evaluate_read(word, component, at).value - here) > 1.5 * kTurn) return true;
    }
  }
  return false;
}

bool is_by_functions(const joints::JointType& type) {
  return type.reads.size() == 1 && function_of(type.reads.front()) != nullptr;
}

/// S of a type whose coordinates read by functions: what no row forbids and moves one reading at unit speed (C25).
Columns permitted_columns(const joints::JointType& type, const RelativeMotion& motion) {
  ConstraintRow rows[kMaxRows];
  const int n_forbids = evaluate_forbids(type, motion, rows);
  for (int k = n_forbids; k < 6; ++k) rows[k] = evaluate_read(type.reads.front(), k - n_forbids, motion);
  Mat6 gradients;
  for (int k = 0; k < 6; ++k) gradients.row(k) << rows[k].over_d.transpose(), rows[k].over_rho.transpose();
  return gradients.inverse().rightCols(6 - n_forbids);
}

}  // namespace

int evaluate_forbids(const joints::JointType& type, const RelativeMotion& motion, ConstraintRow* rows) {
  int count = 0;
  for (const joints::Forbid& word : type.forbids) {
    count += std::visit([&](const auto& forbidden) { return write(forbidden, motion, rows + count); }, word);
  }
  return count;
}

int evaluate_forbidden_speeds(const joints::JointType& type, const RelativeMotion& motion, ConstraintRow* rows) {
  int count = 0;
  for (const joints::ForbidSpeed& word : type.forbids_speeds) {
    rows[count++] = std::visit([&](const auto& forbidden) { return write(forbidden, motion); }, word);
  }
  return count;
}

bool on_branch(const joints::JointType& type, const RelativeMotion& motion) {
  for (const joints::Forbid& word : type.forbids) {
    if (!std::visit([&](const auto& forbidden) { return branch(forbidden, motion); }, word)) return false;
  }
  return true;
}

const joints::Read* read_of(const joints::JointType& type, int word) {
  if (n_q(type.permits[word]) == 0) return nullptr;
  int place = word;
  for (int before = 0; before < word; ++before) {
    if (n_q(type.permits[before]) == 0) --place;
  }
  return &type.reads[place];
}

ConstraintRow evaluate_read(const joints::Read& word, int component, const RelativeMotion& motion) {
  return std::visit([&](const auto& reading) { return read(reading, component, motion); }, word);
}

bool reads_turn(const joints::Read& word, int component) {
  switch (kind_of(word, component)) {
    case joints::CoordinateKind::length:
      return false;
    case joints::CoordinateKind::orientation:
      return true;
    case joints::CoordinateKind::angle:
      return function_of(word) == nullptr || !goes_beyond_turns(word, component);
  }
  return false;
}

namespace {

/// In more digits than a coordinate has, so that many turns are taken off without loss.
constexpr long double kFullTurn = 6.283185307179586476925286766559L;

}  // namespace

long double whole_turns_between(double value, double known) {
  return kFullTurn * std::round((known - value) / static_cast<double>(kFullTurn));
}

double turn_from(double asked, double value) {
  const auto within_a_turn = static_cast<double>(std::remainder(static_cast<long double>(asked), kFullTurn));
  return std::remainder(value - within_a_turn, static_cast<double>(kFullTurn));
}

double value_near(bool is_known_but_for_turns, const ConstraintRow& row, double known) {
  if (!is_known_but_for_turns) return row.value;
  return static_cast<double>(row.value + whole_turns_between(row.value, known));
}

double rate_of(const ConstraintRow& row, const RelativeMotion& motion) {
  return row.over_d.dot(motion.ddot) + row.over_rho.dot(motion.omega);
}

void evaluate_orientation(const Mat3& target, const RelativeMotion& motion, ConstraintRow* rows) {
  // c = 1/2 sum of e_k x (Q e_k), Q = R target^T, turns with R: Qdot = omega~ Q. Gradient (tr Q 1 - Q) / 2.
  const Mat3 Q = motion.R * target.transpose();
  const Mat3 gradient = 0.5 * (Q.trace() * Mat3::Identity() - Q);
  const Vec3 value = 0.5 * Vec3(Q(2, 1) - Q(1, 2), Q(0, 2) - Q(2, 0), Q(1, 0) - Q(0, 1));
  Mat3 Qdot;
  for (int k = 0; k < 3; ++k) Qdot.col(k) = motion.omega.cross(Q.col(k));
  const Vec3 bias = 0.5 * (Qdot.trace() * motion.omega - Qdot * motion.omega);
  for (int k = 0; k < 3; ++k) {
    rows[k] = {value(k), Vec3::Zero(), gradient.row(k).transpose(), bias(k)};
  }
}

Vec6 coordinate_wrench(const joints::JointType& type, const RelativeMotion& motion, const Eigen::Ref<const VecX>& tau) {
  Mat6 directions;
  ColumnWriter writer{motion, directions};
  for (const joints::Read& word : type.reads) std::visit(writer, word);
  const Columns span = directions.leftCols(writer.count);
  const Columns S = is_by_functions(type) ? permitted_columns(type, motion) : span;
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6> work = S.transpose() * span;
  const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1> weights = work.partialPivLu().solve(tau);
  return span * weights;
}

}  // namespace concord::cartesian
