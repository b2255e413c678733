#pragma once

#include <optional>

#include "common/flexible/beam.h"
#include "common/reading/toml_reader.h"

namespace concord {

/// Reads a body's `beam` table and makes the beam. Nothing after a complaint.
std::optional<ModalData> read_beam(const toml::table& table, const std::string& body, FileReading& reading);

}  // namespace concord
