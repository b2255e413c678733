#include "compare/nightly/command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/reading/text_file.h"
#include "compare/nightly/baseline.h"
#include "compare/nightly/history.h"
#include "compare/nightly/tables.h"
#include "compare/report/files.h"
#include "tests/unit/fake_pendulum.h"
#include "tests/unit/temporary_folder.h"

namespace concord::compare::nightly {
namespace {

using testing::HasSubstr;
using testing::Not;

/// The fake's pendulum as a file; its name decides what its solvers do.
const std::string kPendulum = pendulum_file("until = 0.1\nsamples = 50\n");

struct Told {
  int code = 0;
  std::string out;
  std::string err;
};

class Nights : public ::testing::Test {
 protected:
  Nights() {
    for (const char* name : {"sound", "other"}) model(name);
    write("[[case]]\nmodels = [\"models/*.toml\"]\n");
  }

  void model(const std::string& name) { write_file(folder_.path() / "models" / (name + ".toml"), kPendulum); }
  void write(const std::string& text) { write_file(suite_, "format = 1\n" + text); }

  [[nodiscard]] SolverMakers makers() const {
    const auto make = [this](const Model& model, const char* name) -> std::unique_ptr<Solver> {
      if (model.name == "crashing") std::raise(SIGKILL);
      auto solver = std::make_unique<FakePendulum>(model, name);
      if (model.name == "stopping") solver->cannot_integrate = true;
      if (model.name == "differing" && std::string(name) == "relative") {
        solver->spoil = [](const State&, Evaluation& evaluation) {
          evaluation.joints[0].reaction[index(Side::child)].in_C.force(0) += 0.01;
        };
      }
      const double factor = factor_;
      solver->spoil_run = [factor](Trajectory& run) {
        run.statistics.evaluations = std::lround(factor * static_cast<double>(run.statistics.evaluations));
      };
      return solver;
    };
    return {[make](const Model& model) { return make(model, "cartesian"); },
            [make](const Model& model) { return make(model, "relative"); }};
  }

  Told nightly(NightlyCommand command = {}) {
    command.suite = suite_;
    std::ostringstream out;
    std::ostringstream err;
    const int code = run_nightly(command, makers(), {out, err});
    return {code, out.str(), err.str()};
  }

  /// As if it had been killed: another process, which has ended, began it.
  void stop_first_night() {
    const pid_t child = fork();
    if (child == 0) {
      History own(history_);
      own.finish(1, "");
      own.take_over(1);
      _exit(0);
    }
    waitpid(child, nullptr, 0);
  }

  Told accept(AcceptCommand command = {}) {
    command.what.insert(command.what.begin(), suite_.string());
    if (command.reason.empty()) command.reason = "first";
    std::ostringstream out;
    std::ostringstream err;
    const int code = accept_baselines(command, makers(), {out, err});
    return {code, out.str(), err.str()};
  }

  Told difference(const DiffCommand& command) {
    std::ostringstream out;
    std::ostringstream err;
    const int code = show_difference(command, {out, err});
    return {code, out.str(), err.str()};
  }

  Told page(const NightReportCommand& command) {
    std::ostringstream out;
    std::ostringstream err;
    const int code = write_night_report(command, {out, err});
    return {code, out.str(), err.str()};
  }

