#include "cartesian/pose_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cartesian/solver.h"
#include "common/error.h"
#include "common/joints/catalogue.h"
#include "machines.h"

namespace concord::cartesian {
namespace {

using ::testing::HasSubstr;

/// Planar linkages in a tilted world: hinges along z, cranks of `crank`, couplers of `coupler`, ground points `pitch`
/// apart; the first crank starts at `angle` and turns at `rate`, by a driver or by itself.
struct Linkage {
  double crank = 0.3;
  double last_crank = 0.3;
  double coupler = 0.7;
  double pitch = 0.7;
  double angle = 0.5;
  double rate = 2.0;
  int loops = 1;
  bool is_driven = true;

  [[nodiscard]] Model make() const {
    testing::Numbers numbers(151);
    Model model;
    model.name = "linkage";
    model.file = "linkage.toml";
    model.gravity = {1.1, -2.3, 0.4};
    model.bodies.resize(1);
    for (int i = 0; i <= 2 * loops; ++i) model.bodies.push_back(testing::make_body(numbers, "link", 0));
    add_hinge(model, "A0", kGround, Vec3::Zero(), 1, Vec3::Zero());
    for (int loop = 0; loop < loops; ++loop) {
      const int before = 1 + 2 * loop;
      const double own = loop + 1 == loops ? last_crank : crank;
      add_hinge(model, "B", before, Vec3(crank, 0.0, 0.0), before + 1, Vec3::Zero());
      add_hinge(model, "C", before + 1, Vec3(coupler, 0.0, 0.0), before + 2, Vec3(own, 0.0, 0.0));
      add_hinge(model, "D", kGround, Vec3((loop + 1) * pitch, 0.0, 0.0), before + 2, Vec3::Zero());
    }
    place(model);
    if (is_driven) {
      model.joints[0].drivers = {{0, ConstantSpeed{angle, rate}, 0}};
    } else {
      WordStart& start = model.joints[0].start[0];
      start.role_q = start.role_u = StartRole::keep;
      start.q(0) = angle;
      start.u(0) = rate;
    }
    return model;
  }

 private:
  static void add_hinge(Model& model, const std::string& name, int parent, const Vec3& at_parent, int child,
                        const Vec3& at_child) {
    testing::Numbers numbers(152);
    Joint joint = testing::make_joint(numbers, model, *joints::find("revolute"), parent, child);
    joint.name = name;
    joint.sides = {testing::rigid(parent, at_parent, Mat3::Identity()),
                   testing::rigid(child, at_child, Mat3::Identity())};
    model.joints.push_back(joint);
  }

  void place(Model& model) const {
    const Vec3 along(std::cos(angle), std::sin(angle), 0.0);
    for (int i = 1; i < static_cast<int>(model.bodies.size()); ++i) {
      const bool is_crank = i % 2 == 1;
      const Vec3 at = Vec3((i - 1) / 2 * pitch, 0.0, 0.0) + (is_crank ? Vec3(Vec3::Zero()) : Vec3(crank * along));
      model.bodies[i].pose_guess = Pose{at, rotation_about(Axis::z, is_crank ? angle : 0.0)};
    }
  }
};

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

/// Flat at a half turn, 1.3 s after the start.
TEST(PoseWatch, SeesAParallelogramPassItsFlatPoseBetweenSteps) {
  Linkage linkage;
  linkage.angle = EIGEN_PI - 1.3 * linkage.rate;
  for (const char* integrator : {"gbs", "ida"}) {
    const std::string end = end_of_run(linkage.make(), 2.0, integrator);
    EXPECT_THAT(end, HasSubstr("cartesian: at t = 1.3"));
    EXPECT_THAT(end, HasSubstr("the motion passes a singular pose: constraints lose rank at joint"));
  }
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
