#pragma once

#include <string>
#include <vector>

#include "common/model.h"

namespace concord::compare {

/// A sentence for each table whose cubic leaves, between two points, the range of their values by more than a twentieth
/// of the table's range (of force over a stretch or a rate) or by half of it (of time, up to `until` [s], and roads):
/// the law is what the model says, but seldom what was meant. One, too, for each spline of time that ends before then.
std::vector<std::string> notes_on_tables(const Model& model, double until);

}  // namespace concord::compare
