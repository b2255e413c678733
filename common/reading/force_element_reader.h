#pragma once

#include <vector>

#include "common/elements/force_element.h"
#include "common/reading/body_reader.h"
#include "common/reading/road_reader.h"
#include "common/reading/toml_reader.h"

namespace concord {

/// Names of the top-level tables that state force elements: "load", "line_spring" and so on.
const KnownKeys& force_element_keys();

/// All force elements of a document between the bodies (ground first) and on the roads, in the order of the file. Those
/// whose bodies or road are not known are left out, after a complaint.
std::vector<ForceElement> read_force_elements(const TableReader& document, const std::vector<BodyReading>& bodies,
                                              const std::vector<RoadReading>& roads);

}  // namespace concord
