#include "compare/audit/joint_motion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/decompositions.h"
#include "common/joints/named_coordinates.h"
#include "common/overloaded.h"
#include "common/rotation.h"

namespace concord::compare {

namespace {

Vec3 unit(Axis axis) { return Vec3::Unit(index(axis)); }

/// Angle of v about `about`, right-handed from `from`.
double bearing(const Vec3& v, Axis about, Axis from) {
  return std::atan2(v.dot(unit(about).cross(unit(from))), v.dot(unit(from)));
}

/// The angle that differs from `angle` by whole turns and is nearest to `near`.
double with_turns(double angle, double near) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  return angle + kTurn * std::round((near - angle) / kTurn);
}

/// Reads the coordinates of the words of a motion one after the other.
class Reading {
 public:
  Reading(const RelativeMotion& relative, const VecX& hint, VecX& q) : relative_(relative), hint_(hint), q_(q) {}

  void operator()(const joints::TurnOfChildAxis& word) {
    put_turn(bearing(relative_.R * unit(word.of_child_axis), word.about, word.of_child_axis));
  }
  void operator()(const joints::TurnOfParentAxis& word) {
    // Seen from the child, its own axis stands still and the parent's has turned back.
    put_turn(-bearing(relative_.R.transpose() * unit(word.of_parent_axis), word.about, word.of_parent_axis));
  }
  void operator()(const joints::SlideAlong& word) { q_(next_++) = relative_.d.dot(unit(word.axis)); }
  void operator()(const joints::OrientationOf&) {
    const Eigen::Quaterniond turned(relative_.R);
    q_.segment<4>(next_) << turned.w(), turned.vec();
    next_ += 4;
  }
  void operator()(const joints::BearingOfGap& word) {
    bearing_ = next_;
    put_turn(bearing(relative_.d, word.about, word.from));
  }
  /// A direction has two pairs of bearing and elevation: half a turn on, it is reached over the top.
  void operator()(const joints::ElevationOfGap& word) {
    const double rise = relative_.d.dot(unit(word.towards));
    const double elevation = std::atan2(rise, relative_.d.cross(unit(word.towards)).norm());
    const double over_the_top = std::numbers::pi - elevation;
    if (has_hint() && distance(over_the_top, hint_(next_)) < distance(elevation, hint_(next_))) {
      q_(bearing_) = with_turns(q_(bearing_) + std::numbers::pi, hint_(bearing_));
      put_turn(over_the_top);
    } else {
      put_turn(elevation);
    }
  }
  void operator()(const joints::ByReading& word) {
    joints::FunctionOfPlacement::Rows rows;
    word.reading->evaluate({relative_.d, relative_.R}, relative_.v_rel, rows);
    for (int k = 0; k < rows.n; ++k) {
      if (word.turns[static_cast<std::size_t>(k)]) {
        put_turn(rows.value(k));
      } else {
        q_(next_++) = rows.value(k);
      }
    }
  }

 private:
  [[nodiscard]] bool has_hint() const { return hint_.size() == q_.size(); }
  /// Between two angles, whole turns apart.
  static double distance(double angle, double other) { return std::abs(with_turns(angle, other) - other); }
  void put_turn(double angle) {
    q_(next_) = has_hint() ? with_turns(angle, hint_(next_)) : angle;
    ++next_;
  }

  const RelativeMotion& relative_;
  const VecX& hint_;
  VecX& q_;
  Eigen::Index next_ = 0;
  Eigen::Index bearing_ = 0;
};

/// Goes through the words of a motion and keeps the axis and the position of each turn: the child's velocity for a unit
/// speed follows when the end is reached.
class Walk {
 public:
  Walk(const joints::JointType& type, const VecX& q) : q_(q), S_(Mat6X::Zero(6, type.n_u())) {
    for (const joints::Permit& word : type.permits) std::visit(*this, word);
    finish();
  }

