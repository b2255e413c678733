#pragma once

#include "cartesian/body_inertia.h"
#include "cartesian/layout.h"
#include "common/model.h"

/// The machine's units: what is called small or large is so in these.
namespace concord::cartesian {

/// Over Y, one for each number: v by the machine's length L, omega by 1, adot by the size that moves a joint by L
/// (C44).
VecX machine_units(const Model& model, const Layout& layout);

/// kappa of (C48) [s^2]: a million over the smallest K_kk / M_kk of modes that have a stiffness; kappa K is added to
/// the modal mass when positions are projected. 0 without stiffness.
double stiffening_of(const BodyInertia& inertia);

/// How much less a step of positions moves a mode than a coordinate without stiffness, at most 1.
double compliance_of(const BodyInertia& inertia, int mode);

}  // namespace concord::cartesian
