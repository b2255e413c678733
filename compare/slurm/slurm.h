#pragma once

#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "compare/slurm/words.h"

/// Slurm through its own commands: sbatch, scontrol, squeue, scancel. Needs no accounting database.
namespace concord::compare::slurm {

/// Slurm does not answer, or says what nobody expects.
class SlurmError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Cluster {
  std::string name;
  int most_tasks = 0;  // of one job array
};

/// Throws InputError if there is no Slurm on this machine, SlurmError if its controller does not answer.
Cluster find_cluster();

/// A batch job: what sbatch is told.
struct Job {
  std::filesystem::path folder;       // where it runs, and its script and log are written
  std::string script;                 // name of the script's file
  std::string command;                // of the shell
  std::vector<std::string> defaults;  // "--time=10": count unless an option or the environment says otherwise
  std::vector<std::string> options;   // the user's
  std::vector<std::string> fixed;     // count whatever else is said
};

/// Writes the script and gives it to sbatch; returns the job's number. Throws InputError with sbatch's own words if it
/// refuses the job, SlurmError if it cannot reach the controller.
long submit(const Job& job);

/// Whatever Slurm says to that.
void cancel(long job);

/// Whether the job waits or runs. A job that Slurm does not know has ended. Throws SlurmError if that cannot be told.
bool is_alive(long job);

/// Why the job, or some task of it, waits: "Resources", "PartitionTimeLimit", ...; empty if nothing waits.
std::string why_it_waits(long job);

/// All tasks of an array that Slurm still remembers.
std::map<int, TaskState> task_states(long array);

}  // namespace concord::compare::slurm
