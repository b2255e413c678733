#pragma once

#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/reading/toml_reader.h"

/// The files that a model is written in: the model file, and what it includes.
namespace concord {

/// One file of a model, once for each time that it is included.
struct ModelPart {
  FileReading reading;
  toml::table root;
  std::optional<TableReader> document;  // always there once read
  /// "\n  included from car.toml:12:1", a line for each level; empty for the model file.
  std::string included_from;
};

/// A deque: the readers point into their parts.
using ModelParts = std::deque<ModelPart>;

/// Reads the model file, first, and the files that it includes, each after the file that includes it. `known` are the
/// keys that a file may have beside `format`, `parameters` and `include`. Each part's reading has its parameters, its
/// prefix and its own names. `parameters` replace those of the model file that have their names. Throws InputError
/// where the grammar of the model file is broken; whatever else is wrong is complained of in the readings.
ModelParts read_model_parts(std::string_view text, const std::filesystem::path& file, KnownKeys known,
                            const std::vector<ParameterDefinition>& parameters = {});

/// Throws InputError with the complaints of all parts, if there are any: part by part, each in the order of its file.
/// What is wrong in a file that is included more than once is reported once.
void throw_if_any(const ModelParts& parts);

/// The name of a table, as the file has it, and where it stands.
struct NamedPlace {
  std::string name;
  SourceLocation where;
};

/// The names in the tables of `[[kind]]`; tables without a proper name are left out.
std::vector<NamedPlace> names_in(const ModelPart& part, std::string_view kind);

}  // namespace concord
