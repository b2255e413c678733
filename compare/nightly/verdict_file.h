#pragma once

#include <filesystem>

#include "compare/nightly/tables.h"

namespace concord::compare::nightly {

/// Results of a file, and which command's it is.
struct ResultsFile {
  NightFile night;
  bool is_of_compare = false;  // by `concord compare --json`: sides and joints, without bodies, peaks and integrators
  bool is_single = false;      // and of one model, whose name files of older versions do not hold
};

/// Results of a file that `nightly --json` or `compare --json` wrote. Throws InputError if it is neither; a version
/// that is not known is refused by name.
ResultsFile read_results_file(const std::filesystem::path& file);

/// Files of `compare --json` tell the components of one model in other words than nights, so that one kind is compared
/// with its own alone, and one model without a name with one model. Gives an unnamed model the name that the other side
/// has. Both must have a case in common. Throws InputError, naming `a` or `b`.
void require_comparable(ResultsFile& one, ResultsFile& other, const std::string& a, const std::string& b);

}  // namespace concord::compare::nightly