  TemporaryFolder folder_;
  std::filesystem::path suite_ = folder_.path() / "suite.toml";
  std::filesystem::path history_ = folder_.path() / "nights.sqlite";
  std::filesystem::path baselines_ = folder_.path() / "baselines" / "suite.csv";
  double factor_ = 1.0;
};

}  // namespace

TEST_F(Nights, BaselineIsMissingUntilItIsAcceptedThenAllIsGreen) {
  const Told first = nightly();
  EXPECT_EQ(first.code, kNoBaseline) << first.out << first.err;
  EXPECT_THAT(first.out, HasSubstr("no baseline suite: 2 cases: 2 agree; 2 no baseline\n"));
  EXPECT_FALSE(std::filesystem::exists(baselines_));
  const Told accepted = accept();
  EXPECT_EQ(accepted.code, 0) << accepted.err;
  const Told second = nightly();
  EXPECT_EQ(second.code, 0) << second.out;
  EXPECT_THAT(second.out, HasSubstr("green suite: 2 cases: 2 agree\n"));
  NightlyCommand one_job;
  one_job.jobs = 1;
  EXPECT_EQ(nightly(one_job).out, second.out);
}

TEST_F(Nights, WhoWhenAndWhyOldAndNewAreLogged) {
  accept();
  const std::string before = bytes_of(baselines_);
  factor_ = 1.3;
  AcceptCommand again;
  again.what = {"sound"};
  again.reason = "a better error estimate";
  EXPECT_THAT(accept(again).out, HasSubstr("1 accepted, 0 not"));
  const std::string log = bytes_of(folder_.path() / "baselines" / "suite.log");
  EXPECT_THAT(log, HasSubstr(": first\n  other: new: agree"));
  EXPECT_THAT(log, HasSubstr(": a better error estimate\n  sound: old: agree"));
  EXPECT_THAT(log, HasSubstr("(+30 %)"));
  EXPECT_NE(bytes_of(baselines_), before);
  const Told night = nightly();
  EXPECT_EQ(night.code, kDiffer);  // the other one was not accepted
  EXPECT_THAT(night.out, HasSubstr("| worse | other |"));
  EXPECT_THAT(night.out, Not(HasSubstr("| worse | sound |")));
}

TEST_F(Nights, NothingRedIsAcceptedAndNothingWithoutAReason) {
  model("differing");
  const Told accepted = accept();
  EXPECT_EQ(accepted.code, kDiffer);
  EXPECT_THAT(accepted.err, HasSubstr("differing is not accepted: it is red (differ)"));
  EXPECT_THAT(bytes_of(baselines_), Not(HasSubstr("differing")));
  AcceptCommand silent;
  silent.reason = " ";
  EXPECT_EQ(accept(silent).code, kBadInput);
}

/// Finds baselines that were never what the suite asks now.
TEST_F(Nights, ResultsOfAnotherDefinitionAreNotAccepted) {
  NightlyCommand command;
  command.history = history_;
  command.json = folder_.path() / "night.json";
  nightly(command);
  write_file(folder_.path() / "models" / "sound.toml", kPendulum + "# changed\n");
  AcceptCommand stored;
  stored.history = history_;
  AcceptCommand from;
  from.from = command.json;
  for (const AcceptCommand& one : {stored, from}) {
    const Told told = accept(one);
    EXPECT_EQ(told.code, kDiffer);
    EXPECT_THAT(told.err, HasSubstr("sound is not accepted: it was run before its model or what the suite says"));
    EXPECT_THAT(bytes_of(baselines_), Not(HasSubstr("sound")));
    EXPECT_THAT(bytes_of(baselines_), HasSubstr("other"));
  }
}

TEST_F(Nights, EveryWayToEndIsARowAndNeverTheEnd) {
  accept();
  for (const char* name : {"crashing", "stopping", "differing"}) model(name);
  write_file(folder_.path() / "models" / "refused.toml", "format = 1\n");
  NightlyCommand command;
  command.junit = folder_.path() / "junit.xml";
  const Told night = nightly(command);
  EXPECT_EQ(night.code, kCouldNotFinish) << night.err;
  EXPECT_THAT(night.out, HasSubstr("6 cases: 2 agree, 1 differ, 1 no verdict, 1 bad input, 1 crashed"));
  EXPECT_THAT(night.out, HasSubstr("crashed: signal 9; last words: stage: reading"));
  EXPECT_THAT(night.out, HasSubstr("no verdict: same run: cartesian: step size too small"));
  EXPECT_THAT(night.out, HasSubstr("there is no body"));
  const std::string junit = bytes_of(command.junit);
  EXPECT_THAT(junit, HasSubstr("tests=\"6\" failures=\"1\" errors=\"3\" skipped=\"0\""));
}

TEST_F(Nights, KnownRedIsNotRedUntilItsDayIsOver) {
  accept();
  model("differing");
  write(
      "[[case]]\nmodels = [\"models/*.toml\"]\nexcept = [\"models/d*.toml\"]\n"
      "[[case]]\nmodels = [\"models/differing.toml\"]\n"
      "known_red = { reason = \"side to be mended\", until = 2026-06-30 }\n");
  AcceptCommand known;
  known.what = {"differing"};
  known.today = "2026-07-01";
  EXPECT_THAT(accept(known).err,
              HasSubstr("differing is not accepted: it is red (differ), and its known_red does not"));
  known.today = "2026-06-30";
  EXPECT_EQ(accept(known).code, 0);
  NightlyCommand command;
  command.today = "2026-06-30";
  const Told night = nightly(command);
  EXPECT_EQ(night.code, 0) << night.out;
  EXPECT_THAT(night.out, HasSubstr("side to be mended (until 2026-06-30)"));
  command.today = "2026-07-01";
  EXPECT_EQ(nightly(command).code, kDiffer);
}

/// Finds a result that is kept although the part or the modes that it was found with are others now.
TEST_F(Nights, ResumedNightRunsCasesAgainWhoseIncludedFilesChanged) {
  write_file(folder_.path() / "models" / "sound.toml", kPendulum + "[[include]]\nfile = \"parts/none.toml\"\n");
  const auto part = folder_.path() / "models" / "parts" / "none.toml";
  write_file(part, "[[body]]\nname = \"arm\"\nmodes_file = \"arm.modes\"\n");
  NightlyCommand command;
  command.history = history_;
  command.commit = "abc";
  nightly(command);
  command.resume = true;
  stop_first_night();
  EXPECT_THAT(nightly(command).err, HasSubstr("night 1 goes on: 2 of 2 cases were done"));
  write_file(part.parent_path() / "arm.modes", "mended");
  stop_first_night();
  EXPECT_THAT(nightly(command).err, HasSubstr("night 1 goes on: 1 of 2 cases were done"));
}

TEST_F(Nights, ResumedNightRunsOnlyWhatIsLeft) {
  accept();
  NightlyCommand command;
  command.history = history_;
  command.commit = "abc";
  command.only = "other";
  nightly(command);
  stop_first_night();
  command.only.clear();
  command.resume = true;
  const Told resumed = nightly(command);
  EXPECT_THAT(resumed.err, HasSubstr("night 1 goes on: 1 of 2 cases were done"));
  EXPECT_EQ(resumed.code, 0) << resumed.out;
  EXPECT_THAT(nightly(command).err, HasSubstr("nothing to resume"));
  command.history.clear();
  EXPECT_EQ(nightly(command).code, kBadInput);
}

TEST_F(Nights, TimeThatIsUpLeavesCasesNotRunAndTheNightToBeResumed) {
  accept();
  NightlyCommand command;
  command.history = history_;
  command.minutes = 1e-9;
  const Told night = nightly(command);
  EXPECT_EQ(night.code, kCouldNotFinish);
  EXPECT_THAT(night.out, HasSubstr("2 not run"));
}

TEST_F(Nights, RiseOfEvaluationsIsFoundAgainstBaselineHistoryAndFile) {
  accept();
  NightlyCommand command;
  command.history = history_;
  command.json = folder_.path() / "before.json";
  command.commit = "aaaa1111";
  ASSERT_EQ(nightly(command).code, 0);
  factor_ = 1.2;
  command.json = folder_.path() / "after.json";
  command.commit = "bbbb2222";
  const Told worse = nightly(command);
  EXPECT_EQ(worse.code, kDiffer);
  EXPECT_THAT(worse.out, HasSubstr("evaluations of cartesian"));

  for (const DiffCommand& diff :
       {DiffCommand{(folder_.path() / "before.json").string(), (folder_.path() / "after.json").string()},
        DiffCommand{"last-1", "last", history_}, DiffCommand{"1", "2", history_},
        DiffCommand{"aaaa", "bbbb", history_}}) {
    const Told found = difference(diff);
    EXPECT_EQ(found.code, kDiffer) << found.err;
    EXPECT_THAT(found.out, HasSubstr("(+20 %)"));
  }
  EXPECT_EQ(difference({"last", "last", history_}).code, 0);
  EXPECT_EQ(difference({"last-7", "last", history_}).code, kBadInput);

  std::ostringstream out;
  std::ostringstream err;
  ASSERT_EQ(show_history({"sound", "", history_}, {out, err}), 0) << err.str();
  EXPECT_THAT(out.str(), HasSubstr("commit aaaa1111 before, bbbb2222 after"));
  EXPECT_THAT(out.str(), HasSubstr("▁█"));
  ASSERT_EQ(show_history({"sound", "hinge on bob, F_y", history_}, {out, err}), 0) << err.str();
  EXPECT_EQ(show_history({"sond", "", history_}, {out, err}), kBadInput);
  EXPECT_THAT(err.str(), HasSubstr("did you mean 'sound'?"));
}

TEST_F(Nights, NumbersOfAModelThatWasChangedAreChangedUntilTheyAreAccepted) {
  accept();
  factor_ = 1.2;
  for (const char* name : {"sound", "other"}) {
    write_file(folder_.path() / "models" / (std::string(name) + ".toml"), kPendulum + "\n# heavier\n");
  }
  const Told changed = nightly();
  EXPECT_EQ(changed.code, 4) << changed.out;
  EXPECT_THAT(changed.out, HasSubstr("(+20 %)"));
  EXPECT_THAT(changed.out, HasSubstr("changed suite: "));
  EXPECT_THAT(changed.out, Not(HasSubstr("worse")));
  accept();
  EXPECT_EQ(nightly().code, 0);
  factor_ = 1.44;
  EXPECT_EQ(nightly().code, kDiffer) << "the same model";
}

TEST_F(Nights, CaseThatLeavesTheSuiteIsGone) {
  accept();
  write("[[case]]\nmodels = [\"models/sound.toml\"]\n");
  const Told night = nightly();
  EXPECT_EQ(night.code, kDiffer);
  EXPECT_THAT(night.out, HasSubstr("| gone | other |"));
  NightlyCommand only;
  only.only = "sound";
  EXPECT_EQ(nightly(only).code, 0);
  accept();
  EXPECT_EQ(nightly().code, 0);
}

TEST_F(Nights, ResultsAreWrittenAndAcceptedFromAFile) {
  NightlyCommand command;
  command.out = folder_.path() / "out";
  command.notify = "cat > '" + (folder_.path() / "told.md").string() + "'";
  const Told night = nightly(command);
  EXPECT_EQ(bytes_of(command.out / "table.txt"), night.out);
  EXPECT_THAT(bytes_of(folder_.path() / "told.md"), HasSubstr("# no baseline suite: 2 cases"));
  const auto json = nlohmann::json::parse(bytes_of(command.out / "night.json"));
  EXPECT_EQ(json.at("format"), 1);
  EXPECT_EQ(json.at("cases").size(), 2U);
  AcceptCommand from;
  from.from = command.out / "night.json";
  EXPECT_EQ(accept(from).code, 0);
  EXPECT_EQ(nightly().code, 0);
}

TEST_F(Nights, FileOfResultsOfAVersionThatIsNotKnownIsRefusedByName) {
  const auto file = folder_.path() / "later.json";
  write_file(file, "{\"format\": 5, \"kind\": \"concord night\", \"cases\": []}");
  const Told refused = difference({file.string(), file.string()});
  EXPECT_EQ(refused.code, kBadInput);
  EXPECT_THAT(refused.err, HasSubstr("version 5 of these results is not known: this program reads version 1"));
  write_file(file, "{\"format\": 1}");
  EXPECT_THAT(difference({file.string(), file.string()}).err, HasSubstr("is no file of results"));
  write_file(file, "nonsense");
  EXPECT_EQ(difference({file.string(), file.string()}).code, kBadInput);
}

// Detects a page that judges otherwise than the night did, and one that ends without its suite.
TEST_F(Nights, PageOfTheHistoryIsThatOfTheNightWhileTheSuiteIsThere) {
  accept();
  NightlyCommand command;
  command.history = history_;
  command.report = folder_.path() / "at_once.html";
  command.out = folder_.path() / "out";
  nightly(command);
  factor_ = 1.5;
  EXPECT_EQ(nightly(command).code, kDiffer);
  EXPECT_EQ(bytes_of(command.report), bytes_of(command.out / "night.html"));
  EXPECT_THAT(bytes_of(command.report), HasSubstr("The night of suite is red: of 2 cases 2 agree; 4 worse"));
  const auto later = folder_.path() / "later.html";
  EXPECT_EQ(page({history_, later}).code, 0);
  const std::string sentence = "The night of suite is red: of 2 cases 2 agree; 4 worse";
  EXPECT_THAT(bytes_of(later), HasSubstr(sentence));
  EXPECT_THAT(bytes_of(later), HasSubstr("Judged by the suite suite.toml"));
  EXPECT_EQ(page({history_, later, "last-1"}).code, 0);
  EXPECT_THAT(bytes_of(later), HasSubstr("The night of suite is green: of 2 cases 2 agree."));
  std::filesystem::remove(suite_);
  EXPECT_EQ(page({history_, later}).code, 0);
  EXPECT_THAT(bytes_of(later), HasSubstr("cannot be read any more: judged by the nights before"));
  EXPECT_THAT(bytes_of(later), HasSubstr(sentence));
}

TEST_F(Nights, PageThatCannotBeWrittenIsRefused) {
  NightlyCommand command;
  command.history = history_;
  nightly(command);
  EXPECT_EQ(page({history_, history_}).code, kBadInput);
  EXPECT_THAT(page({history_, folder_.path() / "p.html", "7"}).err, HasSubstr("the history has no such night"));
  EXPECT_THAT(page({folder_.path() / "none", folder_.path() / "p.html"}).err, HasSubstr("there is no such file"));
  EXPECT_THAT(page({suite_, folder_.path() / "p.html"}).err, HasSubstr("is no history"));
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "p.html"));
  command.report = history_;
  EXPECT_EQ(nightly(command).code, kBadInput);
}

