#pragma once

#include "common/reading/toml_reader.h"
#include "compare/nightly/case.h"

/// Which keys a [[case]] may have. A key that its work would ignore is refused: whoever wrote it meant something.
namespace concord::compare::nightly {

/// The keys of all kinds of work.
KnownKeys case_keys();

/// Complains of each key of the case and of its sweep that means nothing to its work.
void refuse_keys_without_meaning(const TableReader& table, Work work);

}  // namespace concord::compare::nightly
