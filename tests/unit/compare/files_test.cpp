#include "compare/files.h"

#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

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

}  // namespace
}  // namespace concord::compare