TEST_F(Nights, PageDoesNotReplaceWhatItIsJudgedBy) {
  NightlyCommand command;
  command.history = history_;
  nightly(command);
  accept();
  for (const auto& input : {suite_, baselines_, log_of(baselines_)}) {
    const std::string before = bytes_of(input);
    EXPECT_EQ(page({history_, input}).code, kBadInput);
    EXPECT_EQ(bytes_of(input), before);
  }
}

TEST_F(Nights, LogOfWhatWasAcceptedIsNoOutputAndNoBaseline) {
  accept();
  NightlyCommand command;
  command.json = folder_.path() / "baselines" / "suite.log";
  const std::string before = bytes_of(command.json);
  EXPECT_EQ(nightly(command).code, kBadInput);
  EXPECT_EQ(bytes_of(command.json), before);
  write("baselines = \"models/suite.log\"\n[[case]]\nmodels = [\"models/*.toml\"]\n");
  EXPECT_THAT(accept().err, HasSubstr("suite.toml:2:"));
}

TEST_F(Nights, ResultsOfAnEarlierNightDoNotPassForThisOnes) {
  NightlyCommand command;
  command.out = folder_.path() / "out";
  nightly(command);
  ASSERT_TRUE(std::filesystem::exists(command.out / "night.json"));
  write_file(baselines_, "no baselines\n");
  EXPECT_EQ(nightly(command).code, kBadInput);
  EXPECT_TRUE(std::filesystem::is_empty(command.out));
}

