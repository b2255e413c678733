#include "compare/slurm/words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "common/error.h"

namespace concord::compare::slurm {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string refusal_of(const std::string& text) {
  try {
    split_words(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// Finds words that are split at quoted blanks, or keep their quotes.
TEST(SlurmWords, AreSplitAsAShellDoes) {
  setenv("CONCORD_TEST_WORD", "two words", 1);
  EXPECT_THAT(split_words("  --time=2:00 -p 'a b'  --comment=\"x \\\" y\" "),
              ElementsAre("--time=2:00", "-p", "a b", "--comment=x \" y"));
  EXPECT_THAT(split_words("\"$CONCORD_TEST_WORD\" --nodelist=node[1-2] a\\ b"),
              ElementsAre("two words", "--nodelist=node[1-2]", "a b"));
  EXPECT_TRUE(split_words("").empty());
}

/// Finds a command that is run, and text that is cut off instead of being refused.
TEST(SlurmWords, RefuseWhatAShellWouldNotTakeAsWords) {
  EXPECT_THAT(refusal_of("--time=$(touch /tmp/no)"), HasSubstr("a command in it is not run"));
  EXPECT_THAT(refusal_of("--constraint=a|b"), HasSubstr("outside quotes"));
  EXPECT_THAT(refusal_of("--comment='open"), HasSubstr("is not closed"));
}

/// Finds a quote that ends where the text has one.
TEST(SlurmWords, QuotedTextIsOneWord) {
  for (const std::string text : {"", "a b", "it's $HOME `x` \\ \"y\"", "-n\n;|&<>(){}*?[ü"}) {
    const std::string command = "test " + quoted(text) + " = \"$CONCORD_TEST_WORD\"";
    setenv("CONCORD_TEST_WORD", text.c_str(), 1);
    EXPECT_EQ(std::system(command.c_str()), 0) << text;
  }
}

/// Finds tasks whose state is read from the wrong field, and ranges of tasks that wait.
TEST(SlurmWords, StatesOfTasksAreRead) {
  const std::string text =
      "JobId=20 ArrayJobId=18 ArrayTaskId=3 JobName=a=b JobState=CANCELLED Reason=None ExitCode=0:15 NodeList=node2 \n"
      "JobId=19 ArrayJobId=18 ArrayTaskId=1 JobName=x JobState=FAILED ExitCode=3:0 ReqNodeList=(null) NodeList=node1\n"
      "JobId=18 ArrayJobId=18 ArrayTaskId=5-6,8%2 JobName=x JobState=PENDING ExitCode=0:0 NodeList=(null)\n";
  const auto states = parse_task_states(text);
  ASSERT_EQ(states.size(), 5U);
  EXPECT_EQ(states.at(3), (TaskState{"CANCELLED", "node2", "0:15"}));
  EXPECT_EQ(states.at(1), (TaskState{"FAILED", "node1", "3:0"}));
  for (const int task : {5, 6, 8}) EXPECT_EQ(states.at(task), (TaskState{"PENDING", "", "0:0"}));
  EXPECT_TRUE(parse_task_states("slurm_load_jobs error: Invalid job id specified").empty());
}

TEST(SlurmWords, EveryEndHasItsWords) {
  EXPECT_EQ(words_for({"CANCELLED", "node1", "0:15"}), "was cancelled");
  EXPECT_EQ(words_for({"CANCELLED", "", "0:0"}), "was cancelled before it began");
  EXPECT_EQ(words_for({"TIMEOUT", "node1", "0:0"}), "ran out of its time limit");
  EXPECT_EQ(words_for({"NODE_FAIL", "node1", "0:0"}), "was lost with its node");
  EXPECT_EQ(words_for({"FAILED", "node1", "0:9"}), "was killed by signal 9");
  EXPECT_EQ(words_for({"FAILED", "node1", "2:0"}), "failed with exit code 2");
  EXPECT_EQ(words_for({"SPECIAL_EXIT", "node1", "0:0"}), "ended as SPECIAL_EXIT");
}

/// Slurm writes this into the log of a task that it ends, and forgets the job minutes later.
TEST(SlurmWords, LogTellsWhySlurmEndedATask) {
  const std::string head = "1 of 3 done\nslurmstepd-node1: error: *** JOB 2 ON node1 CANCELLED AT 2026-11-23T16:58:15";
  EXPECT_EQ(state_in_log(head + " ***\n"), "CANCELLED");
  EXPECT_EQ(state_in_log(head + " DUE TO TIME LIMIT ***\n"), "TIMEOUT");
  EXPECT_EQ(state_in_log(head + " DUE TO NODE FAILURE, SEE SLURMCTLD LOG FOR DETAILS ***\n"), "NODE_FAIL");
  EXPECT_EQ(state_in_log("slurmstepd: error: Detected 1 oom-kill event(s) in StepId=2.batch."), "OUT_OF_MEMORY");
  EXPECT_EQ(state_in_log("3 of 3 done, 0 red\n"), std::nullopt);
}

}  // namespace
}  // namespace concord::compare::slurm
