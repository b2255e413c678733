#include "compare/page/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/error.h"
#include "compare/report/files.h"
#include "compare/report/origin.h"
#include "compare/report/result_document.h"
#include "compare/report/result_folder.h"
#include "compare/verdict/refinement.h"
#include "compare/verdict/verify.h"
#include "tests/unit/fake_pendulum.h"
#include "tests/unit/temporary_folder.h"

namespace concord::compare::page {
namespace {

using testing::HasSubstr;
using testing::Not;

struct Compared {
  Model model = sprung_pendulum_model();
  Verdict verdict;

  /// `is_open`: the torque about y is not unique.
  explicit Compared(const std::string& name = "sprung", bool is_open = false) {
    model.name = name;
    FakePendulum cartesian(model, "cartesian");
    FakePendulum relative(model, "relative");
    const auto open = [is_open](RankReport& report) { report.joints[0].unique[1][4] = !is_open; };
    cartesian.spoil_rank = relative.spoil_rank = open;
    VerifyOptions options;
    options.refines = false;
    verdict = verify(model, cartesian, relative, options);
  }

  [[nodiscard]] ReportedCase reported() const { return {verdict.name, &model, &verdict, ""}; }

  void write_into(const std::filesystem::path& folder) const {
    write_runs(folder, model,
               {{"cartesian", &*verdict.trajectories[0], &*verdict.unique},
                {"relative", &*verdict.trajectories[1], &*verdict.unique}});
    write_file(folder / (model.name + ".result.json"), format_result(model, verdict));
  }
};

/// The data of a page, as its script reads them.
nlohmann::json data_of(const std::string& page) {
  const std::string start = "<script type=\"application/json\" id=\"data\">";
  const std::size_t from = page.find(start) + start.size();
  return nlohmann::json::parse(page.substr(from, page.find("</script>", from) - from));
}

TEST(Page, SaysTheVerdictAndHoldsTheMachineInMotion) {
  const Compared one;
  const std::string page = format_page({one.reported()});
  EXPECT_THAT(page, HasSubstr("<title>concord: sprung, agree</title>"));
  const nlohmann::json machine = data_of(page).at("machines").at(0);
  EXPECT_THAT(machine.at("sentence").get<std::string>(), HasSubstr("Both solvers agree on "));
  EXPECT_EQ(machine.at("machine").at("joints").at(0).at("type"), "revolute");
  EXPECT_EQ(machine.at("runs").at("samples"), one.verdict.trajectories[0]->samples.size());
  EXPECT_FALSE(machine.at("runs").at("joints").at(0).at(1).at(0).at("a").get<std::string>().empty());
  EXPECT_FALSE(machine.at("rows").empty());
  const nlohmann::json& forces = machine.at("told").at(0);
  EXPECT_EQ(forces.at("title"), "Forces");
  EXPECT_EQ(forces.at("tables").at(0).at("lines").at(0).at(2), "peak F [N]");
  EXPECT_EQ(forces.at("tables").at(0).at("lines").size(), 3);  // the head, and both sides of the hinge
  EXPECT_EQ(machine.at("solvers").at(0).at("energy_drift"),
            drift_text(one.verdict.solvers[0].energy.value(), one.verdict.energy_allowed));
}

TEST(Page, SaysFromWhatItWasMadeAndWhen) {
  const TemporaryFolder folder;
  Compared one;
  one.model.file = (folder.path() / "sprung.toml").string();
  write_file(one.model.file, "a");
  one.verdict.seed = 7;
  ::setenv("SOURCE_DATE_EPOCH", "86400", 1);
  const nlohmann::json data = data_of(format_page({one.reported()}));
  ::unsetenv("SOURCE_DATE_EPOCH");
  EXPECT_EQ(data.at("made"), "Made by " + version_words() + " on 1970-01-02. Units are SI and radians.");
  const nlohmann::json machine = data.at("machines").at(0);
  EXPECT_EQ(machine.at("file").at("name"), one.model.file);
  EXPECT_EQ(machine.at("file").at("fnv1a"), "af63dc4c8601ec8c");  // of "a", as the algorithm's authors publish it
  EXPECT_EQ(machine.at("program"), version_words());
  EXPECT_EQ(machine.at("run").at("seed"), 7);
}

TEST(Page, HoldsAWheelsRadiusAndItsRoad) {
  Compared one;
  const auto road = std::make_shared<Road>(Road{"bump", HalfSineBump{2.0, 1.0, 0.25}});
  Tire tire{.wheel = one.model.joints[0].on(Side::child), .road = road, .radius = 0.3};
  one.model.elements.back().what = tire;  // the verdict is that of a spring in its place
  const nlohmann::json document = nlohmann::json::parse(format_result(one.model, one.verdict));
  const nlohmann::json& said = document.at("machine").at("elements").back();
  EXPECT_EQ(said.at("radius"), 0.3);
  double highest = 0.0;
  for (const nlohmann::json& point : said.at("road")) highest = std::max(highest, point.at(1).get<double>());
  EXPECT_DOUBLE_EQ(highest, 0.25);
  EXPECT_EQ(said.at("road").front(), nlohmann::json({2.0, 0.0}));
  EXPECT_EQ(said.at("road").back(), nlohmann::json({3.0, 0.0}));
}

TEST(Page, AllowsItsOwnScriptAndStyleAlone) {
  const std::string page = format_page({Compared().reported()});
  EXPECT_THAT(page, HasSubstr("default-src 'none'; style-src 'sha256-"));
  EXPECT_THAT(page, Not(HasSubstr("@POLICY@")));
  EXPECT_THAT(page, Not(HasSubstr("unsafe-inline")));
  EXPECT_THAT(page, Not(HasSubstr("src=\"http")));
}

TEST(Page, NamesAreTextWhateverTheyHold) {
  const std::string name = "</script><img src=x onerror=alert(1)> \"quoted\" & \xd0\xbc\xd0\xbe\xd1\x81\xd1\x82";
  const std::string page = format_page({Compared(name).reported()});
  EXPECT_THAT(page, Not(HasSubstr("<img")));
  EXPECT_EQ(data_of(page).at("machines").at(0).at("model"), name);
}

TEST(Page, AModelThatCannotBeReadHasItsWords) {
  const std::string page = format_page({{"broken", nullptr, nullptr, "broken.toml:3:1: error: missing key 'mass'\n"}});
  const nlohmann::json machine = data_of(page).at("machines").at(0);
  EXPECT_EQ(machine.at("outcome"), "failed");
  EXPECT_EQ(machine.at("sentence"), "There is no verdict: broken.toml:3:1: error: missing key 'mass'");
}

TEST(Page, OfAFolderIsThatOfTheComparison) {
  for (const bool is_open : {false, true}) {  // what is not unique is drawn as the solver has it
    const Compared one("sprung", is_open);
    const TemporaryFolder folder;
    one.write_into(folder.path());
    nlohmann::json of_folder = data_of(format_page(read_results(folder.path())));
    nlohmann::json at_once = data_of(format_page({one.reported()}));
    EXPECT_EQ(of_folder, at_once);
  }
}

TEST(Page, SaysWhichRunIsMissing) {
  const Compared one;
  const TemporaryFolder folder;
  one.write_into(folder.path());
  std::filesystem::remove(folder.path() / "sprung.cartesian.nc");
  const nlohmann::json machine = data_of(format_page(read_results(folder.path()))).at("machines").at(0);
  EXPECT_THAT(machine.at("notes").dump(), HasSubstr("there is no run of cartesian: its file is missing"));
}

TEST(Page, SaysWhereResolutionJudgesInPlaceOfTheNeed) {
  Compared one;
  for (QuantityRow& row : one.verdict.rows) {
    row.need.same_run = 20.0;
    row.judgement = Judgement::agree;
    row.detail[static_cast<std::size_t>(Check::same_run)].unexplained = 20.0;
  }
  const QuantityRow& row = one.verdict.rows.front();
  ASSERT_TRUE(is_judged_by_resolution(row, Check::same_run) && !is_judged_by_resolution(row, Check::same_state));
  const nlohmann::json machine = data_of(format_page({one.reported()})).at("machines").at(0);
  EXPECT_THAT(machine.at("sentence").get<std::string>(),
              HasSubstr("in the same run where 20 are asked, which is all that double precision resolves there"));
  EXPECT_TRUE(machine.at("rows").at(0).at("by_resolution").get<bool>());
  EXPECT_EQ(machine.at("rows").at(0).at("said"), "agree, judged by resolution (same run)");
}

TEST(Page, SaysWhatCarriedTheVerdict) {
  Compared one;
  PairSum sum;
  sum.samples = 3;
  one.verdict.pair_sums = {sum};
  for (auto* rows : {&one.verdict.rows, &one.verdict.others}) {
    for (QuantityRow& row : *rows) {
      row.unique = false;
      row.judgement = Judgement::not_judged;
    }
  }
  one.verdict.outcome = Outcome::agree;
  one.verdict.same_run.passed = true;
  one.verdict.same_run.horizon = 0.25;
  const nlohmann::json machine = data_of(format_page({one.reported()})).at("machines").at(0);
  EXPECT_THAT(
      machine.at("sentence").get<std::string>(),
      HasSubstr("load components of sprung: no single component is unique; judged instead: 1 total of joints that "
                "share what they carry"));
  EXPECT_THAT(machine.at("rungs").at(2).at("passed_with_less").get<std::string>(),
              HasSubstr("up to t = 0.25 s of 0.4 s"));
}

TEST(Page, ChecksWithoutDigitsAreAmongTheChecks) {
  Compared one;
  one.verdict.references.push_back(
      {.of = "joint A on bob", .component = "F_x", .unit = "N", .word = ReferenceWord::wrong});
  const nlohmann::json checks = data_of(format_page({one.reported()})).at("machines").at(0).at("rungs");
  EXPECT_EQ(checks.at(5), (nlohmann::json{{"name", "energy"}, {"digits", nullptr}, {"passed", true}}));
  EXPECT_EQ(checks.at(6), (nlohmann::json{{"name", "reference"}, {"digits", nullptr}, {"passed", false}}));
}

TEST(ReportCommand, RefusesWhatHoldsNoResults) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "empty");
  write_file(folder.path() / "other" / "notes.txt", "nothing");
  const auto said_of = [&](const std::string& name) {
    std::ostringstream out;
    std::ostringstream err;
    EXPECT_EQ(write_report({folder.path() / name, folder.path() / "page.html"}, {out, err}), kBadInput);
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "page.html"));
    return err.str();
  };
  EXPECT_THAT(said_of("empty"), HasSubstr("holds no results: it is empty; files MODEL.result.json"));
  EXPECT_THAT(said_of("other"), HasSubstr("it holds notes.txt"));
  EXPECT_THAT(said_of("missing"), HasSubstr("cannot be read"));
  write_file(folder.path() / "future" / "a.result.json", R"({"kind": "concord result", "format": 99})");
  EXPECT_THAT(said_of("future"), HasSubstr("has format 99, but format 2 was expected"));
  write_file(folder.path() / "strange" / "a.result.json", "[1, 2]");
  EXPECT_THAT(said_of("strange"), HasSubstr("is no result that `concord compare --out` wrote"));
}

TEST(ReportCommand, ReplacesNoInput) {
  const Compared one;
  const TemporaryFolder folder;
  one.write_into(folder.path());
  std::ostringstream out;
  std::ostringstream err;
  const auto input = folder.path() / "." / "sprung.result.json";
  const std::string before = bytes_of(input);
  EXPECT_EQ(write_report({folder.path(), input}, {out, err}), kBadInput);
  EXPECT_THAT(err.str(), HasSubstr("it is an input of the page"));
  EXPECT_EQ(bytes_of(input), before);
}

TEST(ReportCommand, RefusesADamagedOrForeignRun) {
  const Compared one;
  const TemporaryFolder folder;
  one.write_into(folder.path());
  write_file(folder.path() / "sprung.relative.nc", "no NetCDF file");
  EXPECT_THROW(static_cast<void>(read_results(folder.path())), InputError);
}

}  // namespace
}  // namespace concord::compare::page
