#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <type_traits>

#include "compare/report/console.h"
#include "compare/report/whole_number.h"
#include "compare/states/branch.h"

namespace concord::compare {

/// For an option that takes whole numbers; its help names the limits.
inline CLI::Validator whole_number_from(std::int64_t least, std::int64_t most) {
  return {[=](std::string& text) { return why_no_count(text, least, most); }, fmt::format("{} to {}", least, most)};
}

/// The commands of the program, each with what it does once the whole line has been read.
class CommandLine {
 public:
  explicit CommandLine(CLI::App& program) : program_(program) {}

  /// A command and what its options are to be written into.
  template <class Command>
  struct Added {
    CLI::App& app;
    Command& command;
  };

  /// Adds a command without options. `act` takes a Command, makers of solvers if it needs them, and a Console, and
  /// returns the exit code.
  template <class Command, class Act>
  Added<Command> add(const char* name, const char* about, const Act& act) {
    const auto command = std::make_shared<Command>();
    CLI::App* app = program_.add_subcommand(name, about);
    actions_[app] = [command, act](const SolverMakers& makers, const Console& console) -> int {
      if constexpr (std::is_invocable_v<Act, Command&, const Console&>) {
        return act(*command, console);
      } else {
        return act(*command, makers, console);
      }
    };
    return {*app, *command};
  }

  /// Does what was asked for on a line that has been parsed; returns the exit code.
  [[nodiscard]] int run(const SolverMakers& makers, const Console& console) const {
    return actions_.at(program_.get_subcommands().front())(makers, console);
  }

 private:
  CLI::App& program_;
  std::map<const CLI::App*, std::function<int(const SolverMakers&, const Console&)>> actions_;
};

}  // namespace concord::compare
