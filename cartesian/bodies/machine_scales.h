#pragma once

#include "cartesian/bodies/body_inertia.h"
#include "cartesian/bodies/indices.h"
#include "cartesian/bodies/layout.h"
#include "common/model.h"

namespace concord::cartesian {

/// How large a machine is, whatever its state: what is called small or large is so in these lengths, masses and times
/// (C44).
/// Rows are measured over these units (Equations::row_sizes), states in state_scales.
struct MachineScales {
  MachineScales(const Model& model, const Layout& layout, const ByBody<BodyInertia>& inertias);

  double length;  // L [m]
  double mass;    // of all bodies [kg]
  /// The largest rate at which a driver moves its coordinate, at any time, over the length or a radian [1/s]; zero
  /// without drivers. What a machine that its drivers have brought to rest is measured by.
  double driven_rate;
  /// Over Y, one for each number: v by L, omega by 1, adot by the size that moves a joint by L (C44).
  VecX units;
  /// The same of displacements: modes by as much less as their stiffness asks, at least a ten-thousandth.
  VecX displacements;
  /// kappa of (C48) [s^2]: a million over the smallest K_kk / M_kk of modes that have a stiffness; kappa K is added to
  /// the modal mass when positions are projected. 0 without stiffness.
  ByBody<double> stiffening;
};

/// MachineScales::driven_rate.
double rate_of_drivers(const Model& model);

}  // namespace concord::cartesian