TEST_F(Nights, TwoWhoAcceptAtOnceLoseNothing) {
  for (int attempt = 0; attempt < 5; ++attempt) {
    std::filesystem::remove(baselines_);
    const auto accept_in_a_process = [&](const char* name) {
      const pid_t child = fork();
      if (child == 0) {
        AcceptCommand command;
        command.what = {name};
        _exit(accept(command).code);
      }
      return child;
    };
    for (const pid_t child : {accept_in_a_process("sound"), accept_in_a_process("other")}) waitpid(child, nullptr, 0);
    EXPECT_EQ(read_baselines(baselines_).size(), 2U);
  }
}

TEST_F(Nights, BaselineIsNoPastOfANightThatIsJudgedByOthers) {
  accept();
  write("judge.against = \"median\"\n[[case]]\nmodels = [\"models/*.toml\"]\n");
  NightlyCommand command;
  command.history = history_;
  EXPECT_THAT(nightly(command).out, HasSubstr("no past"));
  EXPECT_THAT(nightly(command).out, Not(HasSubstr("no past")));
}

TEST_F(Nights, PatternThatMeansNothingIsRefused) {
  NightlyCommand command;
  command.only = "sond";
  EXPECT_EQ(nightly(command).code, kBadInput);
}

TEST_F(Nights, ModelOfTheSuiteIsNoOutput) {
  NightlyCommand command;
  command.json = folder_.path() / "models" / "sound.toml";
  const Told told = nightly(command);
  EXPECT_EQ(told.code, kBadInput);
  EXPECT_THAT(told.err, HasSubstr("sound.toml: error: cannot be written: it is an input of this run"));
  EXPECT_TRUE(std::filesystem::exists(command.json));
  command.json = folder_.path() / "night.out";
  command.junit = command.json;
  EXPECT_THAT(nightly(command).err, HasSubstr("cannot be written: it is another output of this run"));
}

