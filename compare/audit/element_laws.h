#pragma once

#include <array>
#include <optional>

#include "common/model.h"
#include "compare/audit/law_of_force.h"
#include "compare/audit/law_of_road.h"
#include "compare/audit/law_of_time.h"
#include "compare/audit/places.h"

namespace concord::compare {

/// What a force element exerts by its law, derived for the third opinion alone from the statement of the element
/// (data/format, common/force_elements.h, common/tire.h). The statement must outlive it.
class ElementLaw {
 public:
  explicit ElementLaw(const ForceElement& stated);

  /// Wrenches in a state: on the parent at P_j and on the child at P_i, global axes [N, N m]. A load and a tire have no
  /// parent: zero there.
  [[nodiscard]] std::array<Wrench, 2> wrenches(const State& state) const;

 private:
  using BothSides = std::array<Wrench, 2>;

  [[nodiscard]] BothSides exerted(const Load& load, const State& state) const;
  [[nodiscard]] BothSides exerted(const LineSpring& spring, const State& state) const;
  [[nodiscard]] BothSides exerted(const TurnSpring& spring, const State& state) const;
  [[nodiscard]] BothSides exerted(const Bushing& bushing, const State& state) const;
  [[nodiscard]] BothSides exerted(const Tire& tire, const State& state) const;
  /// Law and actuator of a spring, positive in tension.
  [[nodiscard]] double tension(double x, double xdot, double t) const;

  const ForceElement* stated_;
  std::optional<LawOfTime> time_;    // of a load
  std::optional<LawOfForce> force_;  // of a spring
  std::optional<LawOfRoad> road_;    // of a tire
};

/// The same of one element in one state.
std::array<Wrench, 2> wrenches_by_laws(const ForceElement& element, const State& state);

}  // namespace concord::compare
