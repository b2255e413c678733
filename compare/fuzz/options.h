#pragma once

#include "compare/fuzz/command.h"

namespace CLI {
class App;
}

namespace concord::compare::fuzz {

/// Adds the subcommand `fuzz` to the program's command line.
CLI::App* add_fuzz(CLI::App& program, FuzzCommand& command);

}  // namespace concord::compare::fuzz
