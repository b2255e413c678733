#include "compare/workers/pool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <vector>

using namespace concord::compare::workers;
using testing::HasSubstr;

namespace {

/// What a task does is its input.
std::string misbehave(const std::string& input) {
  std::fprintf(stderr, "doing %s\n", input.c_str());
  if (input == "crash") std::raise(SIGSEGV);
  if (input == "abort") std::abort();
  if (input == "leave") _exit(7);
  if (input == "throw") throw std::runtime_error("no such thing");
  if (input == "spin") {
    for (volatile long k = 0;;) k = k + 1;
  }
  if (input == "eat") {
    std::vector<std::vector<char>> eaten;
    while (true) eaten.emplace_back(std::size_t{1} << 20, 'x');
  }
  if (input == "talk") {
    for (int k = 0; k < 100000; ++k) std::fprintf(stderr, "line %d\n", k);
    std::abort();
  }
  return "did " + input;
}

constexpr Limits kShort{.seconds = 0.3, .megabytes = 200.0};

std::vector<Report> do_all(const std::vector<std::string>& inputs, int workers, const Task& task = misbehave,
                           Limits limits = kShort) {
  Pool pool(task, workers, limits);
  std::vector<Report> reports;
  std::size_t given = 0;
  pool.run([&]() { return given < inputs.size() ? std::optional(inputs[given++]) : std::nullopt; },
           [&](std::size_t number, const Report& report) {
             EXPECT_EQ(number, reports.size());
             reports.push_back(report);
           });
  return reports;
}

std::string described(const Report& report) { return to_string(report.end) + "/" + report.answer; }

}  // namespace

TEST(Workers, AnswerInTheOrderOfTheInputsWhateverTheirNumber) {
  std::vector<std::string> inputs;
  for (int k = 0; k < 200; ++k) inputs.push_back(std::to_string(k));
  const Task uneven = [](const std::string& input) {
    if (std::stoi(input) % 7 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(3));
    return "did " + input;
  };
  for (const int workers : {1, 2, 5}) {
    const std::vector<Report> reports = do_all(inputs, workers, uneven);
    ASSERT_EQ(reports.size(), inputs.size());
    for (std::size_t k = 0; k < inputs.size(); ++k) EXPECT_EQ(reports[k].answer, "did " + inputs[k]);
  }
}

TEST(Workers, CrashIsReportedWithSignalAndLastWordsAndTheRestGoesOn) {
  const std::vector<Report> reports = do_all({"a", "crash", "b", "abort", "leave", "c"}, 1);
  ASSERT_EQ(reports.size(), 6U);
  EXPECT_EQ(described(reports[0]), "answered/did a");
  EXPECT_EQ(reports[1].end, End::crashed);
#ifndef CONCORD_SANITIZED  // its handler leaves by itself
  EXPECT_EQ(reports[1].signal, SIGSEGV);
  EXPECT_EQ(reports[3].signal, SIGABRT);
#endif
  EXPECT_THAT(reports[1].last_words, HasSubstr("doing crash"));
  EXPECT_EQ(described(reports[2]), "answered/did b");
  EXPECT_EQ(reports[3].end, End::crashed);
  EXPECT_EQ(reports[4].end, End::crashed);
  EXPECT_EQ(reports[4].signal, 0);
  EXPECT_EQ(described(reports[5]), "answered/did c");
}

/// A terminal sends them to all processes of a program at once.
TEST(Workers, SignalsThatEndTheirOwnerAreNoCrash) {
  const Task stopped = [](const std::string& input) {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::raise(signal);
    return input;
  };
  for (const Report& report : do_all({"a", "b"}, 1, stopped)) EXPECT_EQ(report.end, End::answered);
}

TEST(Workers, HangIsEndedAndReported) {
  const std::vector<Report> reports = do_all({"a", "spin", "b"}, 2);
  ASSERT_EQ(reports.size(), 3U);
  EXPECT_EQ(reports[1].end, End::hung);
  EXPECT_THAT(reports[1].last_words, HasSubstr("doing spin"));
  EXPECT_EQ(described(reports[2]), "answered/did b");
}

