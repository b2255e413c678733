#pragma once

#include <optional>

#include "common/laws/force_law.h"
#include "common/reading/toml_reader.h"

namespace concord {

/// Keys of the table of a force law, in which `own` keys may stand too.
KnownKeys with_force_law(KnownKeys own);

/// Reads what resists a coordinate or a length: `stiffness`, `damping`, `free`, `preload`, `spring_table` and
/// `damper_table` = { x, force }, `lower_stop` and `upper_stop` = { at, stiffness, damping, width }, `actuator` (a law
/// of time or a number). Complains of a law that exerts nothing.
ForceLaw read_force_law(const TableReader& table);

}  // namespace concord
