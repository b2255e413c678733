#include "cartesian/closing.h"

#include <gtest/gtest.h>

#include "common/joints/catalogue.h"
#include "machines.h"

namespace concord::cartesian {
namespace {

/// Every type between flexible bodies, from guesses that are off by a tenth.
TEST(Closing, ClosesEveryTypeToRoundOffAndLeavesTheModesAlone) {
  int closed = 0;
  for (const joints::JointType* type : joints::catalogue()) {
    SCOPED_TRACE(type->name);
    const Model model = testing::make_pair(141, *type, 2, 3);
    Equations equations(model);
    testing::Numbers numbers(142);
    VecX q = numbers.matrix(equations.layout().n_q(), 1, 0.1);
    VecX Y = numbers.matrix(equations.layout().n_Y(), 1);
    const std::vector<Pose> guesses = guess_poses(model);
    for (int i = 1; i < 3; ++i) {
      equations.layout().r(q, i) += guesses[i].r;
      equations.layout().p(q, i) += Vec4::Unit(0);
    }
    const VecX a = equations.layout().a(q, 2);
    const Closing closing = close_machine(equations, 0.0, Hold::constraints, Modes::kept, q, Y);
    if (!closing.closed) {  // random frames may lead Newton to the wrong branch, which is told
      EXPECT_EQ(closing.joints_left_open, std::vector<std::string>{type->name});
      continue;
    }
    ++closed;
    EXPECT_LT(closing.position_residual, 1e-14);
    EXPECT_EQ(VecX(equations.layout().a(q, 2)), a);
  }
  EXPECT_GE(closed, 5);
}

TEST(Closing, CountsKeptCoordinatesAgainstTheFreedom) {
  Model model = testing::make_pair(143, *joints::find("universal"), 0, 0);
  model.joints[0].sides[0] = {kGround, Vec3(0.1, 0.2, -0.3), rotation_about(Vec3(1, 1, 2).normalized(), 0.4),
                              Mat3X(3, 0), Mat3X(3, 0)};
  model.joints[0].sides[1].body = 1;
  model.bodies.pop_back();
  for (WordStart& start : model.joints[0].start) start.role_q = StartRole::keep;
  model.joints[0].start[0].role_u = StartRole::keep;
  Equations equations(model);
  VecX q = VecX::Zero(7);
  q(3) = 1.0;
  VecX Y = VecX::Zero(6);
  ASSERT_TRUE(close_machine(equations, 0.0, Hold::start, Modes::kept, q, Y).closed);
  const KeptCount kept = count_kept(equations, 0.0, q, Y);
  EXPECT_EQ(kept.coordinates, 2);
  EXPECT_EQ(kept.speeds, 1);
  EXPECT_EQ(kept.coordinate_freedom, 2);
  EXPECT_EQ(kept.speed_freedom, 2);
  EXPECT_EQ(kept.independent_coordinates, 2);
  EXPECT_EQ(kept.independent_speeds, 1);
}

}  // namespace
}  // namespace concord::cartesian
