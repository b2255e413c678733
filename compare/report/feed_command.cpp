#include "compare/report/feed_command.h"

#include <csignal>
#include <cstdio>

namespace concord::compare {

namespace {

/// While it lives, writing into a closed pipe is an error and no signal.
class IgnoreBrokenPipe {
 public:
  IgnoreBrokenPipe() : before_(std::signal(SIGPIPE, SIG_IGN)) {}
  ~IgnoreBrokenPipe() { std::signal(SIGPIPE, before_); }
  IgnoreBrokenPipe(const IgnoreBrokenPipe&) = delete;
  IgnoreBrokenPipe& operator=(const IgnoreBrokenPipe&) = delete;

 private:
  void (*before_)(int);
};

}  // namespace

FedCommand feed_command(const std::string& command, const std::string& text) {
  std::FILE* pipe = popen(command.c_str(), "w");
  if (pipe == nullptr) return {};
  const IgnoreBrokenPipe guard;  // not of the command, which would inherit it
  const bool written = std::fwrite(text.data(), 1, text.size(), pipe) == text.size() && std::fflush(pipe) == 0;
  return {true, pclose(pipe), written};
}

}  // namespace concord::compare
