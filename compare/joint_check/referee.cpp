#include "compare/joint_check/referee.h"

#include <Eigen/Geometry>

#include "common/decompositions.h"

namespace concord::compare::joint_check {

namespace {

using joints::Jet;
using joints::Mat3Of;
using joints::PlacementOf;
using joints::Vec3Of;

using JetPlacement = PlacementOf<Jet>;
using Motion = joints::FunctionOfCoordinates::Motion;
using Jets = std::vector<Jet>;

Vec3 unit(Axis axis) { return Vec3::Unit(index(axis)); }

/// A direction of the child's joint frame in the parent's, and the component of d along a parent's axis.
Jet component(const JetPlacement& at, Axis on_parent, Axis on_child) { return at.R(index(on_parent), index(on_child)); }
Jet gap(const JetPlacement& at, Axis axis) { return at.d(index(axis)); }

Jet along(const Vec3& direction, const Vec3Of<Jet>& v) {
  return direction.x() * v(0) + direction.y() * v(1) + direction.z() * v(2);
}

struct Forbidden {
  const JetPlacement& at;
  Jets& rows;

  void operator()(const joints::Coincide&) const {
    for (const Axis axis : {Axis::x, Axis::y, Axis::z}) rows.push_back(gap(at, axis));
  }
  void operator()(const joints::NoGapAlong& word) const { rows.push_back(gap(at, word.axis)); }
  void operator()(const joints::Perpendicular& word) const {
    rows.push_back(component(at, word.on_parent, word.on_child));
  }
  void operator()(const joints::SameDirection& word) const {
    for (int step = 1; step < 3; ++step) {
      rows.push_back(at.R((index(word.axis) + step) % 3, index(word.axis)));
    }
  }
  void operator()(const joints::SameOrientation&) const {
    for (int k = 0; k < 3; ++k) {
      const int after = (k + 1) % 3;
      const int before = (k + 2) % 3;
      rows.push_back(0.5 * (at.R(before, after) - at.R(after, before)));
    }
  }
  void operator()(const joints::KeepDistance& word) const {
    rows.push_back((gap(at, Axis::x) * gap(at, Axis::x) + gap(at, Axis::y) * gap(at, Axis::y) +
                    gap(at, Axis::z) * gap(at, Axis::z) - word.length * word.length) /
                   (2.0 * word.length));
  }
  void operator()(const joints::ByResidual&) const {}  // asked for its own derivatives
};

struct Reading {
  const JetPlacement& at;
  Jets& rows;

  void operator()(const joints::TurnOfChildAxis& word) const {
    const Vec3Of<Jet> child_axis = at.R.col(index(word.of_child_axis));
    const Vec3 start = unit(word.of_child_axis);
    rows.push_back(atan2(along(unit(word.about).cross(start), child_axis), along(start, child_axis)));
  }
  void operator()(const joints::TurnOfParentAxis& word) const {
    const Vec3Of<Jet> parent_axis = at.R.row(index(word.of_parent_axis)).transpose();
    const Vec3 start = unit(word.of_parent_axis);
    rows.push_back(-atan2(along(unit(word.about).cross(start), parent_axis), along(start, parent_axis)));
  }
  void operator()(const joints::SlideAlong& word) const { rows.push_back(gap(at, word.axis)); }
  void operator()(const joints::BearingOfGap& word) const {
    rows.push_back(atan2(along(unit(word.about).cross(unit(word.from)), at.d), gap(at, word.from)));
  }
  void operator()(const joints::ElevationOfGap& word) const {
    rows.push_back(asin(gap(at, word.towards) / sqrt(at.d(0) * at.d(0) + at.d(1) * at.d(1) + at.d(2) * at.d(2))));
  }
  void operator()(const joints::OrientationOf&) const {
    for (int k = 0; k < 3; ++k) rows.emplace_back();
  }
  void operator()(const joints::ByReading&) const {}  // asked for its own derivatives
};

std::vector<RefereedRow> rows_of(const Jets& jets) {
  std::vector<RefereedRow> rows;
  for (const Jet& jet : jets) rows.push_back({jet.value, jet.gradient, jet.rate_of_rate});
  return rows;
}

void append_function(const joints::FunctionOfPlacement& function, const Placement& at, const Vec6& v_rel,
                     std::vector<RefereedRow>& rows) {
  joints::FunctionOfPlacement::Rows found;
  function.evaluate(at, v_rel, found);
  for (int k = 0; k < found.n; ++k) rows.push_back({found.value(k), found.gradient.col(k), found.bias(k)});
}

void append_rotation(std::vector<RefereedRow>& rows) {
  for (int k = 0; k < 3; ++k) rows.push_back({0.0, Vec6::Unit(3 + k), 0.0});
}

/// The motion of the words read so far, in jets over the speeds; q and u advance with each word.
struct Permitted {
  const double* q;
  const double* u;
  JetPlacement& reached;
  int column = 0;

