#include "compare/workers/worker.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <fstream>
#include <new>
#include <system_error>
#include <vector>

namespace concord::compare::workers {

namespace {

constexpr std::size_t kMostWords = 4096;

/// Every message is its kind, its length and its text.
struct Header {
  char kind = 0;
  std::uint64_t length = 0;
};
constexpr char kTask = 't';
constexpr char kAnswer = 'a';
constexpr char kException = 'e';
constexpr char kNoMemory = 'm';
constexpr std::size_t kHeaderBytes = 1 + sizeof(std::uint64_t);

[[noreturn]] void fail(const char* what) { throw std::system_error(errno, std::generic_category(), what); }

double seconds_of(clockid_t clock) {
  timespec now{};
  if (clock_gettime(clock, &now) != 0) return 0.0;
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double processor_seconds(pid_t process) {
  clockid_t clock{};
  return clock_getcpuclockid(process, &clock) == 0 ? seconds_of(clock) : 0.0;
}

/// Whether all was sent; false if the other side is gone.
bool send_all(int socket, const char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t sent = send(socket, data, size, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
      pollfd ready{socket, POLLOUT, 0};
      poll(&ready, 1, 100);
      continue;
    }
    if (sent <= 0) return false;
    data += sent;
    size -= static_cast<std::size_t>(sent);
  }
  return true;
}

bool send_message(int socket, char kind, const std::string& text) {
  std::string message(kHeaderBytes, kind);
  const std::uint64_t length = text.size();
  std::memcpy(message.data() + 1, &length, sizeof length);
  message += text;
  return send_all(socket, message.data(), message.size());
}

bool receive_all(int socket, char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t got = recv(socket, data, size, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    data += got;
    size -= static_cast<std::size_t>(got);
  }
  return true;
}

std::optional<std::string> receive_task(int socket) {
  std::string header(kHeaderBytes, '\0');
  if (!receive_all(socket, header.data(), header.size())) return std::nullopt;
  std::uint64_t length = 0;
  std::memcpy(&length, header.data() + 1, sizeof length);
  std::string text(length, '\0');
  if (!receive_all(socket, text.data(), text.size())) return std::nullopt;
  return text;
}

void limit_memory([[maybe_unused]] double megabytes) {
#ifndef CONCORD_SANITIZED  // the sanitizers' shadow memory is larger than any limit
  std::ifstream pages("/proc/self/statm");
  double now = 0.0;
  pages >> now;
  const double bytes = now * static_cast<double>(sysconf(_SC_PAGESIZE)) + megabytes * 1048576.0;
  const auto most = static_cast<rlim_t>(bytes);
  const rlimit limit{most, most};
  setrlimit(RLIMIT_AS, &limit);
#endif
}

/// What a worker process does until its owner closes the socket. One that ran out of memory ends itself, because no one
/// knows what it still holds.
[[noreturn]] void work(const Task& task, int socket) {
  while (const std::optional<std::string> input = receive_task(socket)) {
    bool told = false;
    try {
      told = send_message(socket, kAnswer, task(*input));
    } catch (const std::bad_alloc&) {
      send_message(socket, kNoMemory, "");
      break;
    } catch (const std::system_error& error) {
      // A thread that finds no room for its stack says that it should be tried again.
      const bool no_memory =
          error.code() == std::errc::resource_unavailable_try_again || error.code() == std::errc::not_enough_memory;
      told = send_message(socket, no_memory ? kNoMemory : kException, no_memory ? "" : error.what());
      if (no_memory) break;
    } catch (const std::exception& error) {
      told = send_message(socket, kException, error.what());
    }
    if (!told) break;
  }
  _exit(0);
}

/// Signals that a terminal, or whoever stops a program with all its processes, sends to workers too. What they mean is
/// their owner's to say, with whose end they end; a worker that they ended by themselves would look like one that
/// crashed.
constexpr std::array kSignalsOfOwner{SIGINT, SIGTERM, SIGHUP};

/// A fork whose child ignores the signals of its owner from its first moment.
pid_t fork_under_signals() {
  sigset_t held{};
  sigset_t before{};
  sigemptyset(&held);
  for (const int signal : kSignalsOfOwner) sigaddset(&held, signal);
  pthread_sigmask(SIG_BLOCK, &held, &before);
  const pid_t process = fork();
  if (process == 0) {
    for (const int signal : kSignalsOfOwner) std::signal(signal, SIG_IGN);
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return process;
}

void become_worker(pid_t owner, const Limits& limits, int words, const std::vector<int>& to_close) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != owner) _exit(0);
  const int nowhere = open("/dev/null", O_RDWR);
  dup2(nowhere, STDIN_FILENO);
  dup2(nowhere, STDOUT_FILENO);
  dup2(words, STDERR_FILENO);
  for (const int descriptor : to_close) close(descriptor);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  limit_memory(limits.megabytes);
}

}  // namespace

