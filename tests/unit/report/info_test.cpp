#include "compare/report/info.h"

#include <gmock/gmock.h>

#include "common/joints/catalogue.h"
#include "compare/report/force_table.h"
#include "tests/unit/fake_pendulum.h"

namespace concord::compare {
namespace {

using ::testing::HasSubstr;

TEST(InfoTest, TellsWhatBothSolversSee) {
  const Model model = pendulum_model();
  FakePendulum solver(model, "cartesian");
  RankReport rank = solver.rank(solver.assemble());
  SolverView one{"cartesian", {}, {"rk4", "other"}, rank};
  rank.joints[0].unique[index(Side::child)][0] = false;
  rank.joints[0].unique[index(Side::child)][5] = false;  // not carried: not named
  SolverView other{"relative", {"A"}, {"rk4"}, rank};
  const std::string text = format_info(model, {one, other});
  EXPECT_THAT(text, HasSubstr("pendulum: 1 moving body, 1 joint, 0 loops, gravity (0.4, -9.6, 1.1) m/s2\n"));
  EXPECT_THAT(text, HasSubstr("| bob  |       1.7 |     0 |"));
  EXPECT_THAT(text, HasSubstr("| A     | revolute | ground | bob   |       0 |       0 | relative |\n"));
  EXPECT_THAT(text, HasSubstr("cartesian: 5 constraints of rank 5, 1 degrees of freedom, integrators rk4, other\n"
                              "  every reaction component is unique\n"));
  EXPECT_THAT(text, HasSubstr("  reactions that are not unique, and not judged:\n    joint A on bob: F_x\n"));
}

TEST(InfoTest, CouplingsWhoseForceIsNotUniqueAreNamed) {
  Model model = pendulum_model();
  model.couplings.resize(2);
  model.couplings[0].name = "left belt";
  model.couplings[1].name = "right belt";
  FakePendulum solver(model, "cartesian");
  RankReport rank = solver.rank(solver.assemble());
  rank.unique_coupling = {true, false};
  const SolverView one{"cartesian", {}, {"rk4"}, rank};
  EXPECT_THAT(format_info(model, {one, one}),
              HasSubstr("  reactions that are not unique, and not judged:\n    coupling right belt: force\n"));
}

TEST(InfoTest, JointsOfPlanarLoopsTakeOneLineAndCuresAreTold) {
  Model model = pendulum_model();
  Joint other = model.joints[0];
  other.name = "B";
  model.joints.push_back(other);
  RankReport rank;
  rank.joints.resize(2);
  for (JointUniqueness& joint : rank.joints) {
    for (auto& side : joint.unique) side[2] = side[3] = false;
  }
  const SolverView one{"cartesian", {}, {"rk4"}, rank};
  RedundancyView redundancy;
  redundancy.planar = PlanarLoops{{0, 1}, false, Vec3(0, 0, 1)};
  redundancy.cures.found = {{{0, joints::find("cylindrical")}, {1, joints::find("spherical")}}};
  redundancy.cures.found.resize(5, redundancy.cures.found[0]);
  redundancy.cures.tried = 7;
  const std::string text = format_info(model, {one, one}, redundancy);
  EXPECT_THAT(text, HasSubstr("  reactions that are not unique, and not judged:\n    across the plane of the loops, "
                              "normal (0, 0, 1): forces along it in joints A, B (concord compare --all lists them)\n"
                              "cartesian: "));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("joint A on bob:")));
  EXPECT_THAT(text, HasSubstr("\nall reactions would be unique if joint A were cylindrical and joint B spherical\n"));
  EXPECT_THAT(text, ::testing::EndsWith("\nand so with 2 more such changes of two joints (7 tried)\n"));
  redundancy.planar->has_torques = true;
  redundancy.cures.found.clear();
  redundancy.cures.is_complete = false;
  EXPECT_THAT(format_info(model, {one, one}, redundancy),
              ::testing::AllOf(HasSubstr(": forces along it and torques about axes in the plane in joints A, B ("),
                               ::testing::EndsWith("\nno other types of one joint or of two make all reactions unique "
                                                   "at the same degrees of freedom (7 tried, no more)\n")));
}

TEST(PeaksTest, NameTheirTimes) {
  const Model model = pendulum_model();
  FakePendulum solver(model, "cartesian");
  Trajectory run = solver.integrate({0.2, 1e-11, 20, ""}, [](double) {});
  run.samples[5].evaluation.joints[0].reaction[1].in_C.force = {300.0, 0.0, 400.0};
  run.samples[7].evaluation.joints[0].reaction[0].in_C.torque = {0.0, -70.0, 0.0};
  const std::string text = format_peaks(model, run);
  EXPECT_THAT(text, HasSubstr("| A     | bob    |        500 |     0.05 |"));
  EXPECT_THAT(text, HasSubstr("|           70 |     0.07 |"));
}

}  // namespace
}  // namespace concord::compare
