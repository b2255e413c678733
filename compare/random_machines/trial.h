#pragma once

#include <filesystem>

#include "compare/random_machines/outcome.h"
#include "compare/random_machines/writer.h"
#include "compare/states/branch.h"
#include "compare/verdict/verify.h"

namespace concord::compare::fuzz {

/// Reads a machine from its text, its modes files from `folder`, and compares the solvers on it with default settings.
/// `refines`: at the tighter tolerance too. Says on stderr which check it is on, for the reader of a crashed worker's
/// last words.
Outcome try_machine(const ModelText& text, const std::filesystem::path& folder, const SolverMakers& makers,
                    bool refines = true);

}  // namespace concord::compare::fuzz
