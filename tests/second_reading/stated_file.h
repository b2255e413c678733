#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tests/second_reading/scope.h"
#include "tests/second_reading/stated_table.h"

namespace concord::second_reading {

/// A file, its place among the files that include it, and those that it includes.
struct StatedFile {
  std::filesystem::path path;
  toml::table root;
  std::string prefix;  // before the names that it defines, those of the including files first
  const StatedFile* outer = nullptr;
  std::unique_ptr<Scope> scope;
  std::unique_ptr<StatedTable> top;
  std::vector<std::unique_ptr<StatedFile>> includes;
  /// For each kind of names: those that it and its includes define, as it says them.
  std::array<std::set<std::string>, kNames> names;

  /// The name in the model of what this file calls `name`.
  [[nodiscard]] std::string full_name(Names kind, const std::string& name) const;
};

/// A file of its own: a model or a modes file, without its includes.
std::unique_ptr<StatedFile> open_file(const std::filesystem::path& path, Ledger& ledger);

/// A model with all that it includes.
std::unique_ptr<StatedFile> open_model(const std::filesystem::path& path, const std::map<std::string, double>& given,
                                       Ledger& ledger);
std::unique_ptr<StatedFile> open_model_text(std::string_view text, const std::filesystem::path& path, Ledger& ledger);

/// The file and those that it includes, in the order in which they are read.
std::vector<const StatedFile*> all_files(const StatedFile& file);

}  // namespace concord::second_reading