TEST(Workers, TaskThatOnlySleepsIsEndedByTheClockOnTheWall) {
  const Task sleeper = [](const std::string& input) {
    if (input == "sleep") std::this_thread::sleep_for(std::chrono::hours(1));
    return input;
  };
  const std::vector<Report> reports = do_all({"sleep", "b"}, 1, sleeper, {.seconds = 0.02, .megabytes = 200.0});
  EXPECT_EQ(reports[0].end, End::hung);
  EXPECT_EQ(reports[1].end, End::answered);
}

#ifndef CONCORD_SANITIZED  // limits of memory do not hold with shadow memory
TEST(Workers, EatingMemoryIsReportedAndTheRestGoesOn) {
  const std::vector<Report> reports = do_all({"eat", "b"}, 1, misbehave, {.seconds = 20.0, .megabytes = 200.0});
  EXPECT_EQ(reports[0].end, End::out_of_memory);
  EXPECT_EQ(described(reports[1]), "answered/did b");
}
#endif

/// What starting a thread throws where its stack finds no room.
TEST(Workers, ThreadWithoutRoomIsOutOfMemory) {
  const Task starter = [](const std::string& input) {
    if (input == "start") throw std::system_error(EAGAIN, std::generic_category());
    return input;
  };
  const std::vector<Report> reports = do_all({"start", "b"}, 1, starter);
  EXPECT_EQ(reports[0].end, End::out_of_memory);
  EXPECT_EQ(described(reports[1]), "answered/b");
}

TEST(Workers, ExceptionIsAnAnswerOfItsOwn) {
  const std::vector<Report> reports = do_all({"throw", "b"}, 1);
  EXPECT_EQ(described(reports[0]), "threw/no such thing");
  EXPECT_EQ(described(reports[1]), "answered/did b");
}

TEST(Workers, OnlyTheLastWordsOfATalkerAreKept) {
  const std::vector<Report> reports = do_all({"talk"}, 1, misbehave, {.seconds = 20.0, .megabytes = 200.0});
  EXPECT_EQ(reports[0].end, End::crashed);
  EXPECT_LE(reports[0].last_words.size(), 4096U);
  EXPECT_THAT(reports[0].last_words, HasSubstr("line 99999"));
}

TEST(Workers, LongInputsAndAnswersArriveWhole) {
  const Task echo = [](const std::string& input) { return input + input; };
  std::string text;
  for (int k = 0; k < 300000; ++k) text += static_cast<char>('a' + k % 26);
  const std::vector<Report> reports = do_all({text, ""}, 1, echo, {.seconds = 20.0, .megabytes = 200.0});
  EXPECT_EQ(reports[0].answer, text + text);
  EXPECT_EQ(reports[1].answer, "");
}

TEST(WorkersApart, EachTaskHasAProcessAndLimitsOfItsOwnAndTellsWhenItEnds) {
  static int tasks_of_process = 0;
  const Task task = [](const std::string& input) {
    ++tasks_of_process;
    if (input == "slow") std::this_thread::sleep_for(std::chrono::milliseconds(200));
    return misbehave(input) + " as task " + std::to_string(tasks_of_process);
  };
  const std::vector<std::string> inputs{"slow", "a", "spin", "crash", "b"};
  std::vector<std::size_t> order;
  std::vector<Report> reports(inputs.size());
  std::size_t given = 0;
  std::size_t started = 0;
  const Watch watch{[&](std::size_t number) { EXPECT_EQ(number, started++); },
                    [&](std::size_t number, const Report& report) {
                      order.push_back(number);
                      reports[number] = report;
                    },
                    [] {}};
  Pool(task, 2, {})
      .run_apart(
          [&]() -> std::optional<Assignment> {
            if (given == inputs.size()) return std::nullopt;
            const double seconds = inputs[given] == "spin" ? 0.1 : 30.0;
            return Assignment{inputs[given++], {.seconds = seconds, .megabytes = 200.0}};
          },
          watch);
  ASSERT_EQ(order.size(), inputs.size());
  EXPECT_EQ(started, inputs.size());
  EXPECT_NE(order.front(), 0U);  // the slow one keeps nobody waiting
  EXPECT_EQ(described(reports[0]), "answered/did slow as task 1");
  EXPECT_EQ(described(reports[1]), "answered/did a as task 1");
  EXPECT_EQ(reports[2].end, End::hung);
  EXPECT_EQ(reports[3].end, End::crashed);
  EXPECT_EQ(described(reports[4]), "answered/did b as task 1");
}
