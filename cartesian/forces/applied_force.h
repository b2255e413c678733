#pragma once

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "cartesian/bodies/indices.h"
#include "cartesian/bodies/joint_rows.h"
#include "cartesian/bodies/marker_kinematics.h"
#include "common/model.h"
#include "common/results.h"

namespace concord::cartesian {

/// Whose forces an applied force's are.
struct OfElement {
  ElementIndex element;
};
struct OfSprings {
  JointIndex joint;
};

/// A force element, or the springs of one joint, in the current state: its ends on two bodies (of a load: on one, the
/// child), its wrenches and its regimes.
struct AppliedForce {
  std::variant<OfElement, OfSprings> owner;
  std::array<const Attachment*, 2> ends{nullptr, nullptr};
  std::array<Marker, 2> markers;  // of an element; a joint has its own
  RelativeMotion motion;          // of an element: the child's end seen from the parent's
  TireRegime regime;              // of a tire
  /// Of the stops of a spring, or of each spring of a joint in its order.
  std::vector<LawRegime> stop_regimes;
  int n_event_functions = 0;  // none: it has no regimes
  /// Wrenches at the ends, global axes, and their generalized forces (C12) on the ends' bodies, 6 + m numbers (none on
  /// ground).
  std::array<Wrench, 2> wrenches;
  std::array<VecX, 2> forces;
  /// Of a joint's springs: coordinate forces (n_u numbers), whether each spring's coordinate is an angle known but for
  /// full turns, and the angles that the last known turns are counted from.
  VecX tau;
  std::vector<bool> spring_turns;
  VecX known_q;
  /// Of a turn spring: the angle that its turns are counted from.
  double known_angle = kUnwound;

  /// The joint whose springs push; nothing for an element.
  [[nodiscard]] std::optional<JointIndex> joint() const {
    const auto* springs = std::get_if<OfSprings>(&owner);
    return springs != nullptr ? std::optional(springs->joint) : std::nullopt;
  }
  [[nodiscard]] bool sits_on_moving_body(Side side) const {
    return ends[index(side)] != nullptr && !is_ground(body(side));
  }
  /// The body that an end sits on.
  [[nodiscard]] BodyIndex body(Side side) const { return body_of(*ends[index(side)]); }
  [[nodiscard]] const Marker& child() const { return markers[index(Side::child)]; }
  [[nodiscard]] const Marker& parent() const { return markers[index(Side::parent)]; }
  [[nodiscard]] Wrench& on_child() { return wrenches[index(Side::child)]; }
  [[nodiscard]] Wrench& on_parent() { return wrenches[index(Side::parent)]; }
};

/// The opposite wrench on the parent at P_j, `gap` = r_Pi - r_Pj.
Wrench opposite(const Wrench& on_child, const Vec3& gap);

/// Whether tires and stops take the regime that they are in by themselves, or keep what the applied force has.
enum class Regimes { own, kept };

/// Where and when an element's force is asked for.
struct ForceInstant {
  const std::string& name;  // of the element
  double t;
  const Mat3& A_child;   // rotation of the child's body
  double shortest_line;  // that has a direction [m]
  Regimes regimes;
};

}  // namespace concord::cartesian
