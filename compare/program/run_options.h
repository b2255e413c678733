#pragma once

#include "compare/verdict/verify.h"

namespace CLI {
class App;
}

namespace concord::compare {

/// --until, --rtol and --samples of a command that makes runs; numbers out of range are refused as the line is parsed.
void add_run_options(CLI::App& command, VerifyOptions& options);

}  // namespace concord::compare
