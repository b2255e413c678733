#pragma once

#include <functional>

namespace CLI {
class App;
}

/// What the program does around its commands: streams, signals, exceptions, examples, words that are no command.
namespace concord::compare {

/// Runs the program: standard streams are open, SIGINT, SIGTERM and SIGHUP are watched, an exception ends it
/// with kCouldNotFinish and its text, and so does a standard output that cannot be written. Returns the exit code.
int run_guarded(const std::function<int()>& program);

/// Lets the --help of each command of the program end with its examples (program/examples).
void add_examples(CLI::App& program);

/// Throws CLI::ValidationError for a first word that is no command, naming a near one.
void require_known_command(const CLI::App& program, int argc, char** argv);

/// Throws CLI::ValidationError if an option was given without anything in it, as by an empty variable of a script;
/// after the command line has been parsed.
void require_values(const CLI::App& program);

}  // namespace concord::compare
