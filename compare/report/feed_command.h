#pragma once

#include <string>

namespace concord::compare {

/// How a command of the shell ended that was given a text.
struct FedCommand {
  bool has_started = false;
  int status = 0;         // as of wait(2)
  bool has_read = false;  // all of the text was taken
};

/// Gives a text to the standard input of a command of the shell and waits for its end. A command that closes its input
/// early costs the rest of the text and not this process.
FedCommand feed_command(const std::string& command, const std::string& text);

}  // namespace concord::compare
