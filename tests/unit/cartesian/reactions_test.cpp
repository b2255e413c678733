#include "cartesian/dynamics/reactions.h"

#include <gtest/gtest.h>

#include <memory>

#include "common/joints/catalogue.h"
#include "machines.h"

namespace concord::cartesian {
namespace {

using testing::Numbers;

/// Any multipliers on any type between flexible bodies in any pose: what holds for all of them.
struct SplitRig {
  Model model;
  Layout layout;
  std::unique_ptr<Constraints> constraints;
  const PlacedConstraints* placed;
  VecX lambda;

  SplitRig(unsigned seed, const joints::JointType& type, std::vector<Driver> drivers = {})
      : model(with_drivers(testing::make_pair(seed, type, 2, 3), std::move(drivers))),
        layout(model),
        constraints(Constraints::make(model, layout)) {
    Numbers numbers(seed + 7);
    VecX q = numbers.matrix(layout.n_q(), 1, 0.4);
    layout.normalize(q);
    placed = &constraints->place(q);
    lambda = numbers.matrix(constraints->n_rows(), 1, 10.0);
  }

  static Model with_drivers(Model model, std::vector<Driver> drivers) {
    model.joints[0].drivers = std::move(drivers);
    return model;
  }
  [[nodiscard]] JointWrenches wrenches() const {
    return compute_wrenches(model.joints[0], placed->joint(JointIndex(0)), lambda, nullptr);
  }
};

TEST(Reactions, BothSidesBalanceThoughComputedFromTheirOwnColumns) {
  for (const joints::JointType* type : joints::catalogue()) {
    SCOPED_TRACE(type->name);
    const SplitRig rig(111, *type);
    const JointWrenches wrenches = rig.wrenches();
    const Wrench& child = wrenches.total_on(Side::child).in_global;
    const Wrench& parent = wrenches.total_on(Side::parent).in_global;
    const Vec3& gap = rig.placed->joint(JointIndex(0)).gap;
    EXPECT_LT((parent.force + child.force).norm(), 1e-13 * (1 + child.force.norm()));
    EXPECT_LT((parent.torque + child.torque + gap.cross(child.force)).norm(), 1e-12 * (1 + child.torque.norm()));
  }
}

/// The modal rows of Phi^T lambda must be the virtual work of the reported wrench, (32) with exact J.
TEST(Reactions, ModalRowsAreTheWorkOfTheWrench) {
  const SplitRig rig(113, *joints::find("weld"));
  const JointWrenches wrenches = rig.wrenches();
  for (const Side side : {Side::parent, Side::child}) {
    const JointEquations& joint = rig.placed->joint(JointIndex(0));
    const Marker& marker = joint.marker(side);
    const VecX rows = -(joint.Phi_Y_transposed[index(side)].leftCols(joint.n_rows) * rig.lambda);
    const Wrench& wrench = wrenches.total_on(side).in_global;
    const VecX work = marker.A_Psi_t.transpose() * wrench.force + marker.A_J_Psi_r.transpose() * wrench.torque;
    EXPECT_LT((rows.tail(work.size()) - work).norm(), 1e-12 * work.norm());
  }
}

TEST(Reactions, ADriversCoordinateWrenchIsNoPartOfTheReaction) {
  const SplitRig rig(117, *joints::find("cylindrical"), {{1, ConstantSpeed{0.0, 2.0}}, {0, ConstantSpeed{0.1, 0.3}}});
  const JointWrenches wrenches = rig.wrenches();
  EXPECT_EQ(wrenches.tau, VecX(Eigen::Vector2d(-rig.lambda(5), -rig.lambda(4))));
  const Mat3& A_joint = rig.placed->joint(JointIndex(0)).marker(Side::parent).A_joint;
  const Vec3 z = A_joint.col(2);
  const Wrench& total = wrenches.total_on(Side::child).in_global;
  const Wrench& reaction = wrenches.reaction_on(Side::child).in_global;
  EXPECT_LT((total.force - reaction.force - wrenches.tau(0) * z).norm(), 1e-12);
  EXPECT_LT((total.torque - reaction.torque - wrenches.tau(1) * z).norm(), 1e-12);
}

}  // namespace
}  // namespace concord::cartesian
