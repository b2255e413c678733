#pragma once

#include <toml++/toml.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.h"
#include "common/reading/expression.h"
#include "common/types.h"

/// A typed reader over toml++: every reading that fails leaves a complaint and goes on, so that all errors of a file
/// are reported together.
namespace concord {

/// What all readers of one file share.
struct FileReading {
  std::string file;
  Parameters parameters;
  std::vector<Diagnostic> complaints;
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

  [[nodiscard]] SourceLocation at(const toml::source_region& region) const;
  /// Throws InputError with all complaints when they become too many to be read.
  void complain(const SourceLocation& where, std::string message);

  /// All complaints in the order of the file.
  [[nodiscard]] std::vector<Diagnostic> sorted_complaints() const;
  /// Throws InputError with these, if there are any.
  void throw_if_any() const;
};

/// The document; throws InputError where TOML's own grammar is broken, and where it is nested deeper or holds more
/// values than any model needs: such a document would use up stack or memory.
toml::table parse_toml(std::string_view text, const std::string& file);

/// Keys that a table may have.
using KnownKeys = std::vector<std::string_view>;

/// One table of a file. Each reading returns nothing if the key is missing, or if its value is wrong: then it has
/// reported at the value's location. Numbers may be expressions of the parameters, and are zero or of a usable size
/// (common/magnitude.h).
class TableReader {
 public:
  /// `title` opens every message about the table ("joint 'A'"; may be empty). Complains of keys that are not known.
  TableReader(const toml::table& table, std::string title, const KnownKeys& known, FileReading& reading);

  [[nodiscard]] const std::string& title() const { return title_; }
  [[nodiscard]] FileReading& reading() const { return *reading_; }
  [[nodiscard]] bool has(std::string_view key) const;
  /// Place of the key's value; of the table if it is missing.
  [[nodiscard]] SourceLocation where(std::string_view key = {}) const;

  /// Complains of every one of the keys that is missing; true if all are there.
  bool require(const KnownKeys& keys) const;
  /// Complains unless exactly one of the keys is there; true then.
  bool require_one_of(const KnownKeys& keys) const;

  [[nodiscard]] std::optional<double> number(std::string_view key) const;
  [[nodiscard]] std::optional<double> positive_number(std::string_view key) const;
  [[nodiscard]] std::optional<double> number_not_negative(std::string_view key) const;
  /// A whole number of at least `smallest` and at most `largest`.
  [[nodiscard]] std::optional<int> count(std::string_view key, int smallest, int largest = 1000000000) const;
  [[nodiscard]] std::optional<std::string> text(std::string_view key) const;
  /// The text of `name`, which must be there and not be empty, after the file's prefix; empty after a complaint.
  [[nodiscard]] std::string name() const;
  /// Complains of a text, the whole of a name or a part of one, that a file's name cannot hold.
  void require_fit_for_files(std::string_view key, const std::string& value) const;
  [[nodiscard]] std::optional<bool> flag(std::string_view key) const;
  /// A list of numbers; of `length` numbers if that is not negative.
  [[nodiscard]] std::optional<std::vector<double>> numbers(std::string_view key, int length = -1) const;
  [[nodiscard]] std::optional<VecX> vector(std::string_view key, int length) const;
  [[nodiscard]] std::optional<Vec3> vector3(std::string_view key) const;
  /// A vector of three that is not zero, brought to unit length.
  [[nodiscard]] std::optional<Vec3> direction(std::string_view key) const;
  /// A list of `rows` lists of `columns` numbers.
  [[nodiscard]] std::optional<MatX> matrix(std::string_view key, int rows, int columns) const;
  [[nodiscard]] const toml::table* table(std::string_view key) const;
  /// The tables of `[[key]]`, in their order; none if missing.
  [[nodiscard]] std::vector<const toml::table*> tables(std::string_view key) const;
  /// The value as TOML has it, or nullptr.
  [[nodiscard]] const toml::node* node(std::string_view key) const;

  /// Complains at the value of a key (at the table if it is missing).
  void complain(std::string_view key, std::string_view message) const;
  /// Complains of the table.
  void complain(std::string_view message) const;

 private:
  void require_short(std::string_view key, const std::string& value) const;
  void complain_at(const SourceLocation& where, std::string_view message) const;
  [[nodiscard]] std::optional<double> number_of(const toml::node& node, const std::string& name) const;
  [[nodiscard]] std::optional<std::vector<double>> numbers_of(const toml::node& node, const std::string& name,
                                                              int length) const;

  const toml::table* table_;
  std::string title_;
  FileReading* reading_;
};

/// Complains unless the document's `format` is there and is `known`.
void check_format(const TableReader& document, int known);

/// A file that is read must be no longer than this.
inline constexpr std::uintmax_t kMostBytes = std::uintmax_t{64} << 20U;

/// Everything in a regular file; throws InputError if it cannot be read, is too long, or is a folder, a fifo or a
/// device, from which reading might never end: those are not waited for.
std::string read_text_file(const std::filesystem::path& file);

/// Title of a table in messages: "joint 'A'", or "joint" if it has no name.
std::string title_with_name(const toml::table& table, std::string_view kind);

/// Name of a value's type in messages: "a number", "a string", ...
std::string_view type_name(const toml::node& node);

/// The number of a node that is one. A whole number that double precision does not hold is rounded to one it holds.
double number_in(const toml::node& node);

}  // namespace concord