  void operator()(const joints::Turn& word) {
    turns_.push_back({column_++, frame_ * unit(word.axis), place_});
    frame_ = frame_ * rotation_about(word.axis, q_(next_++));
  }
  void operator()(const joints::Slide& word) {
    const Vec3 along = frame_ * unit(word.axis);
    S_.col(column_++).head<3>() = along;
    place_ += q_(next_++) * along;
  }
  void operator()(const joints::Arm& word) { place_ += word.length * frame_ * unit(word.axis); }
  void operator()(const joints::Ball&) {
    S_.block<3, 3>(3, column_).setIdentity();
    frame_ = rotation_of(q_.segment<4>(next_));
    ends_with_ball_ = true;
  }
  void operator()(const joints::ByMotion& word) {
    joints::FunctionOfCoordinates::Motion motion;
    const VecX at_rest = VecX::Zero(q_.size());
    word.motion->evaluate(q_.data(), at_rest.data(), motion);
    S_ = motion.S.leftCols(S_.cols());
    place_ = motion.placement.d;
    frame_ = motion.placement.R;
  }

  [[nodiscard]] const Mat6X& S() const { return S_; }
  /// Where the motion leads, in the parent's joint frame.
  [[nodiscard]] const Vec3& d() const { return place_; }
  [[nodiscard]] const Mat3& R() const { return frame_; }

 private:
  struct Turned {
    int column;
    Vec3 axis;
    Vec3 place;
  };

  /// A turn before a ball carries the arm's end, but not the child's orientation.
  void finish() {
    for (const Turned& turn : turns_) {
      S_.col(turn.column).head<3>() = turn.axis.cross(place_ - turn.place);
      if (!ends_with_ball_) S_.col(turn.column).tail<3>() = turn.axis;
    }
  }

  const VecX& q_;
  Mat6X S_;
  std::vector<Turned> turns_;
  Vec3 place_ = Vec3::Zero();
  Mat3 frame_ = Mat3::Identity();
  Eigen::Index next_ = 0;
  int column_ = 0;
  bool ends_with_ball_ = false;
};

/// v_rel of what a type permits of velocities alone.
class PermittedSpeed {
 public:
  explicit PermittedSpeed(const Mat3& R) : R_(R) {}

  Vec6 operator()(const joints::SpeedAlong& word) const {
    return (Vec6() << axis(word.axis_of, word.axis), Vec3::Zero()).finished();
  }
  /// The point below d - below e_z rests: ddot + e x (-below e_z) = 0.
  Vec6 operator()(const joints::SpeedAbout& word) const {
    const Vec3 e = axis(word.axis_of, word.axis);
    return (Vec6() << word.below * e.cross(Vec3::UnitZ()), e).finished();
  }

 private:
  [[nodiscard]] Vec3 axis(Side of, Axis axis) const { return of == Side::parent ? unit(axis) : Vec3(R_ * unit(axis)); }

  const Mat3& R_;
};

const joints::ByReading* stated_reading(const joints::JointType& type) {
  for (const joints::Read& word : type.reads) {
    if (const auto* by = std::get_if<joints::ByReading>(&word)) return by;
  }
  return nullptr;
}

/// A length of a joint: the displacement of a turn, or what a slide moves in a radian of its own turn; where neither
/// couples them, the displacement of the motions by radian; 1 if no motion turns.
double own_length(const Mat6X& S, const std::vector<bool>& turning, const Mat6X& motions) {
  double length = 0.0;
  for (Eigen::Index c = 0; c < S.cols(); ++c) {
    const double displacement = S.col(c).head<3>().norm();
    const double rotation = S.col(c).tail<3>().norm();
    const bool turns = turning[static_cast<std::size_t>(c)];
    if (turns) length = std::max(length, displacement);
    if (!turns && rotation > 0.0) length = std::max(length, displacement / rotation);
  }
  for (Eigen::Index c = 0; c < motions.cols() && !(length > 0.0); ++c) {
    const double rotation = motions.col(c).tail<3>().norm();
    if (rotation > 0.0) length = motions.col(c).head<3>().norm() / rotation;
  }
  return length > 0.0 && std::isfinite(length) ? length : 1.0;
}

/// The speeds (n_u x n) with S u nearest to the motions (6 x n), displacements and slides in parts of the joint's own
/// length: in metres and radians, round-off of the larger would reach the smaller.
MatX nearest_speeds(const joints::JointType& type, const Mat6X& S, const Mat6X& motions) {
  const std::vector<bool> turning = turning_speeds(type);
  const double length = own_length(S, turning, motions);
  Mat6X columns = S;
  Mat6X wanted = motions;
  columns.topRows<3>() /= length;
  wanted.topRows<3>() /= length;
  VecX units = VecX::Ones(S.cols());
  for (Eigen::Index c = 0; c < S.cols(); ++c) {
    if (!turning[static_cast<std::size_t>(c)]) units(c) = length;
  }
  const Mat6X by_unit = columns * units.asDiagonal();
  return units.asDiagonal() * least_squares(by_unit, wanted);
}

}  // namespace

