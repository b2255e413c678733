#include "relative/bodies/topology.h"

#include <gtest/gtest.h>

#include "machines.h"

namespace concord::relative {
namespace {

using test::four_bar;
using test::spatial_slider_crank;

TEST(Topology, CutsTheJointWithTheFewestRows) {
  const Model model = spatial_slider_crank(false);
  const Topology topology = build_topology(model);
  ASSERT_EQ(topology.cuts.size(), 1u);
  EXPECT_EQ(model.joints[topology.cuts[0]].name, "B");
}

TEST(Topology, CountsADriverAsARow) {
  Model model = spatial_slider_crank(false);
  model.joints[1].type = joints::find("universal");
  model.joints[1].drivers.push_back({0, ConstantSpeed{}});
  model.joints[1].start.resize(2);
  const Topology topology = build_topology(model);
  EXPECT_EQ(model.joints[topology.cuts[0]].name, "C");
}

TEST(Topology, AmongEqualsCutsTheOneFarthestFromGround) {
  const Model model = four_bar();
  const Topology topology = build_topology(model);
  ASSERT_EQ(topology.cuts.size(), 1u);
  EXPECT_EQ(model.joints[topology.cuts[0]].name, "C");
}

TEST(Topology, CutsTheNamedJointAndRunsAgainstJointsWhereItMust) {
  Model model = spatial_slider_crank(false);
  model.joints[0].named_as_cut = true;
  const Topology topology = build_topology(model);
  ASSERT_EQ(topology.cuts, std::vector{JointIndex(0)});
  // Ground - D - slider - C - coupler - B - crank; D and C have the body nearer to ground as child, B as parent.
  ASSERT_EQ(topology.links.size(), 3u);
  EXPECT_EQ(topology.links[0].joint, 3);
  EXPECT_FALSE(topology.links[0].along);
  EXPECT_EQ(topology.links[1].joint, 2);
  EXPECT_FALSE(topology.links[1].along);
  EXPECT_EQ(topology.links[2].joint, 1);
  EXPECT_TRUE(topology.links[2].along);
}

TEST(Topology, TellsAMotionAtTheJointOnlyNearTheMass) {
  Model model = spatial_slider_crank(false);
  const Link link = build_topology(model).links[0];
  Vec3& point_L = model.joints[link.joint].sides[static_cast<std::size_t>(link.own_side())].point_L;
  EXPECT_EQ(build_topology(model).reference_points_L[link.body], point_L);
  point_L += Vec3(100.0, 0.0, 0.0);
  EXPECT_EQ(build_topology(model).reference_points_L[link.body], Vec3(Vec3::Zero()));
  model.bodies[link.body].center_of_mass_L = point_L + Vec3(0.0, 0.1, 0.0);
  EXPECT_EQ(build_topology(model).reference_points_L[link.body], point_L);
}

TEST(Topology, LaysOutTreeSpeedsLinkByLinkAndCutJointsLast) {
  const Model model = spatial_slider_crank(true);
  const Topology topology = build_topology(model);
  int next = 0;
  for (const Link& link : topology.links) {
    EXPECT_EQ(topology.joints[link.joint].first_u, next);
    next += topology.joints[link.joint].n_u;
    EXPECT_EQ(topology.modes[link.body].first_u, next);
    next += model.bodies[link.body].n_modes();
  }
  EXPECT_EQ(next, topology.n_tree_u);
  EXPECT_EQ(topology.joints[topology.cuts[0]].first_u, topology.n_tree_u);
  EXPECT_EQ(topology.n_u, topology.n_tree_u + 3);
}

TEST(Topology, RefusesNamedCutsThatSeverTheMachine) {
  Model model = spatial_slider_crank(false);
  model.joints[0].named_as_cut = true;
  model.joints[1].named_as_cut = true;
  try {
    build_topology(model);
    FAIL() << "two cuts in one loop were accepted";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "slider_crank.toml:10:1: error: with the joints named as cut ('A', 'B') opened, no way leads from "
                 "ground to 'crank': name one cut joint per loop");
  }
}

TEST(Topology, RefusesABodyWithoutJoint) {
  Model model = spatial_slider_crank(false);
  test::Numbers numbers(3);
  model.bodies.push_back(test::rigid_body("lost", numbers));
  try {
    build_topology(model);
    FAIL() << "a body without joint was accepted";
  } catch (const InputError& error) {
    EXPECT_STREQ(
        error.what(),
        "slider_crank.toml: error: no joint connects 'lost' to ground: add a joint (type 'free' for a body that "
        "moves freely)");
  }
}

}  // namespace
}  // namespace concord::relative
