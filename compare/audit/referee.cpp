#include "compare/audit/referee.h"

#include <Eigen/Geometry>
#include <optional>
#include <stdexcept>

#include "common/decompositions.h"
#include "common/products.h"
#include "common/rotation.h"
#include "compare/audit/places.h"

namespace concord::compare {

namespace {

using joints::Jet;
using joints::JointType;
using joints::Mat3Of;
using joints::Placement;
using joints::PlacementOf;
using joints::Vec3Of;

using JetPlacement = PlacementOf<Jet>;

Vec3 axis_vector(Axis axis) { return Vec3::Unit(index(axis)); }

/// R e of a constant vector e.
template <class T>
Vec3Of<T> image_of(const Mat3Of<T>& R, const Vec3& e) {
  Vec3Of<T> image;
  for (int r = 0; r < 3; ++r) image(r) = R(r, 0) * e(0) + R(r, 1) * e(1) + R(r, 2) * e(2);
  return image;
}

/// v . e of a constant vector e.
template <class T>
T part_along(const Vec3Of<T>& v, const Vec3& e) {
  return v(0) * e(0) + v(1) * e(1) + v(2) * e(2);
}

/// Angle of v about `about`, right-handed from `from`.
template <class T>
T bearing_of(const Vec3Of<T>& v, Axis about, Axis from) {
  return atan2(part_along(v, axis_vector(about).cross(axis_vector(from))), part_along(v, axis_vector(from)));
}

// What is forbidden --------------------------------------------------------------------------------------------------

void append_functions(const joints::FunctionOfPlacement& function, const Placement& at, const Vec6& v_rel,
                      std::vector<RefereedRow>& rows) {
  joints::FunctionOfPlacement::Rows found;
  function.evaluate(at, v_rel, found);
  for (int k = 0; k < found.n; ++k) rows.push_back({found.value(k), found.gradient.col(k), found.bias(k)});
}

RefereedRow row_of_jet(const Jet& jet) { return {jet.value, jet.gradient, jet.rate_of_rate}; }

class ForbiddenRows {
 public:
  ForbiddenRows(const Placement& at, const Vec6& v_rel, std::vector<RefereedRow>& rows)
      : at_(at), v_rel_(v_rel), moving_(joints::moving(at, v_rel)), rows_(rows) {}

  void operator()(const joints::Coincide&) {
    for (int k = 0; k < 3; ++k) add(moving_.d(k));
  }
  void operator()(const joints::NoGapAlong& word) { add(moving_.d(index(word.axis))); }
  void operator()(const joints::Perpendicular& word) { add(moving_.R(index(word.on_parent), index(word.on_child))); }
  void operator()(const joints::SameDirection& word) {
    for (int step = 1; step < 3; ++step) add(moving_.R((index(word.axis) + step) % 3, index(word.axis)));
  }
  void operator()(const joints::SameOrientation&) {
    for (int k = 0; k < 3; ++k) {
      const int after = (k + 1) % 3;
      const int before = (k + 2) % 3;
      add(0.5 * (moving_.R(before, after) - moving_.R(after, before)));
    }
  }
  void operator()(const joints::KeepDistance& word) {
    const Vec3Of<Jet>& d = moving_.d;
    add((d(0) * d(0) + d(1) * d(1) + d(2) * d(2) - word.length * word.length) / (2.0 * word.length));
  }
  void operator()(const joints::ByResidual& word) { append_functions(*word.residual, at_, v_rel_, rows_); }

 private:
  void add(const Jet& jet) { rows_.push_back(row_of_jet(jet)); }

  const Placement& at_;
  const Vec6& v_rel_;
  JetPlacement moving_;
  std::vector<RefereedRow>& rows_;
};

// How coordinates read -----------------------------------------------------------------------------------------------

/// The number that a reading says of a placement.
template <class T>
class NumberRead {
 public:
  explicit NumberRead(const PlacementOf<T>& at) : at_(at) {}

  T operator()(const joints::TurnOfChildAxis& word) const {
    return bearing_of(image_of(at_.R, axis_vector(word.of_child_axis)), word.about, word.of_child_axis);
  }
  /// Seen from the child, its own axis stands still and the parent's has turned back.
  T operator()(const joints::TurnOfParentAxis& word) const {
    const Mat3Of<T> back = at_.R.transpose();
    return -bearing_of(image_of(back, axis_vector(word.of_parent_axis)), word.about, word.of_parent_axis);
  }
  T operator()(const joints::SlideAlong& word) const { return part_along(at_.d, axis_vector(word.axis)); }
  T operator()(const joints::BearingOfGap& word) const { return bearing_of(at_.d, word.about, word.from); }
  T operator()(const joints::ElevationOfGap& word) const {
    const Vec3 e = axis_vector(word.towards);
    const Vec3Of<T>& d = at_.d;
    const Vec3Of<T> across(d(1) * e(2) - d(2) * e(1), d(2) * e(0) - d(0) * e(2), d(0) * e(1) - d(1) * e(0));
    return atan2(part_along(d, e), T(across.norm()));
  }
  T operator()(const joints::OrientationOf&) const { return is_no_number(); }
  T operator()(const joints::ByReading&) const { return is_no_number(); }