TEST_F(Nights, CaseThatIsNewAndRedIsRedInADifference) {
  NightlyCommand command;
  command.json = folder_.path() / "a.json";
  nightly(command);
  model("stopping");
  command.json = folder_.path() / "b.json";
  nightly(command);
  const Told told = difference({folder_.path() / "a.json", folder_.path() / "b.json"});
  EXPECT_EQ(told.code, kCouldNotFinish) << told.out;
  EXPECT_THAT(told.out, HasSubstr(": 3 cases: 2 agree, 1 no verdict; 1 red, 1 new"));
}

TEST_F(Nights, NightThatWasStoppedIsNotGreen) {
  accept();
  NightlyCommand command;
  command.history = history_;
  ASSERT_EQ(nightly(command).code, kAgree);
  stop_first_night();
  const Told told = page({history_, folder_.path() / "night.html"});
  EXPECT_EQ(told.code, kAgree) << told.err;
  EXPECT_THAT(told.out, HasSubstr("night 1: unfinished suite: 2 cases: 2 agree"));
}

TEST_F(Nights, NightThatWasStoppedLacksNoCasesInADifference) {
  static_cast<void>(nightly({.history = history_}));
  stop_first_night();
  model("later");
  static_cast<void>(nightly({.history = history_}));
  for (const auto& [one, other] : {std::pair("1", "2"), std::pair("2", "1")}) {
    const Told said = difference({.a = one, .b = other, .history = history_});
    EXPECT_EQ(said.code, kCouldNotFinish);
    EXPECT_THAT(said.out, HasSubstr("night 1 is not finished: of the other side's cases 1 was not run there\n"));
    EXPECT_THAT(said.out, AllOf(Not(HasSubstr("gone")), Not(HasSubstr("new"))));
  }
}

