#pragma once

#include <toml++/toml.h>

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.h"
#include "common/reading/expression.h"

/// A file that is being read: its parameters, its names, and what is wrong with it.
namespace concord {

/// What all readers of one file share.
struct FileReading {
  std::string file;
  std::string text;
  Parameters parameters;
  std::vector<Diagnostic> complaints;
  /// What was put right.
  std::vector<Diagnostic> notes;
  /// What stands in the model before the names that an included file defines; empty for the model file.
  std::string prefix;
  /// Names that the file, or a file that it includes, defines, as this file spells them: for "body", "joint", "road".
  std::map<std::string, std::set<std::string>, std::less<>> own_names;
  /// The file that includes this one; nullptr for the model file.
  const FileReading* includer = nullptr;

  /// The name in the model of what the file refers to as `name`: its own has the prefix, any other is the includer's.
  [[nodiscard]] std::string name_in_model(std::string_view kind, const std::string& name) const;
  /// How the file refers to what the model calls `name`.
  [[nodiscard]] std::string name_in_file(std::string_view kind, const std::string& name) const;
  [[nodiscard]] bool defines(std::string_view kind, const std::string& name) const;

  /// The word of the text that stands there, up to a blank, comma, bracket or comment.
  [[nodiscard]] std::string word_at(const toml::source_region& region) const;
  [[nodiscard]] SourceLocation at(const toml::source_region& region) const;
  /// Throws InputError with all complaints when they become too many to be read.
  void complain(const SourceLocation& where, std::string message);

  /// All complaints in the order of the file.
  [[nodiscard]] std::vector<Diagnostic> sorted_complaints() const;
  /// Throws InputError with these, if there are any.
  void throw_if_any() const;
};

}  // namespace concord
