#pragma once

#include <toml++/toml.h>

#include <array>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tests/second_reading/ledger.h"

namespace concord::second_reading {

struct StatedFile;

/// Kinds of names, each with a list of its own in every file.
enum class Names { bodies, roads, joints, couplings, elements };
inline constexpr std::size_t kNames = 5;

/// The tables of force elements, in the order of ForceElement::what.
inline constexpr std::array kElementTables{"load", "line_spring", "turn_spring", "bushing", "tire"};

/// A table of a file. What is asked for is taken as known; keys that nobody has asked for when the last copy of the
/// table goes are told to the ledger. A value that is not of the asked type throws std::runtime_error.
class StatedTable {
 public:
  StatedTable(const toml::table& table, const StatedFile& file, Ledger& ledger, const std::string& where,
              const std::string& path);

  [[nodiscard]] const StatedFile& file() const { return state_->file; }
  [[nodiscard]] Ledger& ledger() const { return state_->ledger; }
  [[nodiscard]] const std::string& where() const { return state_->where; }
  /// Where the file states a key: this table if it does not.
  [[nodiscard]] Entry entry(const std::string& key) const;
  [[nodiscard]] std::vector<std::string> keys() const;
  [[nodiscard]] bool has(const std::string& key) const { return state_->table.contains(key); }
  [[nodiscard]] bool has_table(const std::string& key) const;

  [[nodiscard]] std::optional<double> number(const std::string& key) const;
  [[nodiscard]] std::optional<std::vector<double>> numbers(const std::string& key) const;
  /// Rows of numbers; or one row, which is the diagonal.
  [[nodiscard]] std::optional<MatX> matrix(const std::string& key) const;
  [[nodiscard]] std::optional<Vec3> vector(const std::string& key) const;
  [[nodiscard]] std::optional<std::string> text(const std::string& key) const;
  [[nodiscard]] bool flag(const std::string& key) const;
  [[nodiscard]] std::optional<StatedTable> table(const std::string& key) const;
  [[nodiscard]] std::vector<StatedTable> tables(const std::string& key) const;
  /// The name in the model of what the file names under this key.
  [[nodiscard]] std::string reference(Names kind, const std::string& key) const;
  /// The name in the model of what this table defines.
  [[nodiscard]] std::string own_name() const;
  /// The same table under another name.
  void rename(const std::string& where, const std::string& path = "") const {
    state_->where = where;
    state_->path = path;
  }

  /// Takes all keys as known: the model has nothing to hold them against.
  void pass_over() const;

  /// Hold what the model has under a key against what the file states, or against what holds without the key.
  void hold_number(const std::string& key, double read, double otherwise) const;
  void hold_number(const std::string& key, double read) const;  // which must be there
  void hold_vector(const std::string& key, const Vec3& read) const;
  void hold_word(const std::string& key, const std::string& read, const std::string& otherwise) const;

 private:
  struct State {
    const toml::table& table;
    const StatedFile& file;
    Ledger& ledger;
    std::string where;
    std::string path;
    std::set<std::string> asked = {};
    ~State();
  };
  [[nodiscard]] const toml::node* ask(const std::string& key) const;

  std::shared_ptr<State> state_;
};

}  // namespace concord::second_reading
