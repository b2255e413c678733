#include "cartesian/run/pose_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "cartesian/rank/constraint_rank.h"
#include "cartesian/solver.h"
#include "common/error.h"
#include "linkage.h"

namespace concord::cartesian {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

using testing::Linkage;

constexpr std::array kIntegrators{"gauss", "ida"};
std::vector<int> samplings_of(const std::string& integrator) {
  if (integrator == "ida") return {7, 40};  // whose steps are short
  return {7, 20, 40, 100};
}

std::string end_of_run(const Model& model, double until, const char* integrator, int samples = 7, double rtol = 1e-9) {
  RunOptions options;
  options.until = until;
  options.samples = samples;
  options.rtol = rtol;
  options.integrator = integrator;
  try {
    (void)make_solver(model)->integrate(options, {});
    return "went through";
  } catch (const SingularPose& error) {
    return error.what();
  }
}

/// Each integrator and sampling has other steps, which end near the flat pose or far from it.
void expect_to_be_seen(const Linkage& linkage, double until) {
  const Model model = linkage.make();
  for (const char* integrator : kIntegrators) {
    for (const int samples : samplings_of(integrator)) {
      EXPECT_THAT(end_of_run(model, until, integrator, samples),
                  AllOf(HasSubstr("a singular pose"), HasSubstr("constraints lose rank at joint")))
          << integrator << ", " << samples;
    }
  }
}

TEST(PoseWatch, NamesTheIntegratorsThatItIsTriedWith) {
  const std::vector<std::string> names = make_solver(Linkage().make())->integrators();
  EXPECT_THAT(names, ::testing::UnorderedElementsAreArray(kIntegrators));
}

/// One loop that swings through its flat pose by itself, on its branch or into the other one.
TEST(PoseWatch, SeesAParallelogramPassItsFlatPoseBetweenSteps) {
  Linkage linkage;
  linkage.is_driven = false;
  linkage.rate = 9.0;
  linkage.angle = -0.5;
  expect_to_be_seen(linkage, 1.0);
}

/// A driver leaves nothing that could turn.
TEST(PoseWatch, SeesADrivenParallelogramPassItsFlatPoseBetweenSteps) {
  Linkage linkage;
  linkage.angle = -0.7;
  linkage.rate = 5.0;
  expect_to_be_seen(linkage, 0.5);
}

/// Next to the flat pose a closed pose is known to the root of round-off only, and so is the side on which it stands.
TEST(PoseWatch, SeesAFlatPoseThatStepsComeNearTo) {
  Linkage linkage;
  linkage.angle = -2.9;
  linkage.rate = 7.3;
  EXPECT_THAT(end_of_run(linkage.make(), 0.4715, "ida", 5, 1e-6), HasSubstr("the motion passes a singular pose"));
}

/// A heavy crank leaves the branches of the motion little to differ by.
TEST(PoseWatch, SeesAFlatPoseWhereTheBranchesAreNear) {
  Linkage linkage;
  linkage.is_driven = false;
  linkage.rate = 4.0;
  linkage.angle = -0.9;
  Model model = linkage.make();
  model.bodies[1].inertia_L *= 3e4;
  for (const int samples : samplings_of("gauss")) {
    EXPECT_THAT(end_of_run(model, 0.5, "gauss", samples), HasSubstr("the motion passes a singular pose")) << samples;
  }
}

/// Bodies without inertia about the axis along which they lie, tilted and off their joints: what the watch divides by
/// vanishes, the motion does not.
TEST(PoseWatch, LetsAThinRodTurn) {
  Linkage linkage;
  linkage.is_driven = false;
  linkage.pitch = 0.8;
  linkage.coupler = 0.6;
  linkage.last_crank = 0.5;
  linkage.rate = 2.0;
  Model model = linkage.make();
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    Body& rod = model.bodies[i];
    const Vec3 along = Vec3(0.9, 0.2, -0.3).normalized();
    rod.center_of_mass_L = 0.3 * along;
    rod.inertia_L = 0.02 * (Mat3::Identity() - along * along.transpose());
  }
  for (const char* integrator : kIntegrators) {
    EXPECT_EQ(end_of_run(model, 0.2, integrator), "went through") << integrator;
  }
}

/// Two loops lose rank together: no determinant changes its sign.
TEST(PoseWatch, SeesTwoLoopsPassTheirFlatPoseTogether) {
  Linkage linkage;
  linkage.loops = 2;
  linkage.is_driven = false;
  linkage.rate = 9.0;
  linkage.angle = -0.4;
  expect_to_be_seen(linkage, 1.0);
}

/// A crank-rocker, and a double rocker's cranks nearly as long as each other, which come by the flat pose.
TEST(PoseWatch, LetsARegularLinkageTurnFully) {
  for (const double last_crank : {0.5, 0.21}) {
    Linkage linkage;
    linkage.crank = 0.2;
    linkage.last_crank = last_crank;
    for (const bool is_driven : {true, false}) {
      linkage.is_driven = is_driven;
      linkage.rate = is_driven ? 2.0 : 15.0;
      for (const char* integrator : kIntegrators) {
        for (const int samples : samplings_of(integrator)) {
          EXPECT_EQ(end_of_run(linkage.make(), is_driven ? 4.0 : 1.0, integrator, samples), "went through")
              << integrator << ", " << samples;
        }
      }
    }
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
