#include "compare/audit/carried_components.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/decompositions.h"
#include "compare/audit/referee.h"

namespace concord::compare {

namespace {

using joints::JointType;

/// Reach of a coordinate to both sides where its word states none [rad, m; Euler parameters].
double reach_of(joints::CoordinateKind kind) {
  switch (kind) {
    case joints::CoordinateKind::angle:
      return std::numbers::pi;
    case joints::CoordinateKind::length:
      return 0.4;
    case joints::CoordinateKind::orientation:
      return 1.0;
  }
  return 0.0;
}

/// Coordinates of pose `number` of a sequence that fills all ranges evenly and in general position: multiples of the
/// square roots of primes, modulo one (Weyl).
VecX coordinates_of(const JointType& type, int number) {
  constexpr std::array kPrimes{2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0};
  VecX q(type.n_q());
  Eigen::Index next = 0;
  for (const joints::Permit& word : type.permits) {
    for (const joints::StatedCoordinate& one : stated_coordinates(word)) {
      const double reach = reach_of(one.kind);
      const auto [least, greatest] = one.range.value_or(std::array{-reach, reach});
      const Eigen::Index first = next;
      for (; next < first + n_q(one.kind); ++next) {
        const double multiple = (number + 1.0) * std::sqrt(kPrimes[static_cast<std::size_t>(next) % kPrimes.size()]);
        q(next) = least + (greatest - least) * (multiple - std::floor(multiple));
      }
      if (one.kind == joints::CoordinateKind::orientation) q.segment<4>(first).normalize();
    }
  }
  return q;
}

/// The child's velocity [ddot; omega_rel] where its side of the joint turns about, or moves along, an axis of that
/// side's frame as the component says: the reaction has the power of that component.
Vec6 direction_of(const joints::Placement& at, Side side, int component) {
  const Vec3 axis = side == Side::parent ? Vec3(Vec3::Unit(component % 3)) : Vec3(at.R.col(component % 3));
  Vec6 direction = Vec6::Zero();
  if (component < 3) {
    direction.head<3>() = axis;
  } else {
    // On the parent the torque is taken at P_j, about which the child's point goes round.
    if (side == Side::parent) direction.head<3>() = axis.cross(at.d);
    direction.tail<3>() = axis;
  }
  return direction;
}

/// Whether the direction lies in the span of what the type permits at the coordinates q.
bool is_permitted(const JointType& type, const VecX& q, Side side, int component) {
  constexpr double kDependent = 1e-10;  // of the largest pivot, columns of unit size
  constexpr double kOutside = 1e-9;     // of a direction of unit size
  const RefereedMotion motion = referee_motion(type, q);
  Mat6X permitted = motion.S;
  if (!type.permits_speeds.empty()) {
    permitted.resize(6, 0);
    for (const joints::PermitSpeed& word : type.permits_speeds) {
      permitted.conservativeResize(6, permitted.cols() + 1);
      permitted.rightCols<1>() = referee_permitted_speed(word, motion.placement.R);
    }
  }
  if (permitted.cols() == 0) return false;
  Vec6 direction = direction_of(motion.placement, side, component);
  const double length = motion.placement.d.norm();
  if (length > 0.0) {
    permitted.topRows<3>() /= length;
    direction.head<3>() /= length;
  }
  for (auto column : permitted.colwise()) column.normalize();
  direction.normalize();
  return (direction - permitted * smallest_least_squares(permitted, direction, kDependent)).norm() <= kOutside;
}

/// What a motion in words permits is analytic in its coordinates: what holds at one pose in general position holds at
/// all. A function may be given in pieces.
int poses_to_ask(const JointType& type) {
  const auto is_function = [](const joints::Permit& word) { return joints::function_of(word) != nullptr; };
  return std::any_of(type.permits.begin(), type.permits.end(), is_function) ? 64 : 1;
}

}  // namespace

bool carries(const JointType& type, Side side, int component) {
  for (int number = 0; number < poses_to_ask(type); ++number) {
    if (!is_permitted(type, coordinates_of(type, number), side, component)) return true;
  }
  return false;
}

CarriedComponents carried_components(const JointType& type) {
  CarriedComponents carried{};
  for (const Side side : kSides) {
    for (int component = 0; component < 6; ++component) {
      carried[index(side)][component] = carries(type, side, component);
    }
  }
  return carried;
}

}  // namespace concord::compare