TEST_F(Nights, FileOfAStoppedNightLacksWhatTheNightDidNotComeTo) {
  const auto whole = folder_.path() / "whole.json";
  const auto stopped = folder_.path() / "stopped.json";
  static_cast<void>(nightly({.history = history_, .json = whole}));
  auto document = nlohmann::json::parse(read_text_file(whole));
  EXPECT_EQ(document.at("is_finished"), true);
  document.at("cases").at(0)["ending"] = to_string(Ending::not_run);
  std::ofstream(stopped) << document.dump();
  const Told said = difference({.a = whole.string(), .b = stopped.string()});
  EXPECT_EQ(said.code, kCouldNotFinish);
  EXPECT_THAT(said.out, HasSubstr("is not finished: of the other side's cases 1 was not run there\n"));
  EXPECT_THAT(said.out, AllOf(Not(HasSubstr("worse")), Not(HasSubstr("gone"))));
}

TEST_F(Nights, ChoiceOfCasesIsToldAndLeavesNothingGone) {
  static_cast<void>(nightly({.history = history_}));
  const Told chosen = nightly({.only = "sound", .history = history_, .json = folder_.path() / "chosen.json"});
  EXPECT_THAT(chosen.out, HasSubstr("suite, only 'sound': 1 case"));
  const Told said = difference({.a = "last-1", .b = "last", .history = history_});
  EXPECT_EQ(said.code, 0) << said.out;
  EXPECT_THAT(said.out, Not(HasSubstr("gone")));
  EXPECT_EQ(difference({.a = "1", .b = (folder_.path() / "chosen.json").string(), .history = history_}).code, 0);
  const Told shown = page({.history = history_, .out = folder_.path() / "night.html"});
  EXPECT_THAT(shown.out, HasSubstr("only 'sound'"));
}

