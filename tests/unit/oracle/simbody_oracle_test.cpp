// Whole verdicts with Simbody as the third opinion, and faults that it must lay at the right door.
#include "compare/oracle/simbody_oracle.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "compare/quantities/not_expressible.h"
#include "compare/report/table.h"
#include "compare/verdict/verify.h"
#include "tests/unit/oracle/machines.h"

namespace concord::compare::oracle {

namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

/// A crank with a coupler on a ball and a slider: a spatial loop whose length is `size` metres.
Model crank_of(double size, double mass = 1.0) {
  const std::string text = R"(format = 1
gravity = [0, -9.81, 0]
[parameters]
L = )" + std::to_string(size) +
                           R"(
M = )" + std::to_string(mass) +
                           R"(
[[body]]
name = "crank"
mass = "1.4*M"
center_of_mass = ["0.13*L", "0.02*L", "0.01*L"]
inertia = ["0.004*M*L^2", "0.02*M*L^2", "0.021*M*L^2"]
[[body]]
name = "coupler"
mass = "0.9*M"
center_of_mass = ["0.4*L", 0, "0.02*L"]
inertia = ["0.003*M*L^2", "0.07*M*L^2", "0.071*M*L^2"]
[[body]]
name = "slider"
mass = "2.2*M"
center_of_mass = ["0.01*L", 0, 0]
inertia = ["0.01*M*L^2", "0.015*M*L^2", "0.012*M*L^2"]
[[joint]]
name = "hinge"
type = "revolute"
parent = { body = "ground", point = [0, "0.05*L", "0.1*L"], axis = [1, 0, 0], angle = "17 deg" }
child = "crank"
start.turn_z = { keep = "50 deg", keep_speed = 4 }
[[joint]]
name = "ball"
type = "spherical"
parent = { body = "crank", point = ["0.3*L", 0, 0] }
child = "coupler"
[[joint]]
name = "cross"
type = "universal"
both = { x = [0, 0, 1], z = [1, 0, 0] }
parent = { body = "coupler", point = ["0.9*L", 0, 0] }
child = "slider"
[[joint]]
name = "guide"
type = "translational"
both = { axis = [0, 1, 0], angle = "90 deg" }
parent = "ground"
child = "slider"
start.slide_z = { guess = "L" }
[run]
until = 0.02
)";
  return parse_model(text, "crank.toml");
}

/// A solver whose results were tampered with.
class Spoiled : public Solver {
 public:
  Spoiled(std::unique_ptr<Solver> inner, std::function<void(Evaluation&)> spoil)
      : inner_(std::move(inner)), spoil_(std::move(spoil)) {}

  [[nodiscard]] std::string_view name() const override { return inner_->name(); }
  [[nodiscard]] std::vector<std::string> integrators() const override { return inner_->integrators(); }
  State assemble() override { return inner_->assemble(); }
  std::optional<State> close(const State& guess) override { return inner_->close(guess); }
  Evaluation evaluate(const State& state) override {
    Evaluation found = inner_->evaluate(state);
    spoil_(found);
    return found;
  }
  RankReport rank(const State& state) override { return inner_->rank(state); }
  MatX tangent(const State& state) override { return inner_->tangent(state); }
  Trajectory integrate(const RunOptions& options, const Progress& progress) override {
    return inner_->integrate(options, progress);
  }

 private:
  std::unique_ptr<Solver> inner_;
  std::function<void(Evaluation&)> spoil_;
};

Verdict verdict_on(const Model& model, Solver& cartesian, Solver& relative) {
  const auto simbody = make_simbody(model);
  VerifyOptions options;
  options.samples = 10;
  options.states = 12;
  options.refines = false;
  options.third = simbody.get();
  return verify(model, cartesian, relative, options);
}

/// Blames of the rows on which anybody is off.
std::vector<Blame> blames_in(const Verdict& verdict) {
  std::vector<Blame> found;
  for (const ThirdRow& row : verdict.third->rows) {
    if (const Blame blame = blame_in(row); blame != Blame::nobody) found.push_back(blame);
  }
  return found;
}

TEST(SimbodyOracle, AgreesOnASpatialLoop) {
  const Model model = crank_of(1.0);
  const auto cartesian = cartesian::make_solver(model);
  const auto relative = relative::make_solver(model);
  const Verdict verdict = verdict_on(model, *cartesian, *relative);
  EXPECT_EQ(verdict.outcome, Outcome::agree) << format_verdict(model, verdict, true);
  ASSERT_TRUE(verdict.third);
  EXPECT_EQ(verdict.third->failed, 0);
  EXPECT_EQ(verdict.third->states, verdict.same_state.samples);
  EXPECT_GE(verdict.third->digits(Kind::reaction).value_or(0.0), 11.0);
  EXPECT_GE(verdict.third->digits(Kind::acceleration).value_or(0.0), 11.0);
  EXPECT_THAT(format_verdict(model, verdict, false), HasSubstr("simbody at "));
}

