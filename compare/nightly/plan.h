#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "compare/nightly/command.h"
#include "compare/nightly/result.h"
#include "compare/report/origin.h"

/// The folder by which the jobs of one night on a cluster know of each other. Every file in it is there in full or not
/// at all.
namespace concord::compare::nightly {

/// What was submitted.
struct ClusterPlan {
  std::string program;          // build_words() of the one that submitted
  NightlyCommand command;       // of the merge: every path but the suite's is absolute
  std::filesystem::path where;  // the user stood: messages name the suite and its models from there
  Origin origin;
  std::string started;  // "2026-11-22 23:14:05", UTC
  long started_s = 0;   // the same, in seconds since 1970
  long night = 0;       // in the history; 0: there is none
  bool is_resumed = false;
  std::vector<std::vector<std::string>> tasks;  // names of their cases
};

/// Throws InputError for a name or path that is not UTF-8.
void write_plan(const std::filesystem::path& folder, const ClusterPlan& plan);
/// Throws InputError if there is none, or one of another version.
ClusterPlan read_plan(const std::filesystem::path& folder);

/// The two jobs; 0: not submitted yet.
struct ClusterJobs {
  long array = 0;
  long merge = 0;
};
void write_jobs(const std::filesystem::path& folder, const ClusterJobs& jobs);
/// Zeros if nothing can be read.
ClusterJobs read_jobs(const std::filesystem::path& folder);

/// What a task has done so far.
struct TaskRecord {
  std::string node;
  bool is_finished = false;
  std::vector<Result> results;
};
void write_task(const std::filesystem::path& folder, int task, const TaskRecord& record);
/// Nothing if the task has left none, or one that cannot be read.
std::optional<TaskRecord> read_task(const std::filesystem::path& folder, int task);
std::string task_log_name(int task);

/// What the merge printed, and with which code it ended.
struct ClusterEnd {
  int code = 0;
  std::string table;         // empty: it could not report
  bool is_complete = false;  // all cases have results, which are in the history; the tasks' files are gone
};
void write_end(const std::filesystem::path& folder, const ClusterEnd& end);
std::optional<ClusterEnd> read_end(const std::filesystem::path& folder);

/// Makes a new folder of a number within `place`.
std::filesystem::path make_numbered_folder(const std::filesystem::path& place);

/// Removes what the tasks left: it is in the history.
void remove_task_files(const std::filesystem::path& folder, std::size_t tasks);

}  // namespace concord::compare::nightly