 private:
  static T is_no_number() { throw std::logic_error("the reading is not one number"); }

  const PlacementOf<T>& at_;
};

// What is permitted --------------------------------------------------------------------------------------------------

/// The coordinates of a motion, taken one after the other as they are.
class PlainCoordinates {
 public:
  using Number = double;

  explicit PlainCoordinates(const VecX& q) : q_(q.data()) {}

  double number() { return *q_++; }
  Mat3 turn(Axis axis) { return rotation_about(axis, number()); }
  Mat3 orientation() {
    const Vec4 p(q_[0], q_[1], q_[2], q_[3]);
    q_ += 4;
    return rotation_of(p);
  }

 private:
  const double* q_;
};

/// The same as jets over the speeds and along the motion.
class MovingCoordinates {
 public:
  using Number = Jet;

  MovingCoordinates(const VecX& q, const VecX& u) : q_(q.data()), u_(u.data()) {}

  Jet number() { return {*q_++, Vec6::Unit(column_++), *u_++, 0.0}; }
  Mat3Of<Jet> turn(Axis axis) { return joints::rotation_by(axis, number()); }
  Mat3Of<Jet> orientation() {
    const Mat3 R = Eigen::Quaterniond(q_[0], q_[1], q_[2], q_[3]).normalized().toRotationMatrix();
    const Vec3 omega(u_[0], u_[1], u_[2]);
    Mat3Of<Jet> moving;
    for (int c = 0; c < 3; ++c) {
      const Vec3 axis = R.col(c);
      const Vec3 swing = omega.cross(axis);
      for (int r = 0; r < 3; ++r) {
        Vec6 gradient = Vec6::Zero();
        gradient.segment<3>(column_) = axis.cross(Vec3::Unit(r));
        moving(r, c) = Jet(axis(r), gradient, swing(r), omega.cross(swing)(r));
      }
    }
    q_ += 4;
    u_ += 3;
    column_ += 3;
    return moving;
  }

 private:
  const double* q_;
  const double* u_;
  int column_ = 0;
};

/// Follows the words of a motion: where they lead, and what each coordinate turns about or slides along.
template <class Coordinates>
class PermittedMotion {
 public:
  using T = typename Coordinates::Number;

  /// A coordinate of one number, or an orientation, whose axes are the parent's.
  struct Line {
    joints::CoordinateKind kind;
    Vec3Of<T> axis;
    Vec3Of<T> place;
  };

  PermittedMotion(const JointType& type, const Coordinates& coordinates) : coordinates_(coordinates) {
    lines_.reserve(type.permits.size());
    for (const joints::Permit& word : type.permits) std::visit(*this, word);
  }

  void operator()(const joints::Turn& word) {
    lines_.push_back({joints::CoordinateKind::angle, image_of(reached_.R, axis_vector(word.axis)), reached_.d});
    reached_.R = (reached_.R * coordinates_.turn(word.axis)).eval();
  }
  void operator()(const joints::Slide& word) {
    const Vec3Of<T> along = image_of(reached_.R, axis_vector(word.axis));
    lines_.push_back({joints::CoordinateKind::length, along, reached_.d});
    move(along, coordinates_.number());
  }
  void operator()(const joints::Arm& word) { move(image_of(reached_.R, axis_vector(word.axis)), T(word.length)); }
  /// A ball is the child's orientation itself, whatever turns have carried its arm.
  void operator()(const joints::Ball&) {
    lines_.push_back({joints::CoordinateKind::orientation, Vec3Of<T>::Zero(), reached_.d});
    reached_.R = coordinates_.orientation();
  }
  void operator()(const joints::ByMotion&) { throw std::logic_error("a motion by functions stands alone"); }

  [[nodiscard]] const PlacementOf<T>& reached() const { return reached_; }
  [[nodiscard]] const std::vector<Line>& lines() const { return lines_; }

 private:
  void move(const Vec3Of<T>& along, const T& distance) {
    for (int r = 0; r < 3; ++r) reached_.d(r) += along(r) * distance;
  }

  Coordinates coordinates_;
  PlacementOf<T> reached_{Vec3Of<T>::Zero(), Mat3Of<T>::Identity()};
  std::vector<Line> lines_;
};

/// The function that states a whole motion; nullptr of one in words.
const joints::FunctionOfCoordinates* function_of_motion(const JointType& type) {
  return type.permits.size() == 1 ? joints::function_of(type.permits.front()) : nullptr;
}

/// The child's velocity for a unit of each speed. A turn before a ball carries the arm's end, but not the child's
/// orientation.
SpeedColumns columns_of(const PermittedMotion<PlainCoordinates>& motion, int n_u) {
  const auto& lines = motion.lines();
  const bool ends_with_ball = !lines.empty() && lines.back().kind == joints::CoordinateKind::orientation;
  SpeedColumns S = SpeedColumns::Zero(6, n_u);
  Eigen::Index column = 0;
  for (const auto& line : lines) {
    switch (line.kind) {
      case joints::CoordinateKind::angle:
        S.col(column).head<3>() = line.axis.cross(motion.reached().d - line.place);
        if (!ends_with_ball) S.col(column).tail<3>() = line.axis;
        break;
      case joints::CoordinateKind::length:
        S.col(column).head<3>() = line.axis;
        break;
      case joints::CoordinateKind::orientation:
        S.block<3, 3>(3, column).setIdentity();
        break;
    }
    column += joints::n_u(line.kind);
  }
  return S;
}

class SpeedDirection {
 public:
  explicit SpeedDirection(const Mat3& R) : R_(R) {}

