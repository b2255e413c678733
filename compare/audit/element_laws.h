#pragma once

#include <array>
#include <optional>

#include "common/model.h"
#include "compare/audit/law_of_force.h"
#include "compare/audit/law_of_road.h"
#include "compare/audit/law_of_time.h"
#include "compare/audit/places.h"

namespace concord::compare {

/// Along the line of a spring, from the parent's end to the child's. Where both are in one point, they are about to
/// part along their velocity, if they move at all.
struct LineMotion {
  double distance = 0.0;  // m
  double rate = 0.0;      // m/s
  Vec3 along = Vec3::Zero();
};
LineMotion motion_of(const LineSpring& spring, const State& state);

/// The angle of a turn spring, of those that are whole turns apart the one nearest to a known one [rad]; a turn rho of
/// the child's end against the parent's changes it by gradient . rho, global axes.
struct TurnMotion {
  double angle = 0.0;  // rad
  double rate = 0.0;   // rad/s
  Vec3 gradient = Vec3::Zero();
};
TurnMotion motion_of(const TurnSpring& spring, const State& state, double known_angle);

/// The laws that an element states, as the audit evaluates them by itself.
struct OwnLaws {
  std::optional<LawOfTime> time;    // of a load
  std::optional<LawOfForce> force;  // of a spring
  std::optional<LawOfRoad> road;    // of a tire

  /// Law and actuator of a spring, positive in tension.
  [[nodiscard]] double tension(double x, double xdot, double t) const;
};

/// What a force element exerts by its law, derived for the third opinion alone from the statement of the element
/// (data/format, common/elements). The statement must outlive it.
class ElementLaw {
 public:
  /// `place` is that among the elements of the model, by which a state tells the turns of turn springs.
  ElementLaw(const ForceElement& stated, std::size_t place);

  /// Wrenches in a state: on the parent at P_j and on the child at P_i, global axes [N, N m]. A load and a tire have no
  /// parent: zero there.
  [[nodiscard]] std::array<Wrench, 2> wrenches(const State& state) const;

 private:
  const ForceElement* stated_;
  std::size_t place_;
  OwnLaws laws_;
};

/// The same of one element in one state.
std::array<Wrench, 2> wrenches_by_laws(const ForceElement& element, const State& state, std::size_t place);

}  // namespace concord::compare
