#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/model.h"

namespace concord {

/// Reads a model file (TOML, `format = 1`; data/README.md explains it). Throws InputError with every complaint about
/// the file, each at its line and column.
Model read_model(const std::filesystem::path& file);

/// The same with other values of parameters that the file itself defines; of another name it complains.
Model read_model(const std::filesystem::path& file, const std::map<std::string, double>& parameters);

/// The same from text; `file` names it in messages and is the base of the paths that it mentions.
Model parse_model(std::string_view text, const std::filesystem::path& file);

/// The files that reading a model opens: itself, what it includes and its modes files. Of a file that is no model,
/// itself and what could be read of it.
std::vector<std::filesystem::path> files_of_model(const std::filesystem::path& file);

}  // namespace concord
