#pragma once

#include <toml++/toml.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/reading/file_reading.h"
#include "common/types.h"

/// A typed reader over toml++: every reading that fails leaves a complaint and goes on, so that all errors of a file
/// are reported together.
namespace concord {

/// Keys that a table may have.
using KnownKeys = std::vector<std::string_view>;

/// One table of a file. Each reading returns nothing if the key is missing, or if its value is wrong: then it has
/// reported at the value's location. Numbers may be expressions of the parameters, and are zero or of a usable size
/// (common/reading/magnitude.h).
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
  /// Half a unit of the last digit of a number that is written as a decimal fraction, or as one in degrees ("26.2
  /// deg"); kWrittenExactly of any other.
  [[nodiscard]] double slack_of(std::string_view key) const;
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

  /// Tells what was put right at the value of a key.
  void note(std::string_view key, std::string_view message) const;
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

}  // namespace concord
