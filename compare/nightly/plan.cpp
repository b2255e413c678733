#include "compare/nightly/plan.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <system_error>

#include "common/error.h"
#include "common/reading/text_file.h"
#include "compare/report/files.h"

namespace concord::compare::nightly {

namespace {

namespace fs = std::filesystem;
using PlanJson = nlohmann::ordered_json;

constexpr int kPlanFormat = 1;

PlanJson command_json(const NightlyCommand& command) {
  return {{"suite", command.suite.string()},
          {"only", command.only},
          {"minutes", command.minutes ? PlanJson(*command.minutes) : PlanJson(nullptr)},
          {"history", command.history.string()},
          {"json", command.json.string()},
          {"junit", command.junit.string()},
          {"markdown", command.markdown.string()},
          {"report", command.report.string()},
          {"out", command.out.string()},
          {"notify", command.notify},
          {"today", command.today}};
}

NightlyCommand command_from(const PlanJson& document) {
  const auto text = [&](const char* key) { return document.at(key).get<std::string>(); };
  NightlyCommand command;
  command.suite = text("suite");
  command.only = text("only");
  if (!document.at("minutes").is_null()) command.minutes = document.at("minutes").get<double>();
  command.history = text("history");
  command.json = text("json");
  command.junit = text("junit");
  command.markdown = text("markdown");
  command.report = text("report");
  command.out = text("out");
  command.notify = text("notify");
  command.today = text("today");
  return command;
}

ClusterPlan plan_from(const PlanJson& document) {
  ClusterPlan plan;
  plan.program = document.at("program");
  plan.command = command_from(document.at("command"));
  plan.where = document.at("where").get<std::string>();
  const PlanJson& origin = document.at("origin");
  plan.origin = {origin.at("version"), origin.at("commit"), origin.at("compiler"), origin.at("machine")};
  plan.started = document.at("started");
  plan.started_s = document.at("started_s");
  plan.night = document.at("night");
  plan.is_resumed = document.at("is_resumed");
  plan.tasks = document.at("tasks");
  return plan;
}

fs::path task_file(const fs::path& folder, int task) { return folder / fmt::format("task-{}.json", task); }

/// What the file holds; nothing if it is not there, or no such document.
template <class Value, class Read>
std::optional<Value> read_if_there(const fs::path& file, const Read& read) {
  std::error_code unknown;
  if (!fs::is_regular_file(file, unknown)) return std::nullopt;
  try {
    return read(PlanJson::parse(read_text_file(file)));
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

}  // namespace

void write_plan(const fs::path& folder, const ClusterPlan& plan) {
  const Origin& from = plan.origin;
  const PlanJson document = {
      {"kind", "concord cluster plan"},
      {"format", kPlanFormat},
      {"program", plan.program},
      {"command", command_json(plan.command)},
      {"where", plan.where.string()},
      {"origin",
       {{"version", from.version}, {"commit", from.commit}, {"compiler", from.compiler}, {"machine", from.machine}}},
      {"started", plan.started},
      {"started_s", plan.started_s},
      {"night", plan.night},
      {"is_resumed", plan.is_resumed},
      {"tasks", plan.tasks}};
  try {
    write_file(folder / "plan.json", document.dump(1) + '\n');
  } catch (const nlohmann::json::type_error&) {
    throw InputError({plan.command.suite.string(), 0, 0},
                     "a path or the name of a case is not UTF-8: jobs of a cluster cannot be told it");
  }
}

ClusterPlan read_plan(const fs::path& folder) {
  const fs::path file = folder / "plan.json";
  try {
    const PlanJson document = PlanJson::parse(read_text_file(file));
    if (document.at("kind") != "concord cluster plan" || document.at("format") != kPlanFormat) {
      throw InputError(
          {file.string(), 0, 0},
          fmt::format("is no plan of a night on a cluster that this program reads (version {})", kPlanFormat));
    }
    return plan_from(document);
  } catch (const nlohmann::json::exception& error) {
    throw InputError({file.string(), 0, 0}, fmt::format("cannot be read: {}", error.what()));
  }
}

void write_jobs(const fs::path& folder, const ClusterJobs& jobs) {
  write_file(folder / "jobs.json", PlanJson{{"array", jobs.array}, {"merge", jobs.merge}}.dump() + '\n');
}

ClusterJobs read_jobs(const fs::path& folder) {
  return read_if_there<ClusterJobs>(folder / "jobs.json",
                                    [](const PlanJson& document) {
                                      return ClusterJobs{document.at("array"), document.at("merge")};
                                    })
      .value_or(ClusterJobs());
}

void write_task(const fs::path& folder, int task, const TaskRecord& record) {
  PlanJson results = PlanJson::array();
  for (const Result& result : record.results) results.push_back(to_json(result));
  const PlanJson document = {{"format", kPlanFormat},
                             {"node", record.node},
                             {"is_finished", record.is_finished},
                             {"results", std::move(results)}};
  write_file(task_file(folder, task), document.dump(-1, ' ', false, PlanJson::error_handler_t::replace) + '\n');
}

std::optional<TaskRecord> read_task(const fs::path& folder, int task) {
  return read_if_there<TaskRecord>(task_file(folder, task), [](const PlanJson& document) {
    TaskRecord record{document.at("node"), document.at("is_finished"), {}};
    for (const PlanJson& one : document.at("results")) record.results.push_back(result_from_json(one));
    return record;
  });
}

std::string task_log_name(int task) { return fmt::format("task-{}.log", task); }

void write_end(const fs::path& folder, const ClusterEnd& end) {
  const PlanJson document = {{"code", end.code}, {"table", end.table}, {"is_complete", end.is_complete}};
  write_file(folder / "ended.json", document.dump(-1, ' ', false, PlanJson::error_handler_t::replace) + '\n');
}

std::optional<ClusterEnd> read_end(const fs::path& folder) {
  return read_if_there<ClusterEnd>(folder / "ended.json", [](const PlanJson& document) {
    return ClusterEnd{document.at("code"), document.at("table"), document.at("is_complete")};
  });
}

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
