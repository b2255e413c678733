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

/// Every key of a table whose keys are names.
KnownKeys keys_of(const toml::table& table);

/// `known_red`: why a case may be red, and until when.
std::optional<KnownRed> read_known_red(const TableReader& outer);

/// `[[need]]`: digits that the case needs instead of the model's.
std::vector<NeedOverride> read_case_needs(const TableReader& outer);

/// `"joint.coordinate" = value`; the last dot ends the joint's name.
std::vector<analyses::AskedAcceleration> read_accelerations(const TableReader& outer);

/// `sweep`: what varies from one variant of the case to the next.
Sweep read_sweep(const TableReader& outer);

}  // namespace concord::compare::nightly
