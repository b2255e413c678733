#include "compare/nightly/cluster.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "common/error.h"
#include "compare/nightly/submission.h"
#include "compare/report/files.h"
#include "tests/unit/temporary_folder.h"

namespace concord::compare::nightly {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Case case_called(const std::string& id, double seconds = 600.0, double megabytes = 4096.0) {
  Case one;
  one.id = id;
  one.limits.seconds = seconds;
  one.limits.megabytes = megabytes;
  return one;
}

Result green(const std::string& id) {
  Result result;
  result.id = id;
  result.work = "compare";
  result.definition = "as asked";
  result.ending = Ending::agree;
  result.words = "a \"word\"\n\xff";
  result.judged = 3;
  result.wall_s = 1.0 / 3.0;
  return result;
}

std::string refusal_of(std::vector<std::string> words) {
  try {
    take_slurm_words(words);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::vector<std::string> names_of(const std::vector<const Case*>& task) {
  std::vector<std::string> names;
  for (const Case* one : task) names.push_back(one->id);
  return names;
}

/// A plan of two tasks in a folder, and a history with a night of its own.
class ClusterNight : public ::testing::Test {
 protected:
  ClusterNight() : history_(folder_.path() / "h.sqlite") {
    plan_.command.suite = "/some/suite's place.toml";
    plan_.command.minutes = 1.5;
    plan_.where = "/some";
    plan_.command.notify = "mail me";
    plan_.origin = {"concord 1", "abc", "clang", "Slurm cluster x"};
    plan_.started = "2026-11-23 02:15:00";
    plan_.night = 7;
    plan_.tasks = {{"a", "b"}, {"c|'ü"}};
    night_ = history_.begin("suite", "", plan_.origin, plan_.started);
  }

  bool merge() {
    std::ostringstream out;
    const bool is_complete =
        merge_tasks(place_, plan_, {&cases_[0], &cases_[1], &cases_[2]}, night_, history_, {out, out});
    told_ = out.str();
    return is_complete;
  }

  TemporaryFolder folder_;
  std::filesystem::path place_ = folder_.path() / "1";
  History history_;
  ClusterPlan plan_;
  long night_ = 0;
  std::vector<Case> cases_{case_called("a"), case_called("b"), case_called("c|'ü")};
  std::string told_;
};

}  // namespace

/// Finds an option of concord's own that sbatch would take for an abbreviation of another (--out).
TEST(ClusterWords, OwnOptionsDoNotGoToSbatch) {
  EXPECT_THAT(refusal_of({"--time=3", "--out", "x"}), HasSubstr("write concord's option --out before it"));
  EXPECT_THAT(refusal_of({"--history=h"}), HasSubstr("--history"));
  EXPECT_THAT(refusal_of({"-a0-3"}), HasSubstr("concord itself tells sbatch --array"));
  EXPECT_THAT(refusal_of({"--output=x"}), HasSubstr("--output"));
  std::vector<std::string> words{"--partition=a", "-W", "--wait", "-p", "b"};
  EXPECT_TRUE(take_slurm_words(words));
  EXPECT_THAT(words, ElementsAre("--partition=a", "-p", "b"));
  EXPECT_FALSE(take_slurm_words(words));
}

/// Finds cases that are lost or done twice when there are more than an array may have, and long ones in one task.
TEST(ClusterTasks, EveryCaseIsInOneTaskAndTheLongOnesApart) {
  std::vector<Case> all;
  for (const char* id : {"a", "b", "c", "d", "e"}) all.push_back(case_called(id));
  std::vector<const Case*> cases;
  for (const Case& one : all) cases.push_back(&one);
  const std::map<std::string, double> times{{"a", 1.0}, {"b", 50.0}, {"c", 2.0}, {"d", 60.0}, {"e", 3.0}};
  const auto tasks = deal_cases(cases, 2, times);
  ASSERT_EQ(tasks.size(), 2U);
  EXPECT_THAT(names_of(tasks[0]), ElementsAre("d", "e", "a"));
  EXPECT_THAT(names_of(tasks[1]), ElementsAre("b", "c"));
  EXPECT_EQ(deal_cases(cases, 1001, {}).size(), 5U);
}

/// Finds limits of one case given to a task of several.
TEST(ClusterTasks, LimitsAreThoseOfTheLargestTask) {
  const Case small = case_called("a", 60.0, 100.0);
  const Case large = case_called("b", 600.0, 1000.0);
  EXPECT_THAT(limits_of_tasks({{&small}, {&small, &large}}), ElementsAre("--time=19", "--mem-per-cpu=1512"));
  const Case endless = case_called("c", 1e18, 1e18);
  EXPECT_THAT(limits_of_tasks({{&endless}}), ElementsAre("--time=525600", "--mem-per-cpu=1000000000"));
}

TEST_F(ClusterNight, PlanIsReadAsItWasWritten) {
  plan_.command.report = "/there/night.html";
  write_plan(place_, plan_);
  const ClusterPlan read = read_plan(place_);
  EXPECT_EQ(read.command.suite, plan_.command.suite);
  EXPECT_EQ(read.where, plan_.where);
  EXPECT_EQ(read.command.minutes, plan_.command.minutes);
  EXPECT_EQ(read.command.notify, "mail me");
  EXPECT_EQ(read.command.report, "/there/night.html");
  EXPECT_EQ(read.origin, plan_.origin);
  EXPECT_EQ(read.night, 7);
  EXPECT_EQ(read.tasks, plan_.tasks);
  plan_.tasks[0][0] = "not UTF-8: \xff";
  EXPECT_THROW(write_plan(place_, plan_), InputError);
  write_file(place_ / "plan.json", "{\"kind\":\"concord cluster plan\",\"format\":2}");
  EXPECT_THROW(read_plan(place_), InputError);
}

/// Finds a lost task that passes for done, and results of a task that are lost with its last case.
TEST_F(ClusterNight, LostTasksAreNamedAndWhatTheyHadDoneIsKept) {
  write_task(place_, 0, {"node1", false, {green("a")}});
  write_file(place_ / task_log_name(0),
             "1 done\nslurmstepd: error: *** JOB 9 ON node1 CANCELLED AT x DUE TO TIME LIMIT ***\n");
  EXPECT_FALSE(merge());
  EXPECT_THAT(told_, HasSubstr("2 tasks: 0 left all their results, 2 were lost"));
  EXPECT_EQ(history_.find(night_, "a")->ending, Ending::agree);
  EXPECT_EQ(history_.find(night_, "a")->definition, "as asked");
  EXPECT_EQ(history_.find(night_, "a")->wall_s, 1.0 / 3.0);
  EXPECT_EQ(history_.find(night_, "b")->ending, Ending::not_run);
  EXPECT_EQ(history_.find(night_, "b")->words, "lost: task 0 on node1 ran out of its time limit");
  EXPECT_THAT(history_.find(night_, "c|'ü")->words, HasSubstr("lost: task 1 left no result"));
  EXPECT_EQ(history_.definitions(night_).size(), 1U);  // what --resume does not run again
}

TEST_F(ClusterNight, NightIsCompleteWhenEveryCaseHasAResult) {
  write_task(place_, 0, {"node1", true, {green("b"), green("a")}});
  write_task(place_, 1, {"node2", true, {green("c|'ü")}});
  EXPECT_TRUE(merge());
  remove_task_files(place_, 2);
  EXPECT_EQ(read_task(place_, 0), std::nullopt);
}

/// Finds a second merge that puts losses in the place of results.
TEST_F(ClusterNight, LossNeverReplacesAResult) {
  for (const char* id : {"a", "b", "c|'ü"}) history_.store(night_, green(id));
  EXPECT_TRUE(merge());
  EXPECT_EQ(history_.find(night_, "b")->ending, Ending::agree);
}

/// Finds a half-written or foreign file that passes for a result.
TEST_F(ClusterNight, FileThatIsNoResultIsALostTask) {
  write_task(place_, 0, {"node1", true, {green("b"), green("a")}});
  write_file(place_ / "task-1.json", "{\"format\":1,\"node\":\"node2\",\"is_fin");
  EXPECT_FALSE(merge());
  EXPECT_THAT(history_.find(night_, "c|'ü")->words, HasSubstr("lost: task 1"));
}

/// Finds a time that is up which is told as a loss.
TEST_F(ClusterNight, FinishedTaskThatLeftCasesOutHadNoTime) {
  write_task(place_, 0, {"node1", true, {green("b")}});
  write_task(place_, 1, {"node2", true, {green("c|'ü")}});
  EXPECT_FALSE(merge());
  EXPECT_EQ(history_.find(night_, "a")->words, "the time of the night was up");
}

/// Finds two submissions that share a folder.
TEST_F(ClusterNight, EverySubmissionHasAFolderOfItsOwn) {
  const std::filesystem::path place = folder_.path() / "h.sqlite.slurm";
  EXPECT_EQ(make_numbered_folder(place), place / "1");
  EXPECT_EQ(make_numbered_folder(place), place / "2");
}

/// Finds results that a lost merge did not read, and that would be run again.
TEST_F(ClusterNight, WhatTasksLeftIsReadWithoutAMerge) {
  write_task(place_, 1, {"node2", false, {green("c|'ü")}});
  EXPECT_EQ(store_task_results(place_, plan_, {&cases_[0], &cases_[2]}, night_, history_), 1);
  EXPECT_EQ(history_.definitions(night_).size(), 1U);
}

/// Finds a submission that failed and leaves an empty night behind.
TEST_F(ClusterNight, WithdrawnNightIsGone) {
  history_.store(night_, green("a"));
  history_.withdraw(night_);
  EXPECT_TRUE(history_.nights().empty());
  EXPECT_EQ(history_.find(night_, "a"), std::nullopt);
}

/// Finds a night on a cluster that its own program cannot go on with at home.
TEST_F(ClusterNight, StoppedNightGoesOnWithoutACluster) {
  history_.take_over(night_, cluster_process(place_));
  Origin here = plan_.origin;
  here.machine = "this one";
  EXPECT_EQ(history_.stopped_night("suite", here).value().id, night_);
  EXPECT_EQ(cluster_folder(history_.process_of(night_)), place_);
  here.commit = "another";
  EXPECT_FALSE(history_.stopped_night("suite", here));
}

}  // namespace concord::compare::nightly
