#pragma once

#include <string>
#include <string_view>

/// Command lines that --help ends with. Those of shipped models run as they stand, from the project's folder.
namespace concord::compare {

/// The examples of one command, its first one first; empty for what is no command.
std::string examples_of(std::string_view command);

/// The first example of every command.
std::string first_examples();

}  // namespace concord::compare
