#pragma once

#include <string>
#include <thread>

/// What happens when a user or a system stops the program, or its terminal goes (SIGINT, SIGTERM, SIGHUP).
namespace concord::compare {

/// While it lives, these signals remove all unfinished files, tell on the standard error what was finished, and end the
/// program with 128 + the signal's number. There is at most one. A child process that is forked meanwhile dies
/// of the signals in the usual way.
class InterruptWatch {
 public:
  InterruptWatch();
  ~InterruptWatch();
  InterruptWatch(const InterruptWatch&) = delete;
  InterruptWatch& operator=(const InterruptWatch&) = delete;

 private:
  std::thread watcher_;
};

/// One more piece of work, such as a model, is finished with all its files.
void note_finished(const std::string& name);

/// How far a long piece of work has come, told instead of names: "12 machines were tried".
void note_progress(std::string so_far);

}  // namespace concord::compare
