#include "compare/report/told_axes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <numbers>

#include "common/error.h"
#include "compare/report/force_table.h"
#include "compare/report/result_files.h"
#include "compare/report/table.h"
#include "compare/verdict/verify.h"
#include "tests/unit/fake_pendulum.h"
#include "tests/unit/temporary_folder.h"

namespace concord::compare {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kBob = 1;

/// The sprung pendulum, whose frames are tilted on both bodies; its strut and bushing have two ends, its load has one.
class ToldAxesTest : public ::testing::Test {
 protected:
  [[nodiscard]] Trajectory run() const {
    FakePendulum solver(model_, "cartesian");
    return solver.integrate({0.2, 1e-11, 20, ""}, [](double) {});
  }

  static void expect_equal(const Wrench& told, const Mat3& A, const Wrench& in_global) {
    EXPECT_LT((told.force - A.transpose() * in_global.force).norm(), 1e-12 * (1.0 + in_global.force.norm()));
    EXPECT_LT((told.torque - A.transpose() * in_global.torque).norm(), 1e-12 * (1.0 + in_global.torque.norm()));
  }

  Model model_ = sprung_pendulum_model();
};

TEST_F(ToldAxesTest, WrenchesOfBothSidesAreTurnedFromTheirOwnFrames) {
  const Trajectory given = run();
  for (const int axes : {kGround, kBob}) {
    const Trajectory told = told_run(model_, given, axes);
    const Sample& before = given.samples[13];
    const Sample& after = told.samples[13];
    const Vec4& p = before.state.bodies[static_cast<std::size_t>(axes)].p;
    const Mat3 A = Eigen::Quaterniond(p(0), p(1), p(2), p(3)).toRotationMatrix();
    for (const Side side : kSides) {
      const JointWrenches& joint = before.evaluation.joints[0];
      expect_equal(after.evaluation.joints[0].reaction_on(side).in_C, A, joint.reaction_on(side).in_global);
      expect_equal(after.evaluation.joints[0].total_on(side).in_C, A, joint.total_on(side).in_global);
      for (std::size_t k = 0; k < model_.elements.size(); ++k) {
        expect_equal(after.evaluation.elements[k].on_side(side).in_C, A,
                     before.evaluation.elements[k].on_side(side).in_global);
      }
    }
    EXPECT_GT((after.evaluation.joints[0].reaction_on(Side::child).in_C.force -
               before.evaluation.joints[0].reaction_on(Side::child).in_C.force)
                  .norm(),
              0.1);
  }
}

TEST_F(ToldAxesTest, AComponentIsUniqueWhereAllThatHasAPartOfItIs) {
  const QuantityLayout layout(model_);
  const Trajectory given = run();
  const auto rows = static_cast<Eigen::Index>(layout.quantities().size());
  Mask unique = Mask::Constant(rows, 21, true);
  const int first = layout.first_row(Kind::reaction, 0, Side::child);
  unique.row(first + 2).setConstant(false);  // F_z
  const ToldRun tilted = told_in(layout, given, &unique, kBob);
  for (int c = 0; c < 6; ++c) EXPECT_EQ(tilted.unique(first + c, 7), c >= 3) << c;
  model_.joints[0].sides[index(Side::child)].C = rotation_about(Vec3::UnitZ(), 0.7);
  const ToldRun aligned = told_in(layout, given, &unique, kBob);
  for (int c = 0; c < 6; ++c) EXPECT_EQ(aligned.unique(first + c, 7), c != 2) << c;
  const Vec3 in_C = given.samples[7].evaluation.joints[0].reaction_on(Side::child).in_C.force;
  EXPECT_NEAR(aligned.run.samples[7].evaluation.joints[0].reaction_on(Side::child).in_C.force.x(),
              std::cos(0.7) * in_C.x() - std::sin(0.7) * in_C.y(), 1e-12 * in_C.norm());
  const auto parent = layout.first_row(Kind::reaction, 0, Side::parent);
  EXPECT_TRUE(aligned.unique.block(parent, 0, 6, 21).all());
}

TEST_F(ToldAxesTest, TablesSayInWhichAxesAndHoldEveryComponentOfWhatIsCarried) {
  model_ = pendulum_model();
  Trajectory given = run();
  for (Sample& sample : given.samples) {
    sample.evaluation.joints[0].reaction[index(Side::child)].in_C = {Vec3(3.0, 4.0, 0.0), Vec3::Zero()};
  }
  // A quarter turn about z: x of the joint is y of the body.
  model_.joints[0].sides[index(Side::child)].C = rotation_about(Vec3::UnitZ(), std::numbers::pi / 2);
  const std::string text = format_peaks(model_, given, nullptr, kBob);
  EXPECT_THAT(text, HasSubstr("wrenches in the axes of body bob, each at the point of its own side\n"));
  EXPECT_THAT(text, HasSubstr("| in the axes of body bob | on     | component |"));
  EXPECT_THAT(text, HasSubstr("| bob    | F_x       |         -4 N |"));
  EXPECT_THAT(text, HasSubstr("| bob    | F_y       |          3 N |"));
  EXPECT_THAT(format_peaks(model_, given), Not(HasSubstr("axes of body")));
}

TEST_F(ToldAxesTest, VerdictsStayAndSayThatTheirDigitsAreOfOtherAxes) {
  model_ = pendulum_model();
  FakePendulum cartesian(model_, "cartesian");
  FakePendulum relative(model_, "relative");
  Verdict verdict = verify(model_, cartesian, relative, {});
  const std::string before = format_verdict(model_, verdict, true);
  verdict.axes = kGround;
  const std::string told = format_verdict(model_, verdict, true);
  EXPECT_THAT(told, HasSubstr("wrenches in global axes, each at the point of its own side; digits and verdicts are "
                              "those of components in each side's own frame\n"));
  EXPECT_THAT(told, HasSubstr("| in global axes | on     | component |"));
  EXPECT_THAT(told, HasSubstr("| runs differ by |"));
  EXPECT_EQ(told.substr(told.find("| case ")), before.substr(before.find("| case ")));
}

TEST_F(ToldAxesTest, ColumnsOfFilesAreNamedAfterTheAxes) {
  const TemporaryFolder folder;
  const auto header_of = [&](std::optional<int> axes) {
    write_reaction_csv(folder.path() / "r.csv", model_, run(), nullptr, axes);
    write_element_csv(folder.path() / "e.csv", model_, run(), axes);
    std::string reactions;
    std::string elements;
    std::ifstream one(folder.path() / "r.csv");
    std::getline(one, reactions);
    std::ifstream other(folder.path() / "e.csv");
    std::getline(other, elements);
    return reactions + '\n' + elements;
  };
  EXPECT_THAT(header_of(kBob), HasSubstr(",A.child.in_bob.T_z [N m],A.tau_1 [N m]"));
  EXPECT_THAT(header_of(kBob), HasSubstr(".parent.in_bob.F_x [N],"));
  EXPECT_THAT(header_of(kGround), HasSubstr(",A.child.global.T_z [N m],A.tau_1 [N m]"));
  EXPECT_THAT(header_of({}), HasSubstr(",A.child.T_z [N m],A.tau_1 [N m]"));
}

TEST_F(ToldAxesTest, AreThoseOfABodyOrOfTheWorld) {
  EXPECT_EQ(told_axes(model_, "bob", "m.toml"), kBob);
  EXPECT_EQ(told_axes(model_, "ground", "m.toml"), kGround);
  EXPECT_EQ(told_axes(model_, "world", "m.toml"), kGround);
  try {
    told_axes(model_, "bbo", "m.toml");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "m.toml: error: --axes: there is no body 'bbo': did you mean 'bob'? ('world' stands for global axes)");
  }
  model_.bodies[kBob].name = "world";
  EXPECT_EQ(told_axes(model_, "world", "m.toml"), kBob);
}

}  // namespace
}  // namespace concord::compare
