#pragma once

#include <optional>

#include "compare/nightly/command.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace concord::compare::nightly {

/// The subcommands `nightly`, `accept`, `history` and `diff` on the program's command line.
class NightlyCommands {
 public:
  explicit NightlyCommands(CLI::App& program);

  /// Takes the options for sbatch from the end of a command line, all that stands behind `--slurm`. Returns how many
  /// words are left.
  [[nodiscard]] int take_slurm_words(int argc, char** argv);

  /// Does what was asked for and returns the exit code; nothing if none of the four was.
  [[nodiscard]] std::optional<int> run(const SolverMakers& makers, const Console& console) const;

 private:
  void add_nightly(CLI::App& program);
  void add_slurm(CLI::App& nightly);
  void add_accept(CLI::App& program);
  void add_history(CLI::App& program);
  void add_diff(CLI::App& program);

  CLI::App* nightly_app_ = nullptr;
  CLI::Option* slurm_option_ = nullptr;
  CLI::App* accept_app_ = nullptr;
  CLI::App* history_app_ = nullptr;
  CLI::App* diff_app_ = nullptr;
  NightlyCommand nightly_;
  AcceptCommand accept_;
  HistoryCommand history_;
  DiffCommand diff_;
};

}  // namespace concord::compare::nightly
