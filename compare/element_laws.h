#pragma once

#include <array>

#include "common/model.h"
#include "compare/places.h"

namespace concord::compare {

/// What a force element exerts by its law in a state: on the parent at P_j and on the child at P_i, global axes
/// [N, N m]. Derived for the third opinion alone, from the statement of the element (common/force_elements.h). A load
/// and a tire have no parent: zero there.
std::array<Wrench, 2> lawful_wrenches(const ForceElement& element, const State& state);

}  // namespace concord::compare
