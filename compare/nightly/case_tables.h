#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/reading/toml_reader.h"
#include "compare/nightly/case.h"
#include "compare/nightly/variants.h"

/// The tables within a [[case]] of a suite. Each reading is empty if its table is missing; what is wrong is complained
/// of at its place. `outer`: the case's own table.
namespace concord::compare::nightly {

/// The texts of a list; nothing after a complaint.
std::optional<std::vector<std::string>> read_texts(const TableReader& table, std::string_view key);

/// A table within another one; nothing if it is missing.
std::optional<TableReader> inner_table(const TableReader& outer, std::string_view key, const KnownKeys& known);

/// Calls use(table, name) for every key of a table whose keys are names.
template <class Use>
void each_name(const TableReader& outer, std::string_view key, const Use& use) {
  const toml::table* found = outer.table(key);
  if (found == nullptr) return;
  KnownKeys names;
  for (const auto& [name, value] : *found) names.push_back(name.str());
  const std::optional<TableReader> table = inner_table(outer, key, names);
  for (const std::string_view name : names) use(*table, name);
}

/// The keys of a [[case]] of any kind of work.
KnownKeys case_keys();

/// Complains of each key of the case and of its sweep that means nothing to its work: whoever wrote it meant something.
void refuse_keys_without_meaning(const TableReader& table, Work work);

/// `known_red`: why a case may be red, and until when.
std::optional<KnownRed> read_known_red(const TableReader& outer);

/// `[[need]]`: digits that the case needs instead of the model's.
std::vector<NeedOverride> read_case_needs(const TableReader& outer);

/// `"joint.coordinate" = value`; the last dot ends the joint's name.
std::vector<analyses::AskedAcceleration> read_accelerations(const TableReader& outer);

/// `sweep`: what varies from one variant of the case to the next.
Sweep read_sweep(const TableReader& outer);

}  // namespace concord::compare::nightly
