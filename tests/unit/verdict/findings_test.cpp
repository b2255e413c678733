#include "compare/verdict/findings.h"

#include <gtest/gtest.h>

#include "compare/quantities/align.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

TEST(FindingsTest, DescribesADifferenceInOneLine) {
  Model model = pendulum_model();
  model.joints[0].drivers.push_back({});
  Measured measured;
  measured.t = 1.284;
  measured.values = {0.0127, -0.0127};
  measured.digits = 0.0;
  EXPECT_EQ(describe(model, {Kind::reaction, 0, Side::child, 5}, measured, 5.0),
            "joint A on bob, T_z, t = 1.284 s: cartesian +0.0127, relative -0.0127 N m, 0 digits (need 5)");
  measured.values = {12.3456789, 12.3456781};
  measured.digits = 7.19;
  EXPECT_EQ(describe(model, {Kind::tau, 0, Side::child, 0}, measured, 8.5),
            "driver of joint A, tau_1, t = 1.284 s: cartesian +12.3456789, relative +12.3456781 N m, 7.1 digits "
            "(need 8.5)");
  measured.resolution = 1e-9;
  measured.scale = 12.0;
  EXPECT_EQ(
      describe(model, {Kind::tau, 0, Side::child, 0}, measured, 12.0),
      "driver of joint A, tau_1, t = 1.284 s: cartesian +12.3456789, relative +12.3456781 N m, 7.1 digits of 10.0 "
      "resolvable (need 12)");
}

class FindDifferencesTest : public ::testing::Test {
 protected:
  FindDifferencesTest() {
    for (SolverSummary& solver : verdict_.solvers) solver.rank.joints.resize(1);
    make_rows(layout_, verdict_);
    FakePendulum solver(model_, "cartesian");
    const Trajectory run = solver.integrate({0.2, 1e-11, 20, ""}, [](double) {});
    series_ = align(layout_, {&run, &run}, 21);
  }

  std::vector<Finding> find(Check check) {
    const std::vector<Measured> measured = measure(layout_, series_);
    record(layout_, measured, check, verdict_);
    return find_differences(layout_, series_, measured, verdict_, check, known_);
  }

  void spoil(const Quantity& quantity, double factor) { series_.values[1].row(layout_.row_of(quantity)) *= factor; }

  Model model_ = pendulum_model();
  QuantityLayout layout_{model_};
  Verdict verdict_;
  Series series_;
  std::vector<Quantity> known_;
};

TEST_F(FindDifferencesTest, NamesTheWorstOfEachJointAndEachBodyOnce) {
  spoil({Kind::reaction, 0, Side::child, 0}, 1.0 + 1e-6);
  spoil({Kind::reaction, 0, Side::parent, 1}, 2.0);
  spoil({Kind::acceleration, 1, Side::child, 2}, 1.01);
  const std::vector<Finding> findings = find(Check::same_state);
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_EQ(findings[0].what.substr(0, 27), "joint A on ground, F_y, t =");
  EXPECT_EQ(findings[0].symptom, "same state: factor two: relative is twice cartesian in all 21 samples");
  EXPECT_EQ(findings[1].what.substr(0, 18), "body bob, vdot_z, ");
}

TEST_F(FindDifferencesTest, WhoFailedBeforeIsNotNamedAgain) {
  spoil({Kind::reaction, 0, Side::child, 0}, 2.0);
  EXPECT_EQ(find(Check::same_state).size(), 1U);
  EXPECT_TRUE(find(Check::same_run).empty());
}

TEST_F(FindDifferencesTest, AgreementFindsNothing) { EXPECT_TRUE(find(Check::same_state).empty()); }

}  // namespace
}  // namespace concord::compare
