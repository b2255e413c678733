#include <gtest/gtest.h>

#include <limits>

#include "cartesian/solver.h"
#include "common/error.h"
#include "linkage.h"

/// The same machine in other units of length, mass and time.
namespace concord::cartesian {
namespace {

using testing::Linkage;

/// A four-bar linkage with a redundant plane, which turns fully.
Linkage four_bar() {
  Linkage linkage;
  linkage.crank = 0.19;
  linkage.last_crank = 0.47;
  linkage.is_driven = false;
  linkage.rate = 14.0;
  return linkage;
}

Linkage in_units(double length, double mass, double time) {
  Linkage linkage = four_bar();
  linkage.length = length;
  linkage.mass = mass;
  linkage.time = time;
  return linkage;
}

/// Reactions on the child of the second hinge: forces by the unit of force, torques by that of torque.
Vec6 reaction(const Evaluation& evaluation, const Linkage& units) {
  Vec6 found = evaluation.joints[1].total_on(Side::child).in_C.vector();
  const double force = units.mass * units.length / (units.time * units.time);
  found.head<3>() /= force;
  found.tail<3>() /= force * units.length;
  return found;
}

Evaluation end_of_run(const Linkage& linkage) {
  const Model model = linkage.make();
  RunOptions options;
  options.until = 0.5 * linkage.time;
  options.samples = 3;
  options.rtol = 1e-10;
  return make_solver(model)->integrate(options, {}).samples.back().evaluation;
}

TEST(Units, PowersOfTwoLeaveEveryDigit) {
  const Vec6 plain = reaction(end_of_run(four_bar()), four_bar());
  for (const int shift : {-20, 13}) {
    const double unit = std::ldexp(1.0, shift);
    for (const Linkage& linkage : {in_units(unit, 1.0, 1.0), in_units(1.0, unit, 1.0), in_units(1.0, 1.0, unit)}) {
      const Vec6 other = reaction(end_of_run(linkage), linkage);
      for (int c = 0; c < 6; ++c)
        EXPECT_NEAR(other(c), plain(c), std::numeric_limits<double>::min()) << shift << " component " << c;
    }
  }
}

TEST(Units, TwelveDecadesLeaveTheVerdict) {
  const Model plain_model = four_bar().make();
  const auto plain = make_solver(plain_model);
  const State start = plain->assemble();
  const Vec6 expected = reaction(plain->evaluate(start), four_bar());
  const RankReport rank = plain->rank(start);
  for (const double unit : {1e-6, 1e6}) {
    for (const Linkage& linkage : {in_units(unit, 1.0, 1.0), in_units(1.0, unit, 1.0), in_units(1.0, 1.0, unit)}) {
      const Model model = linkage.make();
      const auto solver = make_solver(model);
      const State state = solver->assemble();
      const Vec6 found = reaction(solver->evaluate(state), linkage);
      for (int c = 0; c < 6; ++c) {
        if (!rank.joints[1].unique_total[1][c]) continue;
        EXPECT_NEAR(found(c), expected(c), 1e-12 * expected.norm());
      }
      const RankReport other = solver->rank(state);
      EXPECT_EQ(other.rank, rank.rank);
      for (std::size_t k = 0; k < rank.joints.size(); ++k) EXPECT_EQ(other.joints[k].unique, rank.joints[k].unique);
      State open = state;
      open.bodies[1].r.x() += 1e-10 * linkage.length;
      EXPECT_THROW((void)solver->evaluate(open), SolverError);
    }
  }
}

TEST(Units, ResidualsOfARunWithLoopsAreAboveZero) {
  const Model model = four_bar().make();
  RunOptions options;
  options.until = 0.2;
  options.samples = 2;
  const Trajectory trajectory = make_solver(model)->integrate(options, {});
  EXPECT_GT(trajectory.statistics.max_constraint, 0.0);
  EXPECT_LT(trajectory.statistics.max_constraint, 1e-11);
}

}  // namespace
}  // namespace concord::cartesian
