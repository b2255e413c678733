#pragma once

#include <optional>

#include "common/laws/force_law.h"
#include "compare/audit/law_of_time.h"

namespace concord::compare {

/// How much of its stiffness a stop has when it is pressed by the part z of its width.
double share_of(double z);

/// A force law as the third opinion evaluates it, from its statement in data/format alone. The statement must
/// outlive it.
class LawOfForce {
 public:
  explicit LawOfForce(const ForceLaw& stated);

  /// What resists the growth of x [m or rad] at the rate xdot, without the actuator [N or N m]: preload, straight
  /// spring and damper, tables, stops.
  [[nodiscard]] double resistance(double x, double xdot) const;
  /// Force of the actuator at time t [s].
  [[nodiscard]] double actuator(double t) const { return actuator_ ? actuator_->at(t).value : 0.0; }

 private:
  const ForceLaw* stated_;
  std::optional<Spline> spring_;
  std::optional<Spline> damper_;
  std::optional<LawOfTime> actuator_;
};

}  // namespace concord::compare
