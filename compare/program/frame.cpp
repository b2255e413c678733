#include "compare/program/frame.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <iostream>

#include "common/reading/spelling.h"
#include "compare/program/examples.h"
#include "compare/report/console.h"
#include "compare/report/interrupt.h"

namespace concord::compare {

namespace {

/// A stream that is closed would give its number to the next file that is opened, and tables would run into results.
void occupy_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) == -1 && errno == EBADF) open("/dev/null", O_RDONLY);
  }
}

/// Matrices of one state after another take the memory of those before, instead of giving it back to the system and
/// asking for it again: a third of the processor time of a ladder of 40 bodies.
void keep_freed_memory() {
#if defined(__GLIBC__) && !defined(CONCORD_SANITIZED)
  constexpr int kKept = 1 << 28;    // bytes
  constexpr int kByHeap = 1 << 25;  // bytes, of one matrix: the most that older versions of the library take
  constexpr int kAtOnce = 1 << 24;  // bytes that the heap grows by
  mallopt(M_TRIM_THRESHOLD, kKept);
  mallopt(M_MMAP_THRESHOLD, kByHeap);
  mallopt(M_TOP_PAD, kAtOnce);
#endif
}

/// The code, unless the tables could not be written: a full disk, a closed pipe.
int code_if_told(int code) {
  errno = 0;
  std::cout.flush();
  if (std::cout) return code;
  std::cerr << fmt::format("could not finish: the standard output cannot be written{}{}\n", errno != 0 ? ": " : "",
                           errno != 0 ? std::strerror(errno) : "");
  return kCouldNotFinish;
}

}  // namespace

int run_guarded(const std::function<int()>& program) {
  keep_freed_memory();
  occupy_standard_streams();
  std::signal(SIGPIPE, SIG_IGN);  // writing into a closed pipe fails, and is reported
  std::signal(SIGXFSZ, SIG_IGN);  // so does writing more than a limit allows
  try {
    const InterruptWatch watch;
    return code_if_told(program());
  } catch (const std::exception& error) {
    std::cerr << "could not finish: " << error.what() << '\n';
    return kCouldNotFinish;
  }
}

void add_examples(CLI::App& program) {
  for (CLI::App* command : program.get_subcommands(nullptr)) command->footer(examples_of(command->get_name()));
}

void require_known_command(const CLI::App& program, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> names;
  for (const CLI::App* command : program.get_subcommands(nullptr)) names.push_back(command->get_name());
  if (std::find(names.begin(), names.end(), argv[1]) != names.end()) return;
  throw CLI::ValidationError(fmt::format("no command '{}': {}", argv[1], suggestion(argv[1], names, "commands")));
}

void require_values(const CLI::App& program) {
  for (const CLI::App* command : program.get_subcommands()) {
    for (const CLI::Option* option : command->get_options()) {
      if (option->get_expected_min() == 0) continue;  // a flag
      for (const std::string& value : option->results()) {
        if (value.empty()) throw CLI::ValidationError(option->get_name(), "expected a value, found an empty one");
      }
    }
  }
}

}  // namespace concord::compare
