#include "cartesian/run/step_tolerances.h"

#include <gtest/gtest.h>

#include "cartesian/dynamics/state_scales.h"
#include "common/joints/catalogue.h"
#include "machines.h"

namespace concord::cartesian {
namespace {

/// A flexible body on a rigid one, in motion and not deformed.
class StepTolerancesTest : public ::testing::Test {
 protected:
  StepTolerancesTest()
      : model_(testing::make_pair(151, *joints::find("free"), 0, 2)), equations_(model_), dynamics_(equations_) {
    start_.q = VecX::Zero(equations_.layout().n_q());
    start_.Y = VecX::Zero(equations_.layout().n_Y());
    for (const BodyIndex body : equations_.layout().moving_bodies()) {
      equations_.layout().p(start_.q, body)(0) = 1.0;
      equations_.layout().omega(start_.Y, body) = Vec3(0.3, -0.2, 2.0);
    }
    equations_.update(0.0, start_.q, start_.Y);
  }

  /// Of the modal coordinates, in parts of those by the sizes of the machine.
  [[nodiscard]] VecX shares(const StepTolerances& tolerances) const {
    const VecX asked = kTolerance.rtol * motion_sizes(equations_, start_.q, start_.Y, kTolerance.until);
    const Layout& layout = equations_.layout();
    const VecX& needed = tolerances.absolute();
    return layout.a(needed.head(layout.n_q()), kFlexible).cwiseQuotient(layout.a(asked.head(layout.n_q()), kFlexible));
  }

  /// The start with all modal coordinates at this part of their sizes.
  [[nodiscard]] MotionState deformed(double part) const {
    MotionState motion = start_;
    const Layout& layout = equations_.layout();
    const VecX asked = kTolerance.rtol * motion_sizes(equations_, start_.q, start_.Y, kTolerance.until);
    layout.a(motion.q, kFlexible) = part / kTolerance.rtol * layout.a(asked.head(layout.n_q()), kFlexible);
    return motion;
  }

  static constexpr Tolerance kTolerance{1e-9, 1.0};
  const BodyIndex kFlexible{2};
  Model model_;
  Equations equations_;
  Dynamics dynamics_;
  MotionState start_;
};

TEST_F(StepTolerancesTest, ModesAreHeldByTheLargestVibrationSoFar) {
  StepTolerances tolerances(dynamics_, start_, kTolerance);
  EXPECT_TRUE(shares(tolerances).isApproxToConstant(1e-6, 1e-12)) << shares(tolerances).transpose();
  EXPECT_FALSE(tolerances.follow(0.1, 0.1, deformed(1.5e-6), 0.0)) << "not twice as much as before";
  EXPECT_TRUE(tolerances.follow(0.2, 0.1, deformed(1e-3), 0.0));
  EXPECT_TRUE(shares(tolerances).isApproxToConstant(1e-3, 1e-12)) << shares(tolerances).transpose();
  EXPECT_FALSE(tolerances.follow(0.3, 0.1, deformed(1e-6), 0.0)) << "the largest so far counts";
  EXPECT_TRUE(tolerances.follow(0.4, 0.1, deformed(3.0), 0.0));
  EXPECT_TRUE(shares(tolerances).isApproxToConstant(1.0, 1e-12)) << shares(tolerances).transpose();
}

TEST_F(StepTolerancesTest, ErrorsOfTheWorkCountAgainstTheLargestSoFar) {
  StepTolerances tolerances(dynamics_, start_, kTolerance);
  const double before = tolerances.absolute().tail<1>()(0);
  EXPECT_FALSE(tolerances.follow(0.1, 0.1, start_, 1.5 * before / kTolerance.rtol));
  EXPECT_TRUE(tolerances.follow(0.2, 0.1, start_, 5.0 * before / kTolerance.rtol));
  EXPECT_NEAR(tolerances.absolute().tail<1>()(0), 5.0 * before, 1e-12 * before);
}

}  // namespace
}  // namespace concord::cartesian
