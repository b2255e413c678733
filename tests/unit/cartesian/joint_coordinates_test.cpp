#include "cartesian/bodies/joint_coordinates.h"

#include <gtest/gtest.h>

#include <memory>

#include "cartesian/bodies/euler_parameters.h"
#include "common/joints/catalogue.h"
#include "machines.h"

namespace concord::cartesian {
namespace {

/// A hinge to ground turned by `angle`, read near `known`.
double read_hinge(double angle, double known) {
  Model model = testing::make_pair(91, *joints::find("revolute"), 0, 0);
  const Layout layout(model);
  const std::unique_ptr<Constraints> constraints = Constraints::make(model, layout);
  VecX q = VecX::Zero(layout.n_q());
  const Joint& hinge = model.joints[0];
  const Mat3 A_parent = rotation_about(Vec3(1, 2, -1).normalized(), 0.7);
  layout.p(q, BodyIndex(1)) = euler_parameters_of(A_parent);
  layout.p(q, BodyIndex(2)) = euler_parameters_of(A_parent * hinge.on(Side::parent).C * rotation_about(Axis::z, angle) *
                                                  hinge.on(Side::child).C.transpose());
  const MovingConstraints& resting = constraints->place(q).move(VecX(VecX::Zero(layout.n_Y())));
  std::vector<VecX> coordinates{VecX::Constant(1, known)};
  std::vector<VecX> speeds = zero_speeds(model);
  read_joint_coordinates(model, resting, coordinates, speeds);
  return coordinates[0](0);
}

TEST(JointCoordinates, CountTurnsFromTheLastKnownAngle) {
  const double turn = 2.0 * EIGEN_PI;
  EXPECT_NEAR(read_hinge(0.4, 0.0), 0.4, 1e-14);
  EXPECT_NEAR(read_hinge(0.4, 3 * turn + 0.1), 3 * turn + 0.4, 1e-13);
  EXPECT_NEAR(read_hinge(3.0, -turn - 3.2), -turn - 3.2 + (-turn + 6.2), 1e-13);
}

TEST(JointCoordinates, StartFromWhatTheModelSaysAndDriversFromTheirLaw) {
  Model model = testing::make_pair(93, *joints::find("cylindrical"), 0, 0);
  model.joints[0].start[0].q(0) = 0.25;
  model.joints[0].drivers = {{1, ConstantSpeed{1.5, 3.0}}};
  const std::vector<VecX> q = start_coordinates(model);
  EXPECT_EQ(q[0], VecX(Eigen::Vector2d(0.25, 1.5)));
}

}  // namespace
}  // namespace concord::cartesian
