#pragma once

#include <unistd.h>

#include <cstdlib>
#include <exception>
#include <ostream>
#include <string_view>
#include <type_traits>

#include "common/error.h"

/// Where commands speak, and with which code they end.
namespace concord::compare {

/// Exit codes of the program.
enum ExitCode { kAgree = 0, kDiffer = 1, kBadInput = 2, kCouldNotFinish = 3 };

/// Where the commands speak.
struct Console {
  std::ostream& out;      // tables
  std::ostream& err;      // errors, wall times
  bool progress = false;  // err is a terminal: show how far long runs are
  bool colours = false;   // out is one, too, and colours are wanted
};

/// Whether standard error is a terminal on which a line can be written over: not TERM=dumb.
inline bool can_show_progress() {
  const char* terminal = std::getenv("TERM");
  return isatty(STDERR_FILENO) != 0 && terminal != nullptr && std::string_view(terminal) != "dumb";
}

/// Whether standard output is a terminal that may show colours: not TERM=dumb, and no NO_COLOR (no-color.org).
inline bool can_show_colours() {
  const char* terminal = std::getenv("TERM");
  const char* refused = std::getenv("NO_COLOR");
  return isatty(STDOUT_FILENO) != 0 && terminal != nullptr && std::string_view(terminal) != "dumb" &&
         (refused == nullptr || *refused == '\0');
}

/// Runs `work` and turns what it throws into a message and an exit code; work that returns none is fine.
template <class Work>
int guarded(const Console& console, const Work& work) {
  try {
    if constexpr (std::is_void_v<decltype(work())>) {
      work();
      return kAgree;
    } else {
      return work();
    }
  } catch (const InputError& error) {
    console.err << error.what() << '\n';
    return kBadInput;
  } catch (const SolverError& error) {
    console.err << error.what() << '\n';
    return kCouldNotFinish;
  } catch (const std::exception& error) {
    console.err << "could not finish: " << error.what() << '\n';
    return kCouldNotFinish;
  }
}

}  // namespace concord::compare
