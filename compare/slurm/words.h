#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

/// What is said to Slurm and what it says, as text.
namespace concord::compare::slurm {

/// What a shell makes of the text: quotes, backslashes, variables and `~` mean what they mean there. Throws InputError
/// if a shell would refuse it, or would run a command.
std::vector<std::string> split_words(const std::string& text);

/// The text as one word of a shell.
std::string quoted(const std::string& text);

/// What became of one task of a job array.
struct TaskState {
  std::string state;      // "CANCELLED", as Slurm calls it
  std::string node;       // empty: it was never begun
  std::string exit_code;  // "1:0": code and signal

  friend bool operator==(const TaskState&, const TaskState&) = default;
};

/// The tasks in what `scontrol --oneliner show job` prints of an array.
std::map<int, TaskState> parse_task_states(const std::string& text);

/// The state that the log of a task tells if Slurm ended it: it writes why. Nothing if it did not.
std::optional<std::string> state_in_log(const std::string& log);

/// "was cancelled", "ran out of its time limit", "was lost with its node", ...
std::string words_for(const TaskState& task);

}  // namespace concord::compare::slurm
