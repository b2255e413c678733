#include "cartesian/dynamics/equations.h"

#include <gtest/gtest.h>

#include "two_bodies.h"

namespace concord::cartesian {
namespace {

using testing::Numbers;

/// A turn and a slide with springs and stops that a coupling relates.
Model sprung_screw() {
  Model model = testing::make_pair(111, *joints::find("cylindrical"), 1, 2);
  for (const int word : {0, 1}) {
    JointSpring spring;
    spring.word = word;
    spring.law.stiffness = 20.0;
    spring.law.upper = SmoothStop{.at = 0.1, .stiffness = 300.0, .damping = 2.0, .width = 0.05};
    model.joints[0].springs.push_back(spring);
  }
  model.couplings.push_back({"thread", {{0, 0, 0, 1.0}, {0, 1, 0, 0.1}}, 0.0, {}});
  return model;
}

/// Who works on a copy of the equations sees the turns that are counted and the regimes that are held.
TEST(Equations, ACopyCountsTurnsAndHoldsRegimesAsTheOther) {
  const Model model = sprung_screw();
  Equations equations(model);
  Equations copy(model);
  Numbers numbers(112);
  VecX q = numbers.matrix(equations.layout().n_q(), 1, 0.4);
  equations.layout().normalize(q);
  const VecX Y = numbers.matrix(equations.layout().n_Y(), 1, 1.5);
  equations.count_turns_from({Eigen::Vector2d(0.3, 6.0 * EIGEN_PI)});
  equations.update(0.0, q, Y);  // in the regimes of this state
  equations.applied().freeze_regimes(true);
  equations.count_turns_from({Eigen::Vector2d(0.3, -6.0 * EIGEN_PI)});
  equations.update(0.0, q, Y);
  copy.update(0.0, q, Y);
  EXPECT_GT((copy.forces() - equations.forces()).norm(), 1.0);
  EXPECT_GT((copy.residual() - equations.residual()).norm(), 0.1);
  copy.count_turns_and_hold_regimes_as(equations);
  copy.update(0.0, q, Y);
  EXPECT_EQ(copy.forces(), equations.forces());
  EXPECT_EQ(copy.residual(), equations.residual());
}

}  // namespace
}  // namespace concord::cartesian
