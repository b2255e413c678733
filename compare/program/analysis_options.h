#pragma once

#include "compare/report/command_line.h"

namespace concord::compare {

/// Adds the commands `statics`, `linearize`, `kinematics` and `inverse`.
void add_analyses(CommandLine& line);

}  // namespace concord::compare
