#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/laws/road.h"
#include "common/reading/toml_reader.h"

namespace concord {

/// A road as far as it could be read.
struct RoadReading {
  std::string name;
  std::shared_ptr<const Road> road;  // nothing after a complaint
};

/// The `[[road]]` tables of a file.
std::vector<RoadReading> read_roads(const TableReader& document);

}  // namespace concord
