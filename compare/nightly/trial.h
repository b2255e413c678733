#pragma once

#include <filesystem>

#include "compare/nightly/case.h"
#include "compare/nightly/result.h"
#include "compare/states/branch.h"
#include "compare/verdict/verify.h"

namespace concord::compare::nightly {

/// Does what the case says, in this process. `scratch` is a folder for files that a share of random machines needs.
/// Says on stderr how far it is, for the reader of a crashed worker's last words. What is refused is an ending; what
/// has no place in a result is thrown. A comparison that does not agree is written as a page to `page`, if that is
/// not empty.
Result try_case(const Case& one, const std::filesystem::path& scratch, const SolverMakers& makers,
                const std::filesystem::path& page = {});

}  // namespace concord::compare::nightly
