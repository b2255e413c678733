#pragma once

#include "common/model.h"
#include "tests/second_reading/stated_table.h"

namespace concord::second_reading {

/// What `[[body]]` states.
void hold_body(const Body& body, const StatedTable& table);

/// What `[body.beam]` states, against the statement that the modes were computed from.
void hold_beam(const ModalData& modal, const StatedTable& table);

/// What a modes file states.
void hold_modes_file(const Body& body, const StatedTable& table);

/// Six numbers xx, yy, zz, xy, xz, yz, or the first three of them, as a tensor.
Mat3 tensor_of(const std::vector<double>& numbers);

}  // namespace concord::second_reading
