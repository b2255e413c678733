#include "compare/nightly/plan.h"

#include <fmt/format.h>

#include <system_error>

#include "common/error.h"
#include "common/reading/text_file.h"
#include "compare/nightly/record.h"
#include "compare/report/files.h"

namespace concord::compare::nightly {

CONCORD_RECORD(NightlyCommand, suite, only, minutes, history, json, junit, markdown, report, out, notify, today)
CONCORD_RECORD(ClusterPlan, program, command, where, origin, started, started_s, night, is_resumed, tasks)
CONCORD_RECORD(ClusterJobs, array, merge)
CONCORD_RECORD(TaskRecord, node, is_finished, results)
CONCORD_RECORD(ClusterEnd, code, table, is_complete)

namespace {

namespace fs = std::filesystem;

constexpr const char* kPlanKind = "concord cluster plan";
constexpr int kPlanFormat = 1;

fs::path task_file(const fs::path& folder, int task) { return folder / fmt::format("task-{}.json", task); }

template <class Kept>
void write_record(const fs::path& file, const Kept& one) {
  write_file(file, dumped(one) + '\n');
}

/// What the file holds; nothing if it is not there, or no such record.
template <class Kept>
std::optional<Kept> read_if_there(const fs::path& file) {
  std::error_code unknown;
  if (!fs::is_regular_file(file, unknown)) return std::nullopt;
  try {
    return Json::parse(read_text_file(file)).get<Kept>();
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

}  // namespace

void write_plan(const fs::path& folder, const ClusterPlan& plan) {
  Json document{{"kind", kPlanKind}, {"format", kPlanFormat}};
  document.update(Json(plan));
  try {
    write_file(folder / "plan.json", document.dump(1) + '\n');
  } catch (const Json::type_error&) {
    throw InputError({plan.command.suite.string(), 0, 0},
                     "a path or the name of a case is not UTF-8: jobs of a cluster cannot be told it");
  }
}

ClusterPlan read_plan(const fs::path& folder) {
  const fs::path file = folder / "plan.json";
  try {
    const Json document = Json::parse(read_text_file(file));
    if (document.at("kind") != kPlanKind || document.at("format") != kPlanFormat) {
      throw InputError(
          {file.string(), 0, 0},
          fmt::format("is no plan of a night on a cluster that this program reads (version {})", kPlanFormat));
    }
    return document.get<ClusterPlan>();
  } catch (const Json::exception& error) {
    throw InputError({file.string(), 0, 0}, fmt::format("cannot be read: {}", error.what()));
  }
}

void write_jobs(const fs::path& folder, const ClusterJobs& jobs) { write_record(folder / "jobs.json", jobs); }

ClusterJobs read_jobs(const fs::path& folder) {
  return read_if_there<ClusterJobs>(folder / "jobs.json").value_or(ClusterJobs());
}

void write_task(const fs::path& folder, int task, const TaskRecord& record) {
  write_record(task_file(folder, task), record);
}

std::optional<TaskRecord> read_task(const fs::path& folder, int task) {
  return read_if_there<TaskRecord>(task_file(folder, task));
}

std::string task_log_name(int task) { return fmt::format("task-{}.log", task); }

void write_end(const fs::path& folder, const ClusterEnd& end) { write_record(folder / "ended.json", end); }

std::optional<ClusterEnd> read_end(const fs::path& folder) { return read_if_there<ClusterEnd>(folder / "ended.json"); }

fs::path make_numbered_folder(const fs::path& place) {
  make_folder(place);
  for (int k = 1;; ++k) {
    std::error_code trouble;
    if (fs::create_directory(place / std::to_string(k), trouble)) return place / std::to_string(k);
    if (trouble) throw InputError({place.string(), 0, 0}, "no folder can be made in it: " + trouble.message());
  }
}

void remove_task_files(const fs::path& folder, std::size_t tasks) {
  for (std::size_t k = 0; k < tasks; ++k) {
    std::error_code ignored;
    fs::remove(task_file(folder, static_cast<int>(k)), ignored);
    fs::remove(folder / task_log_name(static_cast<int>(k)), ignored);
  }
}

}  // namespace concord::compare::nightly
