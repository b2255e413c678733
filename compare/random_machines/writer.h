#pragma once

#include <string>
#include <utility>
#include <vector>

#include "compare/random_machines/machine.h"

namespace concord::compare::fuzz {

/// The files that state a machine.
struct ModelText {
  std::string model;                                        // TOML
  std::vector<std::pair<std::string, std::string>> beside;  // modes files: name, text
};

/// Writes a machine that has been placed, in the format of data/README.md; numbers with all their digits. Its modes
/// files bear the machine's name.
ModelText write_machine(const Machine& machine);

/// All files in one text, and back.
std::string pack(const ModelText& text);
ModelText unpack(const std::string& packed);

}  // namespace concord::compare::fuzz