MatX free_speeds(const joints::JointType& type, const Mat3& R, const Mat6X& S) {
  if (type.permits_speeds.empty()) return MatX::Identity(S.cols(), S.cols());
  Mat6X possible(6, type.permits_speeds.size());
  for (Eigen::Index k = 0; k < possible.cols(); ++k) {
    possible.col(k) = std::visit(PermittedSpeed(R), type.permits_speeds[static_cast<std::size_t>(k)]);
  }
  return nearest_speeds(type, S, possible);
}

JointMotion read_motion(const joints::JointType& type, const RelativeMotion& relative, const VecX& hint) {
  JointMotion motion;
  motion.q = VecX::Zero(type.n_q());
  Reading reading(relative, hint, motion.q);
  for (const joints::Read& word : type.reads) std::visit(reading, word);
  const Walk walk(type, motion.q);
  motion.S = walk.S();
  motion.d = walk.d();
  motion.R = walk.R();
  motion.free = free_speeds(type, relative.R, motion.S);
  motion.u = motion.S.cols() > 0 ? VecX(nearest_speeds(type, motion.S, relative.v_rel)) : VecX();
  return motion;
}

Mat6X coordinate_wrench_directions(const joints::JointType& type, const RelativeMotion& relative, const Mat6X& S) {
  const joints::ByReading* by_functions = stated_reading(type);
  if (by_functions != nullptr && by_functions->wrenches != nullptr) {
    return by_functions->wrenches({relative.d, relative.R});
  }
  return S;
}

VecX tau_by_laws(const Joint& joint, const std::vector<LawOfForce>& springs, const JointMotion& motion, double t) {
  VecX tau = VecX::Zero(joint.type->n_u());
  for (std::size_t k = 0; k < springs.size(); ++k) {
    const JointSpring& spring = joint.springs[k];
    const int q = first_q(*joint.type, spring.word) + spring.component;
    const int u = first_u(*joint.type, spring.word) + spring.component;
    tau(u) += springs[k].actuator(t) - springs[k].resistance(motion.q(q), motion.u(u));
  }
  for (const Driver& driver : joint.drivers) {
    tau(first_u(*joint.type, driver.word) + driver.component) = std::numeric_limits<double>::quiet_NaN();
  }
  return tau;
}

VecX coupled_tau(const Model& model, int k, const std::vector<double>& forces) {
  const joints::JointType& type = *model.joints[k].type;
  VecX tau = VecX::Zero(type.n_u());
  for (std::size_t c = 0; c < model.couplings.size(); ++c) {
    for (const CouplingTerm& term : model.couplings[c].terms) {
      if (term.joint == k) tau(first_u(type, term.word) + term.component) += term.factor * forces[c];
    }
  }
  return tau;
}

std::vector<bool> turning_speeds(const joints::JointType& type) {
  std::vector<bool> turning;
  for (const joints::Permit& word : type.permits) {
    std::visit(
        Overloaded{[&](const joints::Slide&) { turning.push_back(false); },
                   [&](const joints::ByMotion& by) { turning.insert(turning.end(), by.turns.begin(), by.turns.end()); },
                   [&](const auto&) { turning.insert(turning.end(), static_cast<std::size_t>(n_u(word)), true); }},
        word);
  }
  return turning;
}

std::vector<bool> turning_free_speeds(const joints::JointType& type) {
  if (type.permits_speeds.empty()) return turning_speeds(type);
  std::vector<bool> turning;
  for (const joints::PermitSpeed& word : type.permits_speeds) {
    turning.push_back(std::holds_alternative<joints::SpeedAbout>(word));
  }
  return turning;
}

std::vector<std::string> speed_names(const joints::JointType& type) {
  std::vector<std::string> names;
  for (const NamedCoordinate& coordinate : named_coordinates(type)) {
    if (!std::holds_alternative<joints::Ball>(type.permits[coordinate.word])) {
      names.push_back(coordinate.name);
      continue;
    }
    for (const char* axis : {"_x", "_y", "_z"}) names.push_back(coordinate.name + axis);
  }
  return names;
}

}  // namespace concord::compare
