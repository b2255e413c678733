#include "compare/report/files.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "common/error.h"

namespace concord::compare {
namespace {

namespace fs = std::filesystem;

class FilesTest : public ::testing::Test {
 protected:
  FilesTest() { fs::create_directories(folder_); }
  ~FilesTest() override { fs::remove_all(folder_); }

  static std::string content(const fs::path& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  }

  fs::path folder_ = fs::path(::testing::TempDir()) /
                     (std::string("concord_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(FilesTest, WritesAndReplacesAndLeavesNothingElse) {
  const fs::path file = folder_ / "a" / "b.txt";
  write_file(file, "one\n");
  write_file(file, "two\n");
  EXPECT_EQ(content(file), "two\n");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "a"), fs::directory_iterator{}), 1);
}

TEST_F(FilesTest, APlaceThatCannotBeWrittenIsBadInput) {
  write_file(folder_ / "file", "text");
  EXPECT_THROW(write_file(folder_ / "file" / "below.txt", "text"), InputError);
  EXPECT_THROW(make_folder(folder_ / "file"), InputError);
  fs::create_directories(folder_ / "taken");
  EXPECT_THROW(write_file(folder_ / "taken", "text"), InputError);
  EXPECT_FALSE(fs::exists(folder_ / "taken.unfinished"));
}

/// The complaint, without the path.
std::string complaint_about(const fs::path& path) {
  try {
    check_target(path);
  } catch (const InputError& error) {
    return error.diagnostics().front().message;
  }
  return "none";
}

TEST_F(FilesTest, OnlyRegularFilesAreReplaced) {
  write_file(folder_ / "file", "text");
  fs::create_symlink(folder_ / "file", folder_ / "link");
  fs::create_symlink(folder_ / "nothing", folder_ / "loose");
  ASSERT_EQ(mkfifo((folder_ / "fifo").c_str(), 0600), 0);
  const std::string end = "; only a regular file is replaced";
  EXPECT_EQ(complaint_about(folder_ / "file"), "none");
  EXPECT_EQ(complaint_about(folder_ / "new"), "none");
  EXPECT_EQ(complaint_about(folder_ / "a" / "b" / "new"), "none");
  EXPECT_EQ(complaint_about(folder_ / "link"), "cannot be written: it is a symbolic link" + end);
  EXPECT_EQ(complaint_about(folder_ / "loose"), "cannot be written: it is a symbolic link" + end);
  EXPECT_EQ(complaint_about(folder_ / "fifo"), "cannot be written: it is a fifo" + end);
  EXPECT_EQ(complaint_about("/dev/null"), "cannot be written: it is a device" + end);
  EXPECT_EQ(complaint_about(folder_), "cannot be written: it is a folder" + end);
  EXPECT_EQ(complaint_about(folder_ / ""), "cannot be written: it names a folder");
  EXPECT_EQ(complaint_about(folder_ / "file" / "x"),
            "cannot be written: '" + (folder_ / "file").string() + "' is no folder");
  EXPECT_EQ(complaint_about("/proc/new"), "cannot be written: No such file or directory");
  for (const char* name : {"link", "loose", "fifo"}) {
    EXPECT_THROW(write_file(folder_ / name, "x"), InputError);
    EXPECT_THROW(UnfinishedFile{folder_ / name}, InputError);
  }
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_TRUE(fs::is_fifo(folder_ / "fifo"));
  EXPECT_EQ(content(folder_ / "file"), "text");
  EXPECT_FALSE(fs::exists(folder_ / "a"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator{}), 4);  // no trace of the probes
}

TEST_F(FilesTest, TwoMayWriteTheSameFileAtOnce) {
  UnfinishedFile one(folder_ / "verdict");
  UnfinishedFile two(folder_ / "verdict");
  EXPECT_NE(one.path(), two.path());
  std::ofstream(one.path()) << "one";
  std::ofstream(two.path()) << "two";
  one.finish();
  EXPECT_EQ(content(folder_ / "verdict"), "one");
  two.finish();
  EXPECT_EQ(content(folder_ / "verdict"), "two");
}

/// Its number comes round again, and that must not refuse what another program of that number writes.
TEST_F(FilesTest, WhatAKilledProgramLeftIsNotInTheWay) {
  for (int k = 1; k < 100; ++k) {
    fs::create_directories(folder_ / fmt::format(".results.{}-{}.unfinished", getpid(), k));
    std::ofstream(folder_ / fmt::format("verdict.{}-{}.unfinished", getpid(), k)) << "half";
    std::ofstream(folder_ / fmt::format(".probe.{}-{}.unfinished", getpid(), k));
  }
  StagedFolder staged(folder_);
  write_file(staged.path() / "table", "new");
  staged.finish({});
  write_file(folder_ / "verdict", "new");
  EXPECT_EQ(content(folder_ / "table"), "new");
  EXPECT_EQ(content(folder_ / "verdict"), "new");
}

TEST_F(FilesTest, WhatIsNotFinishedIsRemoved) {
  write_file(folder_ / "verdict", "old");
  {
    UnfinishedFile file(folder_ / "verdict");
    std::ofstream(file.path()) << "half";
    StagedFolder staged(folder_);
    write_file(staged.path() / "table", "half");
  }
  EXPECT_EQ(content(folder_ / "verdict"), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator{}), 1);
}

TEST_F(FilesTest, StagedFilesReplaceTheOldOnesTogether) {
  for (const char* name : {"table", "plot", "note"}) write_file(folder_ / name, "old");
  StagedFolder staged(folder_);
  write_file(staged.path() / "table", "new");
  write_file(staged.path() / "motion", "new");
  EXPECT_EQ(content(folder_ / "table"), "old");
  staged.finish({"table", "plot", "never there"});
  EXPECT_EQ(content(folder_ / "table"), "new");
  EXPECT_EQ(content(folder_ / "motion"), "new");
  EXPECT_FALSE(fs::exists(folder_ / "plot"));
  EXPECT_EQ(content(folder_ / "note"), "old");
}

TEST_F(FilesTest, StagedFilesReplaceNoneIfOneCannot) {
  write_file(folder_ / "a", "old");
  fs::create_symlink(folder_ / "a", folder_ / "b");
  StagedFolder staged(folder_);
  write_file(staged.path() / "a", "new");
  write_file(staged.path() / "b", "new");
  EXPECT_THROW(staged.finish({}), InputError);
  EXPECT_EQ(content(folder_ / "a"), "old");
}

TEST_F(FilesTest, AFullDiskIsNoBadInput) {
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit small = before;
  small.rlim_cur = 100;
  setrlimit(RLIMIT_FSIZE, &small);
  std::string said = "nothing";
  try {
    write_file(folder_ / "long", std::string(100000, 'x'));
  } catch (const InputError&) {
    said = "bad input";
  } catch (const std::runtime_error& error) {
    said = error.what();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(said, (folder_ / "long").string() + ": cannot be written: File too large");
  EXPECT_TRUE(fs::is_empty(folder_));
}

}  // namespace
}  // namespace concord::compare
