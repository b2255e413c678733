#include "compare/audit/joint_motion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/joints/named_coordinates.h"
#include "compare/audit/referee.h"

namespace concord::compare {

namespace {

/// The angle that differs from `angle` by whole turns and is nearest to `near`.
double with_turns(double angle, double near) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  return angle + kTurn * std::round((near - angle) / kTurn);
}

/// Reads the coordinates of a motion one after the other.
class CoordinateReading {
 public:
  CoordinateReading(const RelativeMotion& relative, const VecX& hint, VecX& q)
      : relative_(relative), hint_(hint), q_(q) {}

  void read(const joints::Read& word) {
    if (const joints::FunctionOfPlacement* function = function_of(word)) {
      read_functions(*function, kinds_of(word));
    } else if (is_elevation(word)) {
      put_elevation(referee_reading(word, placement()));
    } else {
      read_one(word);
    }
  }

 private:
  [[nodiscard]] joints::Placement placement() const { return {relative_.d, relative_.R}; }
  [[nodiscard]] bool has_hint() const { return hint_.size() == q_.size(); }
  /// Between two angles, whole turns apart.
  static double distance(double angle, double other) { return std::abs(with_turns(angle, other) - other); }

  void read_one(const joints::Read& word) {
    switch (kind_of(word, 0)) {
      case joints::CoordinateKind::angle:
        put_turn(referee_reading(word, placement()));
        break;
      case joints::CoordinateKind::length:
        q_(next_++) = referee_reading(word, placement());
        break;
      case joints::CoordinateKind::orientation:
        put_orientation();
        break;
    }
  }
  void read_functions(const joints::FunctionOfPlacement& function, const joints::CoordinateKinds& kinds) {
    joints::FunctionOfPlacement::Rows rows;
    function.evaluate(placement(), relative_.v_rel, rows);
    for (int k = 0; k < rows.n; ++k) {
      if (kinds[k] == joints::CoordinateKind::angle) {
        put_turn(rows.value(k));
      } else {
        q_(next_++) = rows.value(k);
      }
    }
  }
  void put_orientation() {
    const Eigen::Quaterniond turned(relative_.R);
    q_.segment<4>(next_) << turned.w(), turned.vec();
    next_ += 4;
  }
  /// A direction has two pairs of bearing and elevation: half a turn on, it is reached over the top.
  void put_elevation(double elevation) {
    const double over_the_top = std::numbers::pi - elevation;
    if (has_hint() && distance(over_the_top, hint_(next_)) < distance(elevation, hint_(next_))) {
      q_(next_ - 1) = with_turns(q_(next_ - 1) + std::numbers::pi, hint_(next_ - 1));
      put_turn(over_the_top);
    } else {
      put_turn(elevation);
    }
  }
  void put_turn(double angle) {
    q_(next_) = has_hint() ? with_turns(angle, hint_(next_)) : angle;
    ++next_;
  }

