#pragma once

#include "cartesian/body_inertia.h"
#include "cartesian/layout.h"
#include "common/model.h"

/// The machine's units: what is called small or large is so in these.
namespace concord::cartesian {

/// Over Y, one for each number: v by the machine's length L, omega by 1, adot by the size that moves a joint by L
/// (C44).
VecX machine_units(const Model& model, const Layout& layout);

/// The time squared in which a body's modes, the slowest that has a stiffness too, resist steps of positions as if they
/// were a million times heavier [s^2]; 0 without stiffness.
double stiffening_of(const BodyInertia& inertia);

/// How much less a step of positions moves a mode than a coordinate without stiffness, at most 1.
double compliance_of(const BodyInertia& inertia, int mode);

}  // namespace concord::cartesian
