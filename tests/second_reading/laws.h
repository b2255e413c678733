#pragma once

#include <string>

#include "common/model.h"
#include "tests/second_reading/stated_table.h"

namespace concord::second_reading {

/// The law of time under a key of a table: a table, or a number that means a constant.
void hold_law_of_time(const TimeFunction& law, const StatedTable& table, const std::string& key);

/// The keys of a force law, which stand in the table among others.
void hold_force_law(const ForceLaw& law, const StatedTable& table);

/// What `[[load]]`, `[[line_spring]]`, `[[turn_spring]]`, `[[bushing]]` and `[[tire]]` state. The kind is the name of
/// the table.
void hold_element(const Model& model, const ForceElement& element, const StatedTable& table, const std::string& kind);

/// What `[[road]]` states.
void hold_road(const Road& road, const StatedTable& table);

}  // namespace concord::second_reading
