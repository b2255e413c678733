#include "compare/nightly/history.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "common/error.h"
#include "compare/report/files.h"
#include "tests/unit/temporary_folder.h"

namespace concord::compare::nightly {
namespace {

using testing::HasSubstr;

const Origin kHere{"concord 1", "abc", "gcc", "this one"};
constexpr const char* kNow = "2026-03-04 05:06:07";

Result result_called(const std::string& id, long evaluations = 100, int components = 1) {
  Result one;
  one.id = id;
  one.work = "compare";
  one.definition = "definition of " + id;
  one.ending = Ending::agree;
  one.cost[1] = {"gbs", 10, evaluations};
  for (int k = 0; k < components; ++k) {
    Component& force = one.components.emplace_back();
    force.name = "force " + std::to_string(k);
    force.same_state = 12.5;
    force.need = {12, 7, 8.5};
    force.scale = 3.0;
  }
  return one;
}

/// What the first version of the program wrote.
void write_first_version(const std::filesystem::path& file) {
  make_folder(file.parent_path());
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  const char* text =
      "CREATE TABLE night(id INTEGER PRIMARY KEY AUTOINCREMENT, suite TEXT NOT NULL, started TEXT NOT NULL, finished "
      "TEXT NOT NULL DEFAULT '', version TEXT NOT NULL, compiler TEXT NOT NULL, machine TEXT NOT NULL);"
      "CREATE TABLE result(id INTEGER PRIMARY KEY, night INTEGER NOT NULL REFERENCES night(id), name TEXT NOT NULL, "
      "work "
      "TEXT NOT NULL, ending TEXT NOT NULL, words TEXT NOT NULL, judged INTEGER NOT NULL, total INTEGER NOT NULL, "
      "steps_cartesian INTEGER NOT NULL, steps_relative INTEGER NOT NULL, evaluations_cartesian INTEGER NOT NULL, "
      "evaluations_relative INTEGER NOT NULL, wall_s REAL NOT NULL, UNIQUE(night, name));"
      "CREATE TABLE component(result INTEGER NOT NULL REFERENCES result(id) ON DELETE CASCADE, name TEXT NOT NULL, "
      "same_state REAL, resolvable REAL, same_run REAL, refined REAL, peak REAL, scale REAL, PRIMARY KEY(result, "
      "name)) "
      "WITHOUT ROWID;"
      "INSERT INTO night VALUES(1, 'old', '2025-01-01 00:00:00', '2025-01-01 01:00:00', 'concord 0', 'gcc', 'there');"
      "INSERT INTO result VALUES(1, 1, 'car', 'compare', 'agree', '', 5, 6, 11, 12, 13, 14, 0.5);"
      "INSERT INTO component VALUES(1, 'F_x', 12.5, NULL, 7.5, NULL, 3.25, 4.5);"
      "PRAGMA application_id = 1668247139; PRAGMA user_version = 1;";
  ASSERT_EQ(sqlite3_exec(database, text, nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
  sqlite3_close(database);
}

TEST(NightCalled, CommitItselfComesBeforeOneThatBeginsSo) {
  const auto night = [](long id, const char* commit) {
    Night one;
    one.id = id;
    one.origin.commit = commit;
    return one;
  };
  const std::vector<Night> nights{night(1, "3f97bf0c1a2b"), night(2, "3f97bf0c1a2b-dirty.5e2a")};
  EXPECT_EQ(night_called("3f97bf0c1a2b", nights).id, 1);
  EXPECT_EQ(night_called("3f97", nights).id, 2);
  EXPECT_EQ(night_called("1", nights).id, 1);
  EXPECT_THROW(night_called("3f9", nights), InputError);
}

}  // namespace

class Histories : public ::testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path file() const { return folder_.path() / "nights.sqlite"; }

  TemporaryFolder folder_;
};

TEST_F(Histories, ResultIsFoundAgain) {
  History history(file());
  const long night = history.begin("smoke", "/x/smoke.toml", kHere, kNow);
  history.store(night, result_called("car", 100, 3));
  history.store(night, result_called("car", 200, 2));  // replaces it
  const Result found = *history.find(night, "car");
  EXPECT_EQ(found.cost[1].evaluations, 200);
  ASSERT_EQ(found.components.size(), 2U);
  EXPECT_EQ(found.components[0].need[2], 8.5);
  EXPECT_FALSE(found.components[0].peak);
  EXPECT_EQ(found.definition, "definition of car");
  EXPECT_FALSE(history.find(night, "bus"));
  EXPECT_EQ(history.nights().back().origin, kHere);
}

TEST_F(Histories, FileOfTheFirstVersionIsBroughtUpToDate) {
  write_first_version(file());
  History history(file());
  const Result old = *history.find(1, "car");
  EXPECT_EQ(old.cost[0].steps, 11);
  EXPECT_EQ(old.cost[1].evaluations, 14);
  EXPECT_EQ(old.components.at(0).peak, 3.25);
  EXPECT_EQ(history.nights().at(0).origin.commit, "unknown");
  const long night = history.begin("old", "", kHere, kNow);
  history.store(night, result_called("car"));
  EXPECT_EQ(History(file()).before(night, "old", "car", 5).size(), 1U);
}

TEST_F(Histories, WhatIsNoHistoryOrOfALaterVersionIsRefused) {
  write_file(folder_.path() / "text.sqlite", "this is a text, and long enough to be none of SQLite's files\n");
  EXPECT_THROW(History(folder_.path() / "text.sqlite"), InputError);
  { History history(file()); }
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file().c_str(), &database), SQLITE_OK);
  sqlite3_exec(database, "PRAGMA user_version = 99", nullptr, nullptr, nullptr);
  sqlite3_close(database);
  try {
    History history(file());
    ADD_FAILURE() << "was opened";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("version 99 of the history is not known: this program reads versions 1 to 3"));
  }
}