  Vec6 operator()(const joints::SpeedAlong& word) const {
    return (Vec6() << axis(word.axis_of, word.axis), Vec3::Zero()).finished();
  }
  /// The point below d - below e_z rests: ddot + e x (-below e_z) = 0.
  Vec6 operator()(const joints::SpeedAbout& word) const {
    const Vec3 e = axis(word.axis_of, word.axis);
    return (Vec6() << word.below * e.cross(Vec3::UnitZ()), e).finished();
  }

 private:
  [[nodiscard]] Vec3 axis(Side of, Axis axis) const {
    return of == Side::parent ? axis_vector(axis) : Vec3(R_ * axis_vector(axis));
  }

  const Mat3& R_;
};

}  // namespace

std::vector<RefereedRow> referee_forbids(const JointType& type, const Placement& at, const Vec6& v_rel) {
  std::vector<RefereedRow> rows;
  ForbiddenRows forbidden(at, v_rel, rows);
  for (const joints::Forbid& word : type.forbids) std::visit(forbidden, word);
  return rows;
}

double referee_reading(const joints::Read& word, const Placement& at) {
  const PlacementOf<double> numbers{at.d, at.R};
  return std::visit(NumberRead<double>(numbers), word);
}

std::vector<RefereedRow> referee_reads(const JointType& type, const Placement& at, const Vec6& v_rel) {
  const JetPlacement moving = joints::moving(at, v_rel);
  std::vector<RefereedRow> rows;
  for (const joints::Read& word : type.reads) {
    if (const joints::FunctionOfPlacement* function = joints::function_of(word)) {
      append_functions(*function, at, v_rel, rows);
    } else if (joints::is_orientation(word)) {
      for (int k = 0; k < 3; ++k) rows.push_back({0.0, Vec6::Unit(3 + k), 0.0});
    } else {
      rows.push_back(row_of_jet(std::visit(NumberRead<Jet>(moving), word)));
    }
  }
  return rows;
}

joints::FunctionOfCoordinates::Motion referee_permits(const JointType& type, const VecX& q, const VecX& u) {
  joints::FunctionOfCoordinates::Motion motion;
  if (const joints::FunctionOfCoordinates* function = function_of_motion(type)) {
    function->evaluate(q.data(), u.data(), motion);
  } else {
    const PermittedMotion<MovingCoordinates> permitted(type, MovingCoordinates(q, u));
    joints::write_motion(permitted.reached(), type.n_u(), motion);
  }
  return motion;
}

RefereedMotion referee_motion(const JointType& type, const VecX& q) {
  if (const joints::FunctionOfCoordinates* function = function_of_motion(type)) {
    joints::FunctionOfCoordinates::Motion motion;
    const VecX at_rest = VecX::Zero(q.size());
    function->evaluate(q.data(), at_rest.data(), motion);
    return {motion.placement, motion.S.leftCols(type.n_u())};
  }
  const PermittedMotion<PlainCoordinates> permitted(type, PlainCoordinates(q));
  return {{permitted.reached().d, permitted.reached().R}, columns_of(permitted, type.n_u())};
}

Vec6 referee_permitted_speed(const joints::PermitSpeed& word, const Mat3& R) {
  return std::visit(SpeedDirection(R), word);
}

Mat6X referee_wrench_directions(const JointType& type, const Placement& at, const Mat6X& S) {
  Mat6X span = Mat6X::Zero(6, S.cols());
  Eigen::Index column = 0;
  for (const joints::Read& word : type.reads) {
    const Eigen::Index n = joints::n_u(word);
    switch (joints::pushed_by(word)) {
      case joints::Push::force:
        span.block(0, column, 3, n) = S.block(0, column, 3, n);
        break;
      case joints::Push::torque:
        span.block(3, column, 3, n) = S.block(3, column, 3, n);
        break;
      case joints::Push::stated:
        if (const joints::WrenchesOfPlacement stated = joints::stated_wrenches(word)) {
          span.middleCols(column, n) = stated(at);
        } else {
          span.middleCols(column, n) = S.middleCols(column, n);
        }
        break;
    }
    column += n;
  }
  return span;
}

Vec6 referee_coordinate_wrench(const JointType& type, const joints::FunctionOfCoordinates::Motion& motion,
                               const VecX& tau) {
  const auto n = static_cast<Eigen::Index>(type.n_u());
  if (n == 0) return Vec6::Zero();
  const Mat6X S = motion.S.leftCols(n);
  const Mat6X span = referee_wrench_directions(type, motion.placement, S);
  const MatX work = transposed_product(S, span);
  return span * solve_by_complete_pivoting(work, tau);
}

}  // namespace concord::compare
