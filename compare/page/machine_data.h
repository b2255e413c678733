#pragma once

#include <array>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "compare/page/curves.h"

/// What the page shows of one machine.
namespace concord::compare::page {

/// A result document (compare/report/result_document.h) and the runs of both solvers, the Cartesian one first; a run is
/// missing where the solver did not finish.
struct MachineResult {
  std::string document;
  std::array<std::optional<Curves>, 2> runs;
};

/// All results that stand in a folder that `concord compare --out` wrote, sorted by name. Throws InputError if the
/// folder holds none, or one of an unknown version; names what was found and what was expected.
std::vector<MachineResult> read_results(const std::filesystem::path& folder);

/// The machine as the page's script reads it: the document, the curves thinned to about `bytes` and poses at some
/// times.
nlohmann::ordered_json machine_data(const MachineResult& result, std::size_t bytes);

/// The verdict on one machine in one sentence.
std::string sentence_of(const nlohmann::ordered_json& document);

}  // namespace concord::compare::page