TEST(SimbodyOracle, DoesNotCareForTheSizeOfAMachine) {
  for (const double size : {2e-6, 3e5}) {
    const Model model = crank_of(size, size < 1.0 ? 1e-6 : 1e6);
    const ThirdReport report = opinion_at_start(model);
    ASSERT_EQ(report.states, 1) << report.first_failure;
    EXPECT_GE(report.digits(Kind::reaction).value_or(0.0), 11.0) << size;
    EXPECT_GE(report.digits(Kind::acceleration).value_or(0.0), 11.0) << size;
  }
}

TEST(SimbodyOracle, BlamesASignOfTheRelativeSolver) {
  const Model model = crank_of(1.0);
  const auto cartesian = cartesian::make_solver(model);
  Spoiled relative(relative::make_solver(model),
                   [](Evaluation& found) { found.joints[2].reaction[0].in_C.torque *= -1.0; });
  const Verdict verdict = verdict_on(model, *cartesian, relative);
  EXPECT_EQ(verdict.outcome, Outcome::differ);
  EXPECT_THAT(blames_in(verdict), testing::Each(Blame::relative));
  EXPECT_THAT(verdict.notes, Contains(AllOf(HasSubstr("cartesian and simbody agree to 1"),
                                            HasSubstr("relative is off: joint cross on coupler, T_"))));
}

TEST(SimbodyOracle, BlamesAnInertiaOfTheCartesianSolver) {
  const Model model = crank_of(1.0);
  Model other = model;
  other.bodies[2].inertia_L *= 1.001;
  const auto cartesian = cartesian::make_solver(other);
  const auto relative = relative::make_solver(model);
  const Verdict verdict = verdict_on(model, *cartesian, *relative);
  EXPECT_EQ(verdict.outcome, Outcome::differ);
  EXPECT_FALSE(blames_in(verdict).empty());
  EXPECT_THAT(blames_in(verdict), testing::Each(Blame::cartesian));
  EXPECT_THAT(verdict.notes, Contains(AllOf(HasSubstr("relative and simbody agree to 1"),
                                            HasSubstr("cartesian is off: body coupler, "))));
}

TEST(SimbodyOracle, FindsWhatBothSolversHaveWrong) {
  const Model model = crank_of(1.0);
  Model other = model;
  other.bodies[1].mass *= 1.0 + 1e-6;
  const auto cartesian = cartesian::make_solver(other);
  const auto relative = relative::make_solver(other);
  const Verdict verdict = verdict_on(model, *cartesian, *relative);
  EXPECT_EQ(verdict.outcome, Outcome::differ);
  EXPECT_FALSE(blames_in(verdict).empty());
  EXPECT_THAT(blames_in(verdict), testing::Each(Blame::third));
  EXPECT_THAT(verdict.findings, Contains(testing::Field(&Finding::what, HasSubstr("simbody is off: "))));
}

TEST(SimbodyOracle, NamesWhatSimbodyDoesNotKnow) {
  Model model = crank_of(1.0);
  static const joints::JointType unknown{.name = "cam", .forbids = {}, .permits = {}, .reads = {}};
  model.joints[1].type = &unknown;
  try {
    make_simbody(model);
    FAIL();
  } catch (const NotExpressible& reason) {
    EXPECT_THAT(reason.what(), AllOf(HasSubstr("joint ball"), HasSubstr("cam")));
  }
}

TEST(SimbodyOracle, RefusesToSplitABodyWithoutThickness) {
  Model model = crank_of(1.0);
  model.bodies[3].inertia_L.diagonal() << 0.0, 0.04, 0.04;  // the slider closes the loop
  try {
    make_simbody(model);
    FAIL();
  } catch (const NotExpressible& reason) {
    EXPECT_THAT(reason.what(), AllOf(HasSubstr("body slider"), HasSubstr("2 joints")));
  }
}

TEST(SimbodyOracle, BearsWeldsSideBySide) {
  const Model model = parse_model(kTwoBodies + R"([[joint]]
name = "hinge"
type = "revolute"
parent = "ground"
child = "a"
start.turn_z = { keep = 0.4, keep_speed = 2 }
[[joint]]
name = "left"
type = "weld"
both = { point = [0.3, 0.2, 0.1] }
parent = "a"
child = "b"
[[joint]]
name = "right"
type = "weld"
both = { point = [0.3, 0.2, 0.1] }
parent = "a"
child = "b"
)",
                                  "machine.toml");
  const ThirdReport report = opinion_at_start(model);
  ASSERT_EQ(report.states, 1) << report.first_failure;
  EXPECT_GE(report.digits(Kind::acceleration).value_or(0.0), 11.0);
  EXPECT_GE(report.digits(Kind::body_sum).value_or(0.0), 11.0);
}

TEST(SimbodyOracle, SaysInWhichStateItFails) {
  const Model model = crank_of(1.0);
  const auto simbody = make_simbody(model);
  State apart = relative::make_solver(model)->assemble();
  apart.bodies[1].r.x() += 0.01;
  try {
    simbody->evaluate(apart);
    FAIL();
  } catch (const SolverError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("simbody: t = 0 s"), HasSubstr("leave body crank")));
  }
}

}  // namespace

}  // namespace concord::compare::oracle