TEST_F(Nights, ResumingAChoiceOfCasesByAllOfThemMakesItAWholeNight) {
  static_cast<void>(nightly({.only = "sound", .history = history_}));
  stop_first_night();
  const Told resumed = nightly({.history = history_, .resume = true});
  EXPECT_THAT(resumed.err, HasSubstr("night 1 goes on: 1 of 2 cases were done"));
  EXPECT_EQ(History(history_).nights().at(0).only, "");
}

TEST_F(Nights, ChoiceOfCasesIsNotResumedByAnotherChoice) {
  static_cast<void>(nightly({.only = "sound", .history = history_}));
  stop_first_night();
  const Told resumed = nightly({.only = "other", .history = history_, .resume = true});
  EXPECT_EQ(resumed.code, 2);
  EXPECT_THAT(resumed.err, HasSubstr("--only: error: the stopped night was asked for 'sound'"));
}

TEST_F(Nights, NamesakeInTheHistoryIsToldAndNotResumed) {
  static_cast<void>(nightly({.history = history_}));
  stop_first_night();
  const auto first = suite_;
  suite_ = folder_.path() / "elsewhere" / "suite.toml";
  write("# other\n[[case]]\nmodels = [\"../models/*.toml\"]\n");
  const Told own = nightly({.history = history_, .resume = true});
  EXPECT_THAT(own.err, HasSubstr("another suite file's"));
  EXPECT_THAT(own.err, HasSubstr("note: the last night of 'suite' in this history was that of " + first.string()));
  EXPECT_EQ(History(history_).nights().size(), 2U);
}

TEST_F(Nights, LastNightsOfAHistoryWithSeveralSuitesAreOfOneSuite) {
  static_cast<void>(nightly({.history = history_}));
  const auto first = suite_;
  suite_ = folder_.path() / "joints.toml";
  write("[[case]]\nwork = \"joint\"\njoints = [\"weld\"]\nposes = 1\n");
  static_cast<void>(nightly({.history = history_}));
  const Told refused = difference({.a = "1", .b = "2", .history = history_});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("2: error: has no case in common with 1: results of 'suite' and of 'joints'"));
  suite_ = first;
  static_cast<void>(nightly({.history = history_}));
  for (const char* before : {"last-1", "1"}) {
    const Told said = difference({.a = before, .b = "last", .history = history_});
    EXPECT_EQ(said.code, 0) << said.out << said.err;
    EXPECT_THAT(said.out, HasSubstr("2 cases: 2 agree"));
  }
  EXPECT_EQ(difference({.a = "last", .b = "2", .history = history_}).code, 0) << "the last of the second night's suite";
}

TEST_F(Nights, HistoryMayBeALinkAndIsNeverInMemory) {
  static_cast<void>(nightly({.history = history_}));
  std::filesystem::create_symlink(history_, folder_.path() / "link.sqlite");
  EXPECT_EQ(nightly({.history = folder_.path() / "link.sqlite"}).code, kNoBaseline);
  EXPECT_EQ(History(history_).nights().size(), 2U);
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder_.path());
  static_cast<void>(nightly({.history = ":memory:"}));
  EXPECT_TRUE(std::filesystem::is_regular_file(folder_.path() / ":memory:"));
  std::filesystem::current_path(before);
}

TEST_F(Nights, SuiteThatCannotBeReadIsToldToNotify) {
  write("[[cases]]\n");
  const auto told = folder_.path() / "told.txt";
  EXPECT_EQ(nightly({.notify = "cat > '" + told.string() + "'"}).code, 2);
  EXPECT_THAT(read_text_file(told), HasSubstr("the night could not finish"));
}

