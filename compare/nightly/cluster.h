#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "compare/nightly/case.h"
#include "compare/nightly/history.h"
#include "compare/nightly/plan.h"
#include "compare/report/console.h"
#include "compare/states/branch.h"

/// A night as two jobs of Slurm: an array, each task of which runs some of the cases and leaves a file, and a merge
/// that reads the files when all tasks have ended, however they did. Only the submission and the merge touch the
/// history.
namespace concord::compare::nightly {

/// What stands as the process of a night in the history while its jobs do it; and back.
std::string cluster_process(const std::filesystem::path& folder);
std::optional<std::filesystem::path> cluster_folder(const std::string& process);
/// Whether the jobs of the folder wait or run.
bool is_cluster_running(const std::filesystem::path& folder);

/// The machine of a night on a cluster; whether it is one.
std::string cluster_machine(const std::string& name);
bool is_cluster_machine(const std::string& machine);

/// What one task of the array does: the cases of its number, one after the other. A task that is begun again does not
/// repeat what it has done.
int run_cluster_task(const NightlyCommand& command, const SolverMakers& makers, const Console& console);

/// Stores what the tasks left, by the names of the cases; nothing is said of others. Returns how many.
int store_task_results(const std::filesystem::path& folder, const ClusterPlan& plan,
                       const std::vector<const Case*>& cases, long night, History& history);

/// The same, and a row for each case of a lost task: not run, with what became of the task. Returns whether all cases
/// have a result.
bool merge_tasks(const std::filesystem::path& folder, const ClusterPlan& plan, const std::vector<const Case*>& cases,
                 long night, History& history, const Console& console);

}  // namespace concord::compare::nightly
