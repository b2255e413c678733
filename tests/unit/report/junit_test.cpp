#include "compare/report/junit.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "compare/verdict/verify.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

using ::testing::HasSubstr;

class JunitTest : public ::testing::Test {
 protected:
  std::string format() {
    verdict_ = verify(model_, cartesian_, relative_, {});
    return format_junit({{model_.name, &model_, &verdict_, ""}});
  }

  Model model_ = pendulum_model();
  FakePendulum cartesian_{model_, "cartesian"};
  FakePendulum relative_{model_, "relative"};
  Verdict verdict_;
};

long count(const std::string& text, const std::string& part) {
  long found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

TEST_F(JunitTest, EachJudgedRowIsATestCase) {
  const std::string xml = format();
  const auto rows = static_cast<long>(verdict_.rows.size() + verdict_.others.size());
  EXPECT_EQ(count(xml, "<testcase "), rows + 5) << "rank, two audits, two energies";
  EXPECT_THAT(
      xml, HasSubstr(fmt::format("<testsuite name=\"pendulum\" tests=\"{}\" failures=\"0\" errors=\"0\">", rows + 5)));
  EXPECT_THAT(xml, HasSubstr("<testcase classname=\"pendulum\" name=\"joint A on bob, T_x\"/>"));
  EXPECT_THAT(xml, HasSubstr("    <system-out>| joint | on     | peak F [N] | at t [s] |"));
}

TEST_F(JunitTest, AFailedRowSaysItsDigits) {
  relative_.spoil = [](const State&, Evaluation& evaluation) {
    evaluation.joints[0].reaction[1].in_C.force(0) *= 1.001;
  };
  const std::string xml = format();
  EXPECT_THAT(xml, HasSubstr("name=\"joint A on bob, F_x\">\n      <failure message=\"same state: "));
  EXPECT_THAT(xml, HasSubstr(" digits (need 12), same run: "));
}

TEST_F(JunitTest, WhoIsToBlameIsToldWithWhatTellsTheDifferenceApart) {
  relative_.spoil = [](const State&, Evaluation& evaluation) {
    evaluation.joints[0].reaction[1].in_C.force(0) *= 1.001;
  };
  const std::string xml = format();
  EXPECT_THAT(xml, HasSubstr("name=\"attribution\">\n      <failure message=\"to blame: relative, at joint A"));
  EXPECT_THAT(xml, HasSubstr("; the difference of joint A on "));
}

TEST_F(JunitTest, NamesAreEscaped) {
  model_.joints[0].name = "A<\"&\x01>";
  EXPECT_THAT(format(), HasSubstr("name=\"joint A&lt;&quot;&amp; &gt; on bob, F_x\""));
}

TEST_F(JunitTest, NoVerdictIsAnError) {
  const std::string xml = format_junit({{"broken", nullptr, nullptr, "broken.toml:1:1: error: no <body>\n"}});
  EXPECT_THAT(xml, HasSubstr("<testsuite name=\"broken\" tests=\"1\" failures=\"0\" errors=\"1\">"));
  EXPECT_THAT(xml, HasSubstr("<error message=\"broken.toml:1:1: error: no &lt;body&gt;&#10;\"/>"));
  relative_.cannot_integrate = true;
  EXPECT_THAT(format(), HasSubstr("<error message=\"same run: relative: step size too small at t = 0.1 s\"/>"));
}

/// Runs that are repeated with a tighter tolerance may lose as much energy as the one that was asked for.
TEST_F(JunitTest, EnergyIsJudgedByTheToleranceThatWasAskedFor) {
  verdict_ = verify(model_, cartesian_, relative_, {});
  verdict_.run.rtol = 1e-13;
  verdict_.solvers[0].energy_error = 1e-8;
  EXPECT_EQ(count(format_junit({{"pendulum", &model_, &verdict_, ""}}), "<failure"), 0);
  verdict_.solvers[0].energy_error = 1e-7;
  EXPECT_EQ(count(format_junit({{"pendulum", &model_, &verdict_, ""}}), "<failure"), 1);
}

TEST_F(JunitTest, ADifferenceThatNoRowTellsIsToldAllTheSame) {
  verdict_ = verify(model_, cartesian_, relative_, {});
  verdict_.outcome = Outcome::differ;
  verdict_.findings.push_back({"relative does not accept a state", "the closures differ"});
  EXPECT_THAT(format_junit({{"pendulum", &model_, &verdict_, ""}}),
              HasSubstr("<failure message=\"relative does not accept a state: the closures differ\"/>"));
}

}  // namespace
}  // namespace concord::compare
