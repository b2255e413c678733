#include "compare/report/interrupt.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "compare/report/files.h"

namespace concord::compare {

namespace {

constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};

/// The handler may do almost nothing; it wakes a thread that may do all, by the number of the signal in a pipe.
std::array<int, 2> wake_pipe{-1, -1};
pid_t watched_process = 0;

extern "C" void wake_watcher(int signal) {
  const int saved = errno;
  if (getpid() != watched_process) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  } else {
    const auto byte = static_cast<unsigned char>(signal);
    [[maybe_unused]] const ssize_t written = write(wake_pipe[1], &byte, 1);
  }
  errno = saved;
}

struct Finished {
  std::mutex lock;
  std::string names;
  int count = 0;
  std::string so_far;
};

Finished& finished() {
  static Finished all;
  return all;
}

const char* name_of_signal(int signal) {
  if (signal == SIGINT) return "SIGINT";
  return signal == SIGTERM ? "SIGTERM" : "SIGHUP";
}

std::string farewell(int signal) {
  const std::lock_guard guard(finished().lock);
  std::string done = finished().count == 0 ? "nothing was finished" : "finished: " + finished().names;
  if (!finished().so_far.empty()) done = finished().so_far;
  return fmt::format("\ninterrupted by {}: {}; unfinished files are removed\n", name_of_signal(signal), done);
}

/// Waits for a signal, or for the end of the watch.
void watch() {
  unsigned char byte = 0;
  ssize_t count = 0;
  do {
    count = read(wake_pipe[0], &byte, 1);
  } while (count < 0 && errno == EINTR);
  if (count != 1 || byte == 0) return;
  const std::string text = farewell(byte);  // before work fails because its files go
  abandon_unfinished_files();
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, text.data(), text.size());
  _exit(128 + byte);
}

}  // namespace

InterruptWatch::InterruptWatch() {
  if (pipe2(wake_pipe.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe for the signals");
  watched_process = getpid();
  watcher_ = std::thread(watch);
  for (const int signal : kSignals) {
    struct sigaction previous {};
    sigaction(signal, nullptr, &previous);
    if (previous.sa_handler == SIG_IGN) continue;  // as in the background of a shell
    struct sigaction action {};
    action.sa_handler = wake_watcher;
    action.sa_flags = SA_RESTART;
    sigaction(signal, &action, nullptr);
  }
}

InterruptWatch::~InterruptWatch() {
  for (const int signal : kSignals) {
    struct sigaction current {};
    sigaction(signal, nullptr, &current);
    if (current.sa_handler == wake_watcher) std::signal(signal, SIG_DFL);
  }
  const unsigned char end = 0;
  [[maybe_unused]] const ssize_t written = write(wake_pipe[1], &end, 1);
  watcher_.join();
  for (int& file : wake_pipe) {
    close(file);
    file = -1;
  }
}

void note_finished(const std::string& name) {
  constexpr int kTold = 10;
  Finished& all = finished();
  const std::lock_guard guard(all.lock);
  if (all.count < kTold) all.names += (all.count == 0 ? "" : ", ") + name;
  if (all.count == kTold) all.names += ", ...";
  ++all.count;
}

void note_progress(std::string so_far) {
  const std::lock_guard guard(finished().lock);
  finished().so_far = std::move(so_far);
}

}  // namespace concord::compare