  const RelativeMotion& relative_;
  const VecX& hint_;
  VecX& q_;
  Eigen::Index next_ = 0;
};

/// A length of a joint: the displacement of a turn, or what a slide moves in a radian of its own turn; where neither
/// couples them, the displacement of the motions by radian; 1 if no motion turns.
double own_length(const SpeedColumns& S, const std::vector<bool>& turning, const SpeedColumns& motions) {
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
SpeedMatrix nearest_speeds(const joints::JointType& type, const SpeedColumns& S, const SpeedColumns& motions) {
  const std::vector<bool> turning = turning_speeds(type);
  const double length = own_length(S, turning, motions);
  SpeedColumns columns = S;
  SpeedColumns wanted = motions;
  columns.topRows<3>() /= length;
  wanted.topRows<3>() /= length;
  SpeedVector units = SpeedVector::Ones(S.cols());
  for (Eigen::Index c = 0; c < S.cols(); ++c) {
    if (!turning[static_cast<std::size_t>(c)]) units(c) = length;
  }
  const SpeedColumns by_unit = columns * units.asDiagonal();
  return units.asDiagonal() * nearest_combination(by_unit, wanted);
}

/// Calls `use` with the speed, the actuator's force, and the resistance of each spring at rest and at its rate.
template <class Use>
void for_each_spring(const Joint& joint, const std::vector<LawOfForce>& springs, const JointMotion& motion, double t,
                     const Use& use) {
  for (std::size_t k = 0; k < springs.size(); ++k) {
    const JointSpring& spring = joint.springs[k];
    const int q = first_q(*joint.type, spring.word) + spring.component;
    const int u = first_u(*joint.type, spring.word) + spring.component;
    use(u, springs[k].actuator(t), springs[k].resistance(motion.q(q), 0.0),
        springs[k].resistance(motion.q(q), motion.u(u)));
  }
}

}  // namespace

SpeedMatrix free_speeds(const joints::JointType& type, const Mat3& R, const SpeedColumns& S) {
  if (type.permits_speeds.empty()) return SpeedMatrix::Identity(S.cols(), S.cols());
  SpeedColumns possible(6, type.permits_speeds.size());
  for (Eigen::Index k = 0; k < possible.cols(); ++k) {
    possible.col(k) = referee_permitted_speed(type.permits_speeds[static_cast<std::size_t>(k)], R);
  }
  return nearest_speeds(type, S, possible);
}

RelativeMotion relative_motion_of(const Joint& joint, const State& state) {
  const auto at = [&](Side side) {
    const Attachment& end = joint.on(side);
    return place(end, state.bodies[static_cast<std::size_t>(end.body)]);
  };
  return relative_motion(at(Side::parent), at(Side::child));
}

JointMotion read_motion(const joints::JointType& type, const RelativeMotion& relative, const VecX& hint) {
  JointMotion motion = read_pose(type, relative, hint);
  if (motion.S.cols() > 0) motion.u = nearest_speeds(type, motion.S, relative.v_rel);
  return motion;
}

JointMotion read_pose(const joints::JointType& type, const RelativeMotion& relative, const VecX& hint) {
  JointMotion motion;
  motion.q = VecX::Zero(type.n_q());
  CoordinateReading reading(relative, hint, motion.q);
  for (const joints::Read& word : type.reads) reading.read(word);
  const RefereedMotion refereed = referee_motion(type, motion.q);
  motion.S = refereed.S;
  motion.d = refereed.placement.d;
  motion.R = refereed.placement.R;
  motion.free = free_speeds(type, relative.R, motion.S);
  return motion;
}

Mat6X coordinate_wrench_directions(const joints::JointType& type, const RelativeMotion& relative, const Mat6X& S) {
  return referee_wrench_directions(type, {relative.d, relative.R}, S);
}

std::vector<LawOfForce> laws_of_springs(const Joint& joint) {
  std::vector<LawOfForce> laws;
  for (const JointSpring& spring : joint.springs) laws.emplace_back(spring.law);
  return laws;
}

std::array<VecX, kActors.size()> shares_by_laws(const Joint& joint, const std::vector<LawOfForce>& springs,
                                                const JointMotion& motion, double t) {
  std::array<VecX, kActors.size()> shares;
  shares.fill(VecX::Zero(joint.type->n_u()));
  for_each_spring(joint, springs, motion, t, [&](int u, double actuator, double at_rest, double resistance) {
    shares[index(Actor::motor)](u) += actuator;
    shares[index(Actor::spring)](u) -= at_rest;
    shares[index(Actor::damper)](u) -= resistance - at_rest;
  });
  return shares;
}

VecX tau_by_laws(const Joint& joint, const std::vector<LawOfForce>& springs, const JointMotion& motion, double t) {
  VecX tau = VecX::Zero(joint.type->n_u());
  for (const VecX& share : shares_by_laws(joint, springs, motion, t)) tau += share;
  for (const Driver& driver : joint.drivers) {
    tau(first_u(*joint.type, driver.word) + driver.component) = std::numeric_limits<double>::quiet_NaN();
  }
  return tau;
}

VecX sizes_of_springs(const Joint& joint, const std::vector<LawOfForce>& springs, const JointMotion& motion, double t) {
  VecX sizes = VecX::Zero(joint.type->n_u());
  for_each_spring(joint, springs, motion, t, [&](int u, double actuator, double /*at_rest*/, double resistance) {
    sizes(u) += std::abs(actuator) + std::abs(resistance);
  });
  return sizes;
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
    for (const joints::StatedCoordinate& one : stated_coordinates(word)) {
      const auto n = static_cast<std::size_t>(joints::n_u(one.kind));
      turning.insert(turning.end(), n, one.kind != joints::CoordinateKind::length);
    }
  }
  return turning;
}

std::vector<bool> turning_free_speeds(const joints::JointType& type) {
  if (type.permits_speeds.empty()) return turning_speeds(type);
  std::vector<bool> turning;
  for (const joints::PermitSpeed& word : type.permits_speeds) {
    turning.push_back(kind_of(word) != joints::CoordinateKind::length);
  }
  return turning;
}

std::vector<std::string> speed_names(const joints::JointType& type) {
  std::vector<std::string> names;
  for (const NamedCoordinate& coordinate : named_coordinates(type)) {
    if (coordinate.kind != joints::CoordinateKind::orientation) {
      names.push_back(coordinate.name);
      continue;
    }
    for (const char* axis : {"_x", "_y", "_z"}) names.push_back(coordinate.name + axis);
  }
  return names;
}

}  // namespace concord::compare
