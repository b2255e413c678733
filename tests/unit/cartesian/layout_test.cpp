#include "cartesian/bodies/layout.h"

#include <gtest/gtest.h>

#include "cartesian/bodies/euler_parameters.h"
#include "common/joints/catalogue.h"
#include "machines.h"

namespace concord::cartesian {
namespace {

TEST(Layout, PacksAStateAndUnpacksTheSameNumbers) {
  const Model model = testing::make_pair(81, *joints::find("revolute"), 2, 3);
  const Layout layout(model);
  EXPECT_EQ(layout.n_q(), 14 + 5);
  EXPECT_EQ(layout.n_Y(), 12 + 5);
  const VecX q = VecX::LinSpaced(layout.n_q(), 1.0, 2.0);
  const VecX Y = VecX::LinSpaced(layout.n_Y(), -1.0, 1.0);
  const State state = layout.pack(0.7, q, Y);
  EXPECT_EQ(state.bodies.size(), 3u);
  EXPECT_EQ(state.bodies[kGround].p, Vec4(Vec4::Unit(0)));
  VecX q_again(layout.n_q());
  VecX Y_again(layout.n_Y());
  layout.unpack(state, q_again, Y_again);
  EXPECT_EQ(q_again, q);
  EXPECT_EQ(Y_again, Y);
}

TEST(Layout, ASmallDisplacementTurnsInGlobalAxes) {
  const Model model = testing::make_pair(83, *joints::find("free"), 0, 0);
  const Layout layout(model);
  testing::Numbers numbers(83);
  VecX q = numbers.matrix(layout.n_q(), 1);
  layout.normalize(q);
  const Mat3 before = rotation_of(layout.p(q, BodyIndex(2)));
  VecX step = VecX::Zero(layout.n_Y());
  const Vec3 turn(1e-5, -2e-5, 3e-5);
  layout.omega(step, BodyIndex(2)) = turn;
  layout.displace(step, q);
  EXPECT_NEAR(layout.p(q, BodyIndex(2)).norm(), 1.0, 1e-15);
  EXPECT_LT((rotation_of(layout.p(q, BodyIndex(2))) - rotation_about(turn.normalized(), turn.norm()) * before).norm(),
            1e-13);
}

}  // namespace
}  // namespace concord::cartesian
