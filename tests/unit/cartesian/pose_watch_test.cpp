#include "cartesian/pose_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cartesian/solver.h"
#include "common/error.h"
#include "linkage.h"

namespace concord::cartesian {
namespace {

using ::testing::HasSubstr;

using testing::Linkage;

std::string end_of_run(const Model& model, double until, const char* integrator) {
  RunOptions options;
  options.until = until;
  options.samples = 7;
  options.rtol = 1e-9;
  options.integrator = integrator;
  try {
    (void)make_solver(model)->integrate(options, {});
    return "went through";
  } catch (const SingularPose& error) {
    return error.what();
  }
}

/// One loop that swings through its flat pose by itself. With long steps of gbs the watch can miss it; a run alone is
/// then refused for its energy.
TEST(PoseWatch, SeesAParallelogramPassItsFlatPoseBetweenSteps) {
  Linkage linkage;
  linkage.is_driven = false;
  linkage.rate = 9.0;
  linkage.angle = -0.5;
  EXPECT_THAT(end_of_run(linkage.make(), 1.0, "ida"),
              HasSubstr("the motion passes a singular pose: constraints lose rank at joint"));
}

/// Two loops lose rank together: no determinant changes its sign.
TEST(PoseWatch, SeesTwoLoopsPassTheirFlatPoseTogether) {
  Linkage linkage;
  linkage.loops = 2;
  linkage.is_driven = false;
  linkage.rate = 9.0;
  linkage.angle = -0.4;
  EXPECT_THAT(end_of_run(linkage.make(), 1.0, "gbs"), HasSubstr("the motion passes a singular pose"));
}

TEST(PoseWatch, LetsARegularLinkageTurnFully) {
  Linkage linkage;
  linkage.crank = 0.2;
  linkage.last_crank = 0.5;
  for (const bool is_driven : {true, false}) {
    linkage.is_driven = is_driven;
    linkage.rate = is_driven ? 2.0 : 15.0;
    EXPECT_EQ(end_of_run(linkage.make(), 4.0, "gbs"), "went through");
  }
}

TEST(PoseWatch, AStateInTheFlatPoseIsRefusedByName) {
  Linkage linkage;
  linkage.angle = 0.0;
  linkage.is_driven = false;
  const Model model = linkage.make();
  const auto solver = make_solver(model);
  Linkage regular = linkage;
  regular.angle = 0.6;
  const Model other = regular.make();
  const auto elsewhere = make_solver(other);
  const State fine = elsewhere->assemble();
  EXPECT_NO_THROW((void)elsewhere->evaluate(fine));
  State flat = fine;
  for (int i = 1; i <= 3; ++i) {
    flat.bodies[i] = BodyState{};
    flat.bodies[i].a = flat.bodies[i].adot = VecX(0);
  }
  flat.bodies[2].r.x() = linkage.crank;
  flat.bodies[3].r.x() = linkage.pitch;
  for (VecX& u : flat.u) u.setZero();
  for (VecX& q : flat.q) q.setZero();
  try {
    (void)elsewhere->evaluate(flat);
    FAIL() << "a flat parallelogram was evaluated";
  } catch (const SingularPose& error) {
    EXPECT_THAT(error.what(), HasSubstr("the machine is in a singular pose: its constraints have rank 16 there, 17"));
    EXPECT_THAT(error.what(), HasSubstr("joint 'A0'"));
  }
  EXPECT_NO_THROW((void)elsewhere->evaluate(fine));  // whatever came before
}

TEST(PoseWatch, TreesWithoutCouplingsCannotLoseRank) {
  Linkage linkage;
  Model model = linkage.make();
  EXPECT_TRUE(may_lose_rank(model));
  model.joints.pop_back();
  EXPECT_FALSE(may_lose_rank(model));
}

}  // namespace
}  // namespace concord::cartesian
