#pragma once

#include "common/model.h"
#include "common/reading/toml_reader.h"

namespace concord {

/// A body as far as it could be read.
struct BodyReading {
  Body body;
  bool is_flexible = false;
  /// The inertia could be read; if not, what depends on it (nodes) is not complained about again.
  bool is_usable = false;
};

/// Reads one `[[body]]`: a rigid one (mass, center_of_mass, inertia), a beam, or a modes file.
BodyReading read_body(const toml::table& table, FileReading& reading);

}  // namespace concord
