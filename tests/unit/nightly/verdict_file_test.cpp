#include "compare/nightly/verdict_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "common/error.h"
#include "compare/nightly/regression.h"
#include "compare/report/files.h"
#include "compare/report/report_json.h"
#include "compare/verdict/verify.h"
#include "tests/unit/fake_pendulum.h"
#include "tests/unit/temporary_folder.h"

namespace concord::compare::nightly {
namespace {

using testing::HasSubstr;

class VerdictFiles : public ::testing::Test {
 protected:
  VerdictFiles() {
    FakePendulum cartesian(model_, "cartesian");
    FakePendulum relative(model_, "relative");
    VerifyOptions options;
    options.refines = false;
    verdict_ = verify(model_, cartesian, relative, options);
  }

  std::filesystem::path written(const std::string& name, const std::string& text) const {
    write_file(folder_.path() / name, text);
    return folder_.path() / name;
  }

  static std::string refusal(const std::filesystem::path& file) {
    try {
      static_cast<void>(read_results_file(file));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  TemporaryFolder folder_;
  Model model_ = sprung_pendulum_model();
  Verdict verdict_;
};

}  // namespace

// Detects digits of one check that pass for those of another, and rows that are lost.
TEST_F(VerdictFiles, VerdictOfOneModelIsRead) {
  const auto document = nlohmann::json::parse(format_json(model_, verdict_));
  const ResultsFile file = read_results_file(written("one.json", document.dump()));
  EXPECT_TRUE(file.is_of_compare);
  EXPECT_TRUE(file.is_single);
  const Result& one = file.night.results.at(0);
  EXPECT_EQ(one.ending, Ending::agree);
  EXPECT_EQ(one.judged, document.at("judged"));
  EXPECT_EQ(worst_of(one, &Component::same_run), document.at("same_run").at("digits").get<double>());
  EXPECT_EQ(one.cost[1].evaluations, document.at("solvers").at("relative").at("evaluations"));
  const auto rows = [&](const char* key) { return document.contains(key) ? document.at(key).size() : 0U; };
  EXPECT_LE(one.components.size(), rows("joints") + rows("elements") + 1);
  EXPECT_GT(one.components.size(), rows("elements") + 1);
  EXPECT_EQ(one.components.front().name, "audit");
}

TEST_F(VerdictFiles, FallOfDigitsIsFoundBetweenTwo) {
  auto document = nlohmann::json::parse(format_json(model_, verdict_));
  ResultsFile then = read_results_file(written("then.json", document.dump()));
  auto& row = document.at("joints").at(0);
  row["same_run_digits"] = row.at("same_run_digits").get<double>() - 6.0;
  ResultsFile now = read_results_file(written("now.json", document.dump()));
  require_comparable(then, now, "then", "now");
  EXPECT_EQ(then.night.results.at(0).id, now.night.results.at(0).id);
  const auto changes = changes_between(then.night.results[0], now.night.results[0], {}, "A");
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].kind, ChangeKind::worse);
  EXPECT_EQ(changes[0].measure, "same run");
}

TEST_F(VerdictFiles, SeveralModelsKeepTheirNames) {
  Verdict other = verdict_;
  other.name = "another";
  const auto file = written("two.json", format_json(std::vector<ReportedCase>{{verdict_.name, &model_, &verdict_, ""},
                                                                              {other.name, &model_, &other, ""}}));
  ResultsFile two = read_results_file(file);
  ASSERT_EQ(two.night.results.size(), 2U);
  EXPECT_EQ(two.night.results[0].id, "another");
  EXPECT_FALSE(two.is_single);
  auto document = nlohmann::json::parse(format_json(model_, verdict_));
  ResultsFile one = read_results_file(written("one.json", document.dump()));
  EXPECT_NO_THROW(require_comparable(one, two, "one", "two"));
  document.erase("name");
  ResultsFile unnamed = read_results_file(written("unnamed.json", document.dump()));
  EXPECT_THROW(require_comparable(unnamed, two, "unnamed", "two"), InputError);
  ResultsFile night;
  EXPECT_THROW(require_comparable(night, two, "night", "two"), InputError);
}

TEST_F(VerdictFiles, OneModelUnderTwoNamesIsComparedUnderBoth) {
  auto document = nlohmann::json::parse(format_json(model_, verdict_));
  ResultsFile then = read_results_file(written("then.json", document.dump()));
  document["name"] = "renamed";
  ResultsFile now = read_results_file(written("now.json", document.dump()));
  require_comparable(then, now, "then", "now");
  EXPECT_EQ(then.night.results.at(0).id, verdict_.name + " / renamed");
  EXPECT_EQ(now.night.results.at(0).id, verdict_.name + " / renamed");
}

TEST_F(VerdictFiles, VersionThatIsNotKnownIsRefusedByName) {
  auto document = nlohmann::json::parse(format_json(model_, verdict_));
  document["format"] = 9;
  EXPECT_THAT(refusal(written("later.json", document.dump())),
              HasSubstr("version 9 of these results is not known: this program reads version 1"));
  EXPECT_THAT(refusal(written("named.json", nlohmann::json{{"a", document}}.dump())), HasSubstr("version 9"));
  document.erase("format");
  EXPECT_THAT(refusal(written("none.json", document.dump())), HasSubstr("cannot be read"));
  EXPECT_THAT(refusal(written("other.json", R"({"format": 1, "analysis": "statics"})")),
              HasSubstr("`concord nightly --json` or `concord compare --json`"));
}

}  // namespace concord::compare::nightly