TEST_F(Histories, OnlyAStoppedNightOfTheSameProgramThatRunsNoMoreIsResumed) {
  History history(file());
  const long night = history.begin("smoke", "", kHere, kNow);
  EXPECT_FALSE(history.stopped_night("smoke", kHere));  // this process does it
  const pid_t child = fork();
  if (child == 0) {
    History own(file());
    own.take_over(night);
    _exit(0);
  }
  waitpid(child, nullptr, 0);
  EXPECT_EQ(history.stopped_night("smoke", kHere).value().id, night);
  EXPECT_FALSE(history.stopped_night("other", kHere));
  Origin later = kHere;
  later.commit = "def";
  EXPECT_FALSE(history.stopped_night("smoke", later));
  history.finish(night, kNow);
  EXPECT_FALSE(history.stopped_night("smoke", kHere));
}

TEST_F(Histories, EarlierNightsAreThoseThatWereFinished) {
  History history(file());
  for (int k = 0; k < 4; ++k) {
    const long night = history.begin("smoke", "", kHere, kNow);
    history.store(night, result_called("car", 100 + k));
    if (k != 1) history.finish(night, kNow);
  }
  const long tonight = history.begin("smoke", "", kHere, kNow);
  const auto earlier = history.before(tonight, "smoke", "car", 2);
  ASSERT_EQ(earlier.size(), 2U);
  EXPECT_EQ(earlier[0].result.cost[1].evaluations, 103);
  EXPECT_EQ(earlier[1].result.cost[1].evaluations, 102);
}

TEST_F(Histories, TwoProgramsWriteOneFile) {
  constexpr int kCases = 60;
  std::vector<pid_t> children;
  for (int who = 0; who < 2; ++who) {
    const pid_t child = fork();
    if (child == 0) {
      int code = 1;
      try {
        History history(file());
        const long night = history.begin("suite " + std::to_string(who), "", kHere, kNow);
        for (int k = 0; k < kCases; ++k) history.store(night, result_called("case " + std::to_string(k), k, 5));
        history.finish(night, kNow);
        code = 0;
      } catch (...) {
      }
      _exit(code);
    }
    children.push_back(child);
  }
  for (const pid_t child : children) {
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
  }
  History history(file());
  ASSERT_EQ(history.nights().size(), 2U);
  for (const Night& night : history.nights()) {
    EXPECT_EQ(history.definitions(night.id).size(), static_cast<std::size_t>(kCases));
  }
}

TEST_F(Histories, KilledProgramLosesOnlyTheCaseInFlight) {
  { History history(file()); }
  const pid_t child = fork();
  if (child == 0) {
    History history(file());
    const long night = history.begin("smoke", "", kHere, kNow);
    for (int k = 0;; ++k) {
      history.store(night, result_called("case " + std::to_string(k), k, 5));
      if (k == 20) std::ofstream(folder_.path() / "sign") << "now";
    }
  }
  while (!std::filesystem::exists(folder_.path() / "sign")) usleep(1000);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  History history(file());
  const auto stored = history.definitions(1);
  EXPECT_GE(stored.size(), 21U);
  for (std::size_t k = 0; k < stored.size(); ++k) {
    const auto found = history.find(1, "case " + std::to_string(k));
    ASSERT_TRUE(found) << k;
    EXPECT_EQ(found->components.size(), 5U);
  }
}

TEST_F(Histories, FullDiskIsAnErrorAndLosesNothingThatWasStored) {
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{400000, 400000};
    setrlimit(RLIMIT_FSIZE, &limit);
    int code = 1;
    try {
      History history(file());
      const long night = history.begin("smoke", "", kHere, kNow);
      for (int k = 0; k < 100000; ++k) {
        history.store(night, result_called("case " + std::to_string(k), k, 50));
        std::ofstream(folder_.path() / "stored") << k + 1;
      }
    } catch (const DatabaseError& error) {
      code = std::string(error.what()).find("what was stored before stays") != std::string::npos ? 7 : 2;
    } catch (...) {
    }
    _exit(code);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_EQ(WEXITSTATUS(status), 7);
  const auto stored = std::stoul(bytes_of(folder_.path() / "stored"));
  EXPECT_GT(stored, 1U);
  EXPECT_EQ(History(file()).definitions(1).size(), stored);
}

/// Finds a write-ahead log where two computers would each keep their own index of it.
TEST(Databases, NetworkFileSystemsAreKnown) {
  for (const std::uint32_t type : {0x6969U, 0x0bd00bd0U, 0x47504653U, 0x19830326U}) {
    EXPECT_TRUE(is_network_file_system(type));  // NFS, Lustre, GPFS, BeeGFS
  }
  for (const std::uint32_t type : {0xef53U, 0x01021994U, 0x58465342U, 0x9123683eU}) {
    EXPECT_FALSE(is_network_file_system(type));  // ext4, tmpfs, XFS, btrfs
  }
}

}  // namespace concord::compare::nightly
