#pragma once

#include "compare/program/command_line.h"

namespace concord::compare::fuzz {

/// Adds the command `fuzz`.
void add_fuzz(CommandLine& line);

}  // namespace concord::compare::fuzz
