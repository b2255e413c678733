#include "tests/second_reading/stated_table.h"

#include <algorithm>
#include <stdexcept>

#include "tests/second_reading/stated_file.h"

namespace concord::second_reading {

namespace {

std::vector<double> numbers_of(const toml::node& node, const Scope& scope) {
  if (!node.is_array()) throw std::runtime_error("no list");
  std::vector<double> numbers;
  for (const toml::node& item : *node.as_array()) numbers.push_back(scope.evaluate(item));
  return numbers;
}

/// The largest number in the expressions of a value; zero if it is stated outright.
double size_of_terms(const toml::node& node, const Scope& scope) {
  if (const auto text = node.value_exact<std::string>()) {
    try {
      return scope.size_of_terms(*text);
    } catch (const std::runtime_error&) {
      return 0.0;  // a word
    }
  }
  double size = 0.0;
  if (const toml::array* items = node.as_array()) {
    for (const toml::node& item : *items) size = std::max(size, size_of_terms(item, scope));
  }
  return size;
}

}  // namespace

StatedTable::State::~State() {
  for (const auto& [key, value] : table) {
    const std::string name(key.str());
    if (!asked.contains(name)) ledger.leave(where, path + name);
  }
}

StatedTable::StatedTable(const toml::table& table, const StatedFile& file, Ledger& ledger, const std::string& where,
                         const std::string& path)
    : state_(new State{table, file, ledger, where, path}) {}

Entry StatedTable::entry(const std::string& key) const {
  const toml::node* node = state_->table.get(key);
  const toml::node& place = node != nullptr ? *node : state_->table;
  const toml::source_region& source = place.source();
  Entry entry{state_->where, state_->path + key, static_cast<int>(source.begin.line), source.path ? *source.path : ""};
  if (node != nullptr) {
    entry.terms = [node, scope = state_->file.scope.get()] { return size_of_terms(*node, *scope); };
  }
  return entry;
}

std::vector<std::string> StatedTable::keys() const {
  std::vector<std::string> all;
  for (const auto& [key, value] : state_->table) all.emplace_back(key.str());
  return all;
}

const toml::node* StatedTable::ask(const std::string& key) const {
  state_->asked.insert(key);
  return state_->table.get(key);
}

bool StatedTable::has_table(const std::string& key) const { return has(key) && state_->table.get(key)->is_table(); }

std::optional<double> StatedTable::number(const std::string& key) const {
  const toml::node* node = ask(key);
  if (node == nullptr) return {};
  return state_->file.scope->evaluate(*node);
}

std::optional<std::vector<double>> StatedTable::numbers(const std::string& key) const {
  const toml::node* node = ask(key);
  if (node == nullptr) return {};
  return numbers_of(*node, *state_->file.scope);
}

std::optional<MatX> StatedTable::matrix(const std::string& key) const {
  const toml::node* node = ask(key);
  if (node == nullptr) return {};
  const toml::array* rows = node->as_array();
  if (rows == nullptr || rows->empty() || !rows->front().is_array()) {
    return MatX(column_of(numbers_of(*node, *state_->file.scope)).asDiagonal());
  }
  const auto width = static_cast<Eigen::Index>(rows->front().as_array()->size());
  MatX all(static_cast<Eigen::Index>(rows->size()), width);
  for (Eigen::Index k = 0; k < all.rows(); ++k) {
    const VecX row = column_of(numbers_of(*rows->get(static_cast<std::size_t>(k)), *state_->file.scope));
    if (row.size() != width) throw std::runtime_error(key + ": rows of different lengths");
    all.row(k) = row.transpose();
  }
  return all;
}

std::optional<Vec3> StatedTable::vector(const std::string& key) const {
  const auto list = numbers(key);
  if (!list) return {};
  if (list->size() != 3) throw std::runtime_error(key + ": not three numbers");
  return Vec3((*list)[0], (*list)[1], (*list)[2]);
}

std::optional<std::string> StatedTable::text(const std::string& key) const {
  const toml::node* node = ask(key);
  if (node == nullptr) return {};
  if (!node->is_string()) throw std::runtime_error(key + ": no text");
  return node->value<std::string>();
}

bool StatedTable::flag(const std::string& key) const {
  const toml::node* node = ask(key);
  return node != nullptr && node->value_or(false);
}

std::optional<StatedTable> StatedTable::table(const std::string& key) const {
  const toml::node* node = ask(key);
  if (node == nullptr) return {};
  if (!node->is_table()) throw std::runtime_error(key + ": no table");
  return StatedTable(*node->as_table(), state_->file, state_->ledger, state_->where, state_->path + key + ".");
}

std::vector<StatedTable> StatedTable::tables(const std::string& key) const {
  std::vector<StatedTable> all;
  const toml::node* node = ask(key);
  if (node == nullptr) return all;
  if (!node->is_array()) throw std::runtime_error(key + ": no list of tables");
  for (const toml::node& item : *node->as_array()) {
    if (!item.is_table()) throw std::runtime_error(key + ": no list of tables");
    all.emplace_back(*item.as_table(), state_->file, state_->ledger, state_->where, state_->path);
  }
  return all;
}

std::string StatedTable::reference(Names kind, const std::string& key) const {
  return state_->file.full_name(kind, text(key).value_or(""));
}

std::string StatedTable::own_name() const { return state_->file.prefix + text("name").value_or(""); }

void StatedTable::pass_over() const {
  for (const std::string& key : keys()) state_->asked.insert(key);
}

void StatedTable::hold_number(const std::string& key, double read, double otherwise) const {
  ledger().number(entry(key), read, number(key).value_or(otherwise));
}

void StatedTable::hold_number(const std::string& key, double read) const {
  const auto stated = number(key);
  if (!stated) throw std::runtime_error("no " + key);
  ledger().number(entry(key), read, *stated);
}

void StatedTable::hold_vector(const std::string& key, const Vec3& read) const {
  ledger().numbers(entry(key), read, vector(key).value_or(Vec3::Zero()));
}

void StatedTable::hold_word(const std::string& key, const std::string& read, const std::string& otherwise) const {
  ledger().word(entry(key), read, text(key).value_or(otherwise));
}

}  // namespace concord::second_reading