Worker::Worker(const Task& task, const Limits& limits, const std::vector<int>& to_close) : limits_(limits) {
  std::array<int, 2> sockets{};
  std::array<int, 2> pipes{};
  if (socketpair(AF_UNIX, SOCK_STREAM, 0, sockets.data()) != 0) fail("socketpair");
  if (pipe(pipes.data()) != 0) fail("pipe");
  const pid_t owner = getpid();
  process_ = fork_under_signals();
  if (process_ < 0) fail("fork");
  if (process_ == 0) {
    std::vector<int> own_to_close = to_close;
    own_to_close.insert(own_to_close.end(), {sockets[0], pipes[0]});
    become_worker(owner, limits, pipes[1], own_to_close);
    work(task, sockets[1]);
  }
  close(sockets[1]);
  close(pipes[1]);
  answers_ = sockets[0];
  words_ = pipes[0];
  fcntl(answers_, F_SETFL, O_NONBLOCK);
  fcntl(words_, F_SETFL, O_NONBLOCK);
}

Worker::~Worker() {
  int status = 0;
  if (!ended_) kill_and_wait(status);
  close(answers_);
  close(words_);
}

void Worker::give(std::size_t number, const std::string& input) {
  number_ = number;
  busy_ = true;
  hear_words();
  last_words_.clear();
  started_processor_ = processor_seconds(process_);
  used_ = 0.0;
  seen_used_ = 0.0;
  progress_wall_ = seconds_of(CLOCK_MONOTONIC);
  send_message(answers_, kTask, input);  // a worker that is gone is seen by look()
}

bool Worker::is_over_time() {
  used_ = std::max(used_, processor_seconds(process_) - started_processor_);
  if (used_ > limits_.seconds) return true;
  // On a busy machine a task may wait long for the processor; only one that gets nowhere is asleep.
  constexpr double kProgress = 0.01;  // of the limit
  const double now = seconds_of(CLOCK_MONOTONIC);
  if (used_ > seen_used_ + kProgress * limits_.seconds) {
    seen_used_ = used_;
    progress_wall_ = now;
  }
  return now - progress_wall_ > limits_.wall_per_processor * limits_.seconds;
}

void Worker::hear_words() {
  std::array<char, 4096> chunk{};
  for (ssize_t got = read(words_, chunk.data(), chunk.size()); got > 0;
       got = read(words_, chunk.data(), chunk.size())) {
    last_words_.append(chunk.data(), static_cast<std::size_t>(got));
    if (last_words_.size() > kMostWords) last_words_.erase(0, last_words_.size() - kMostWords);
  }
}

/// Whether the process still lives, as far as its socket shows.
bool Worker::hear_answers() {
  std::array<char, 65536> chunk{};
  while (true) {
    const ssize_t got = recv(answers_, chunk.data(), chunk.size(), 0);
    if (got > 0) {
      received_.append(chunk.data(), static_cast<std::size_t>(got));
    } else if (got < 0 && errno == EINTR) {
      continue;
    } else {
      return got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK);
    }
  }
}

/// The report of a message that has come as a whole.
std::optional<Report> Worker::take_report() {
  if (received_.size() < kHeaderBytes) return std::nullopt;
  std::uint64_t length = 0;
  std::memcpy(&length, received_.data() + 1, sizeof length);
  if (received_.size() < kHeaderBytes + length) return std::nullopt;
  Report report;
  const char kind = received_.front();
  report.end = kind == kAnswer ? End::answered : kind == kException ? End::threw : End::out_of_memory;
  report.answer = received_.substr(kHeaderBytes, length);
  received_.clear();
  busy_ = false;
  hear_words();
  report.last_words = last_words_;
  report.seconds = std::max(used_, processor_seconds(process_) - started_processor_);
  if (report.end == End::out_of_memory) {
    int status = 0;
    kill_and_wait(status);
  }
  return report;
}

void Worker::kill_and_wait(int& status) {
  kill(process_, SIGKILL);
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR) continue;
  ended_ = true;
}

Report Worker::report_end(bool killed_for_time) {
  int status = 0;
  if (killed_for_time) {
    kill_and_wait(status);
  } else {
    // The socket is closed: the process is ending by itself.
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) continue;
    ended_ = true;
  }
  busy_ = false;
  hear_words();
  Report report;
  report.end = killed_for_time ? End::hung : End::crashed;
  report.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  report.last_words = last_words_;
  report.seconds = used_;
  if (!killed_for_time && last_words_.find("std::bad_alloc") != std::string::npos) report.end = End::out_of_memory;
  return report;
}

std::optional<Report> Worker::look() {
  hear_words();
  const bool lives = hear_answers();
  if (!busy_) return std::nullopt;
  if (auto report = take_report()) return report;
  if (!lives) return report_end(false);
  if (is_over_time()) return report_end(true);
  return std::nullopt;
}

}  // namespace concord::compare::workers
