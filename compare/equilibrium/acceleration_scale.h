#pragma once

#include <algorithm>
#include <limits>

#include "common/model.h"
#include "common/results.h"
#include "compare/states/chart.h"

/// What forces cause in a machine: the scale of all that analyses decide about accelerations.
namespace concord::compare {

/// Accelerations that the machine's forces cause in a state [1/s2]: the largest of gravity and of the sum of forces on
/// a body per mass (a torque counts as its force at the machine's length), over the machine's length.
double reference_acceleration(const Model& model, const State& state, const Evaluation& evaluation);

/// What decisions about accelerations are held against.
struct AccelerationScale {
  double reference = 0.0;  // what forces cause [1/s2]
  /// What the terms of springs would cause, which cancel where a machine rests at the free lengths of its springs
  /// [1/s2].
  double terms = 0.0;
  /// The same in each coordinate of the chart: a spring says nothing of motions that it does not see.
  VecX terms_in_coordinates = {};

  /// What double precision leaves open of an acceleration, however small the forces are.
  [[nodiscard]] double unresolved() const { return 2.0 * std::numeric_limits<double>::epsilon() * terms; }
  [[nodiscard]] double unresolved_along(const VecX& direction) const {
    if (terms_in_coordinates.size() == 0) return 0.0;
    return 2.0 * std::numeric_limits<double>::epsilon() * direction.cwiseAbs().dot(terms_in_coordinates);
  }
  [[nodiscard]] double resolved_reference() const { return std::max(reference, unresolved()); }
};

/// The reference where forces on a body, and the terms of springs, are held against its apparent inertia, which its
/// neighbours share: a light pin that heavy bodies hold is not moved as if it were alone. The chart is that of the
/// state.
AccelerationScale acceleration_scale(const Model& model, const Chart& chart, const State& state,
                                     const Evaluation& evaluation);

}  // namespace concord::compare
