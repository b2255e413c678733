#include "compare/report/feed_command.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include "common/reading/text_file.h"
#include "compare/report/files.h"
#include "tests/unit/temporary_folder.h"

namespace concord::compare {
namespace {

TEST(FeedCommand, GivesTheTextAndTellsTheEnd) {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "text").string();
  write_file(file, "");
  const FedCommand fed = feed_command("cat > '" + file + "'", "what is said\n");
  EXPECT_EQ(fed.status, 0);
  EXPECT_TRUE(fed.has_read);
  EXPECT_EQ(read_text_file(file), "what is said\n");
  EXPECT_EQ(WEXITSTATUS(feed_command("cat > /dev/null; exit 7", "x").status), 7);
}

TEST(FeedCommand, OutlivesACommandThatDoesNotRead) {
  const FedCommand fed = feed_command("exec 0<&-; exit 3", std::string(1 << 20, 'x'));
  EXPECT_EQ(WEXITSTATUS(fed.status), 3);
  EXPECT_FALSE(fed.has_read);
}

}  // namespace
}  // namespace concord::compare
