#include "compare/verdict/two_readings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <utility>

#include "common/reading/model_file.h"
#include "compare/report/console.h"
#include "compare/report/table.h"

namespace concord::compare {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kText = R"toml(format = 1
gravity = [0, 0, -9.81]
[[body]]
name = "bob"
mass = 2.5
inertia = [0.2, 0.3, 0.4]
[[joint]]
name = "A"
type = "revolute"
parent = { body = "ground" }
child = { body = "bob", point = [0.1, 0.2, 0.3] }
)toml";

MisreadModel misread() {
  Model model = parse_model(kText, "bob.toml");
  model.bodies[1].mass = 2.4;
  model.joints[0].sides[1].point_L.y() = -0.2;
  SecondReading reading = read_again_text(model, kText, "bob.toml");
  return {std::move(model), std::move(reading)};
}

TEST(TwoReadings, LetAModelThatIsWhatItsTextSaysPass) {
  EXPECT_EQ(parse_twice(kText, "bob.toml").bodies.size(), 2U);
  EXPECT_THROW(parse_twice("format = 1\n[[body]]\n", "bob.toml"), InputError);
}

TEST(TwoReadings, NameWhatWasMisread) {
  EXPECT_THAT(misread().what(), AllOf(HasSubstr("FAIL bob: body bob, mass: was not read as bob.toml says in line 5"),
                                      HasSubstr("FAIL bob: joint A, child.point: was not read"),
                                      HasSubstr("note: to blame: no solver, at joint A: two readings of the file")));
}

TEST(TwoReadings, AMisreadModelDiffersAndNoSolverIsAsked) {
  const MisreadModel error = misread();
  const Verdict verdict = verdict_on(error);
  EXPECT_EQ(verdict.outcome, Outcome::differ);
  ASSERT_TRUE(verdict.attribution);
  EXPECT_EQ(verdict.attribution->term, Term::statement);
  EXPECT_THAT(format_verdict(error.model(), verdict, false),
              AllOf(HasSubstr("FAIL bob: body bob, mass: was not read"), HasSubstr("differ bob:")));
}

TEST(TwoReadings, EndWithTheCodeOfADifference) {
  std::ostringstream out;
  std::ostringstream err;
  EXPECT_EQ(guarded(Console{out, err}, []() -> int { throw misread(); }), kDiffer);
  EXPECT_THAT(err.str(), HasSubstr("body bob, mass"));
}

}  // namespace
}  // namespace concord::compare