TEST_F(Nights, NightIsNotJudgedByAnotherSuite) {
  NightlyCommand command;
  command.history = history_;
  nightly(command);
  const auto other = folder_.path() / "foreign.toml";
  write_file(other, "format = 1\n[[case]]\nmodels = [\"models/*.toml\"]\n");
  NightReportCommand report{history_, folder_.path() / "night.html"};
  report.suite = other;
  EXPECT_THAT(page(report).err, HasSubstr("is the suite 'foreign', but night 1 is one of 'suite'"));
}

TEST_F(Nights, ResultsOfAnotherSuiteAreNotAccepted) {
  ASSERT_EQ(accept().code, kAgree);
  const std::string before = read_text_file(baselines_);
  NightlyCommand command;
  command.json = folder_.path() / "night.json";
  nightly(command);
  write("name = \"renamed\"\nbaselines = \"baselines/suite.csv\"\n[[case]]\nmodels = [\"models/sound.toml\"]\n");
  AcceptCommand from;
  from.from = command.json;
  const Told told = accept(from);
  EXPECT_EQ(told.code, kBadInput);
  EXPECT_THAT(told.err, HasSubstr("holds results of 'suite', not of 'renamed'"));
  EXPECT_EQ(read_text_file(baselines_), before);
}

TEST_F(Nights, FailedNotificationTellsItsExitCode) {
  NightlyCommand command;
  command.notify = "exit 5";
  EXPECT_THAT(nightly(command).err, HasSubstr("the command of --notify ended with 5\n"));
}

TEST_F(Nights, HistoryTellsTheCaseOfOneSuite) {
  NightlyCommand command;
  command.history = history_;
  nightly(command);
  write("name = \"short\"\n[[case]]\nmodels = [\"models/sound.toml\"]\nuntil = 0.05\n");
  nightly(command);
  std::ostringstream out;
  std::ostringstream err;
  HistoryCommand asked{"sound", "", history_};
  EXPECT_EQ(show_history(asked, {out, err}), kAgree) << err.str();
  EXPECT_THAT(out.str(), HasSubstr("sound: 1 night\n"));
  EXPECT_THAT(out.str(), HasSubstr("note: nights of the suite 'short'; a case of this name is in those of suite too"));
  asked.suite = "suite";
  out.str("");
  EXPECT_EQ(show_history(asked, {out, err}), kAgree) << err.str();
  EXPECT_THAT(out.str(), Not(HasSubstr("note:")));
  asked.suite = "long";
  EXPECT_EQ(show_history(asked, {out, err}), kBadInput);
}

TEST_F(Nights, HistoryIsReadWhereNothingCanBeWritten) {
  NightlyCommand command;
  command.history = history_;
  nightly(command);
  // Root may write anywhere: the reader is another process that is not root.
  std::filesystem::permissions(folder_.path(), std::filesystem::perms(0755));
  std::filesystem::permissions(history_, std::filesystem::perms(0644));
  const pid_t reader = fork();
  if (reader == 0) {
    const bool is_other = geteuid() != 0 || (setgid(65534) == 0 && setuid(65534) == 0);
    std::ostringstream out;
    std::ostringstream err;
    HistoryCommand asked{"sound", "", history_};
    const int code = is_other ? show_history(asked, {out, err}) : 99;
    std::fputs(err.str().c_str(), stderr);
    _exit(code);
  }
  int status = 0;
  waitpid(reader, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), kAgree);
  EXPECT_FALSE(std::filesystem::exists(history_.string() + "-shm"));
  std::ostringstream out;
  std::ostringstream err;
  HistoryCommand asked{"sound", "", history_};
  asked.history = folder_.path() / "empty.sqlite";
  write_file(asked.history, "");
  EXPECT_EQ(show_history(asked, {out, err}), kBadInput);
  EXPECT_THAT(err.str(), HasSubstr("is no history: it is empty"));
  EXPECT_EQ(std::filesystem::file_size(asked.history), 0U);
}

}  // namespace concord::compare::nightly
