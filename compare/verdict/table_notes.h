#pragma once

#include <string>
#include <vector>

#include "common/model.h"

namespace concord::compare {

/// A sentence for each table of force whose cubic leaves, between two points, the range of their forces by more than a
/// twentieth of the table's range: the law is what the model says, but seldom what was meant.
std::vector<std::string> notes_on_tables(const Model& model);

}  // namespace concord::compare
