#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "compare/nightly/case.h"
#include "compare/nightly/command.h"
#include "compare/nightly/plan.h"
#include "compare/report/console.h"

/// How a night is given to a cluster (compare/nightly/cluster), and waited for.
namespace concord::compare::nightly {

/// Takes `--wait` out of the words for sbatch and returns whether it was there. Throws InputError for an option of
/// concord's own, and for one that concord sets itself.
bool take_slurm_words(std::vector<std::string>& words);

/// Shares the cases out, the longest first by the wall time that they took (`wall_times`, by name), so that tasks take
/// about the same time. Each case has a task of its own if `most` allows it.
std::vector<std::vector<const Case*>> deal_cases(std::vector<const Case*> cases, std::size_t most,
                                                 const std::map<std::string, double>& wall_times);

/// What one task may use, for sbatch: all of its cases one after the other, with a margin.
std::vector<std::string> limits_of_tasks(const std::vector<std::vector<const Case*>>& tasks);

/// Where the folders of a suite's nights are made.
std::filesystem::path cluster_place(const NightlyCommand& command);

/// Submits the tasks; the plan stands in the folder.
long submit_tasks(const std::filesystem::path& folder, const NightlyCommand& command,
                  const std::vector<std::vector<const Case*>>& tasks);
/// Submits the merge, which begins when the tasks have ended.
long submit_merge(const std::filesystem::path& folder, const NightlyCommand& command, long array);

/// Which jobs were submitted, where results will stand, and how to follow and stop them.
std::string submission_words(const std::filesystem::path& folder, const NightlyCommand& command,
                             const ClusterJobs& jobs, std::size_t cases, std::size_t tasks);

/// Until the merge has ended: tells how many tasks are done, prints its table and returns its code. Throws SlurmError
/// if it is lost.
int wait_for_merge(const std::filesystem::path& folder, const ClusterJobs& jobs, std::size_t tasks,
                   const Console& console);

}  // namespace concord::compare::nightly
