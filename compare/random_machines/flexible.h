#pragma once

#include "compare/random_machines/laws.h"
#include "compare/random_machines/machine.h"
#include "compare/random_machines/random.h"

/// Flexible bodies whose lowest frequencies are a few to some ten in the unit of time.
namespace concord::compare::fuzz {

/// A beam of about this mass, with one to three modes of any support.
Flexible draw_beam(double mass, const Units& units, bool is_aligned, Random& random);

/// Mass points with generic modes, or their integrals, in a modes file.
Flexible draw_modes_file(double mass, const Units& units, Random& random);

}  // namespace concord::compare::fuzz