  void operator()(const joints::Turn& turn) { reached.R = (reached.R * joints::rotation_by(turn.axis, next())).eval(); }
  void operator()(const joints::Slide& slide) { move(slide.axis, next()); }
  void operator()(const joints::Arm& arm) { move(arm.axis, arm.length); }
  void operator()(const joints::Ball&) {
    const Mat3 R = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
    const Vec3 omega(u[0], u[1], u[2]);
    for (int c = 0; c < 3; ++c) {
      const Vec3 axis = R.col(c);
      const Vec3 swing = omega.cross(axis);
      for (int r = 0; r < 3; ++r) {
        Vec6 gradient = Vec6::Zero();
        gradient.segment<3>(column) = axis.cross(Vec3::Unit(r));
        reached.R(r, c) = Jet(axis(r), gradient, swing(r), omega.cross(swing)(r));
      }
    }
    column += 3;
  }
  void operator()(const joints::ByMotion&) {}  // stands alone: asked for its own derivatives

 private:
  Jet next() {
    const Jet coordinate(*q, Vec6::Unit(column), *u, 0.0);
    ++q;
    ++u;
    ++column;
    return coordinate;
  }
  void move(Axis axis, const Jet& distance) {
    for (int r = 0; r < 3; ++r) reached.d(r) += reached.R(r, index(axis)) * distance;
  }
};

/// Directions of the coordinate wrenches of all speeds: what is read from the gap is pushed by a force, what is read
/// from the orientation by a torque, each along the motion's own column S.
struct WrenchDirections {
  const Motion& motion;
  Mat6& span;
  int column = 0;

  void operator()(const joints::TurnOfChildAxis&) { push(3); }
  void operator()(const joints::TurnOfParentAxis&) { push(3); }
  void operator()(const joints::SlideAlong&) { push(0); }
  void operator()(const joints::BearingOfGap&) { push(0); }
  void operator()(const joints::ElevationOfGap&) { push(0); }
  void operator()(const joints::OrientationOf&) {
    for (int k = 0; k < 3; ++k) push(3);
  }
  void operator()(const joints::ByReading& word) {
    if (word.wrenches == nullptr) return;
    const joints::Wrenches said = word.wrenches(motion.placement);
    span.middleCols(column, said.cols()) = said;
    column += static_cast<int>(said.cols());
  }

 private:
  void push(int first_row) {
    span.col(column).segment<3>(first_row) = motion.S.col(column).segment<3>(first_row);
    ++column;
  }
};

}  // namespace

std::vector<RefereedRow> referee_forbids(const JointType& type, const Placement& at, const Vec6& v_rel) {
  const JetPlacement moving = joints::moving(at, v_rel);
  std::vector<RefereedRow> rows;
  for (const joints::Forbid& word : type.forbids) {
    if (const auto* by = std::get_if<joints::ByResidual>(&word)) {
      append_function(*by->residual, at, v_rel, rows);
      continue;
    }
    Jets jets;
    std::visit(Forbidden{moving, jets}, word);
    for (const RefereedRow& row : rows_of(jets)) rows.push_back(row);
  }
  return rows;
}

std::vector<RefereedRow> referee_reads(const JointType& type, const Placement& at, const Vec6& v_rel) {
  const JetPlacement moving = joints::moving(at, v_rel);
  std::vector<RefereedRow> rows;
  for (const joints::Read& word : type.reads) {
    if (const auto* by = std::get_if<joints::ByReading>(&word)) {
      append_function(*by->reading, at, v_rel, rows);
    } else if (std::holds_alternative<joints::OrientationOf>(word)) {
      append_rotation(rows);
    } else {
      Jets jets;
      std::visit(Reading{moving, jets}, word);
      rows.push_back(rows_of(jets).front());
    }
  }
  return rows;
}

Motion referee_permits(const JointType& type, const VecX& q, const VecX& u) {
  Motion motion;
  if (type.permits.size() == 1) {
    if (const auto* by = std::get_if<joints::ByMotion>(&type.permits.front())) {
      by->motion->evaluate(q.data(), u.data(), motion);
      return motion;
    }
  }
  JetPlacement reached{Vec3Of<Jet>::Zero(), Mat3Of<Jet>::Identity()};
  Permitted permitted{q.data(), u.data(), reached};
  for (const joints::Permit& word : type.permits) {
    // A ball is the child's orientation itself, whatever turns have carried its arm.
    std::visit(permitted, word);
  }
  joints::write_motion(reached, type.n_u(), motion);
  return motion;
}

Vec6 referee_coordinate_wrench(const JointType& type, const Motion& motion, const VecX& tau) {
  const auto n = static_cast<Eigen::Index>(type.n_u());
  if (n == 0) return Vec6::Zero();
  Mat6 span = Mat6::Zero();
  WrenchDirections directions{motion, span};
  for (const joints::Read& word : type.reads) std::visit(directions, word);
  const MatX work = motion.S.leftCols(n).transpose() * span.leftCols(n);
  return span.leftCols(n) * solve_by_complete_pivoting(work, tau);
}

}  // namespace concord::compare::joint_check
