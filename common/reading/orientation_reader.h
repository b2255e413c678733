#pragma once

#include <optional>

#include "common/reading/toml_reader.h"
#include "common/types.h"

namespace concord {

/// `own` keys, and those that say an orientation.
KnownKeys with_orientation(KnownKeys own);

/// Whether the table says an orientation at all.
bool says_orientation(const TableReader& table);

/// The orientation that a table says: a rotation whose columns are the axes of the described frame, in the axes of the
/// frame it is described in. One of
///   two of `x`, `y`, `z`: axes of the described frame, perpendicular to less than 1e-6 rad, any length (z, or else x,
///                         is kept exactly in direction, and a note tells by how much the other one was turned);
///   `axis`, `angle`: turned by an angle [rad] about an axis;
///   `sequence`, `angles`: turned about its own axes one after the other, "zxz" and three angles [rad];
///   `rotation_vector`: axis times angle [rad];
///   `euler_parameters`: scalar first, any length.
/// The identity if none is said; nothing after a complaint.
std::optional<Mat3> read_orientation(const TableReader& table);

}  // namespace concord
