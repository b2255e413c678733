#pragma once

#include <string>

#include "compare/nightly/command.h"
#include "compare/report/console.h"

/// What the command of --notify is told.
namespace concord::compare::nightly {

/// Gives the command `text` on its standard input, if there is one. A command that fails is reported, and changes no
/// verdict. Throws std::runtime_error if it cannot be started.
void notify(const NightlyCommand& command, const std::string& text, const Console& console);

/// That the night of this name ended without a report, and why. Throws nothing: what ended it is told after it.
void notify_of_end(const NightlyCommand& command, const std::string& name, const char* why, const Console& console);

}  // namespace concord::compare::nightly
