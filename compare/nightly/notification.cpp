#include "compare/nightly/notification.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <exception>
#include <stdexcept>

#include "compare/report/feed_command.h"

namespace concord::compare::nightly {

void notify(const NightlyCommand& command, const std::string& text, const Console& console) {
  if (command.notify.empty()) return;
  const FedCommand fed = feed_command(command.notify, text);
  const int status = fed.status;
  if (!fed.has_started) throw std::runtime_error("the command of --notify cannot be started");
  if (status == 0) return;
  console.err << (WIFSIGNALED(status)
                      ? fmt::format("the command of --notify was ended by signal {}\n", WTERMSIG(status))
                      : fmt::format("the command of --notify ended with {}\n", WEXITSTATUS(status)));
}

void notify_of_end(const NightlyCommand& command, const std::string& name, const char* why, const Console& console) {
  try {
    notify(command, fmt::format("# red {}: the night could not finish\n\n{}\n", name, why), console);
  } catch (const std::exception& error) {
    console.err << error.what() << '\n';  // what ended the night is told after it
  }
}

}  // namespace concord::compare::nightly
