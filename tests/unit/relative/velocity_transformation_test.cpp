#include "relative/bodies/velocity_transformation.h"

#include <gtest/gtest.h>

#include "machines.h"
#include "relative/bodies/exponential_map.h"
#include "relative/start/assembly.h"

namespace concord::relative {
namespace {

/// A machine at its start, and the same a little earlier or later along qdot = N(q) u.
class MovingMachine : public ::testing::TestWithParam<bool> {
 protected:
  MovingMachine() : model_(test::tree_of_all_joints(GetParam())), equations_(model_), kinematics_(model_) {
    const Coordinates start = Assembly(equations_).start();
    q_ = start.q;
    u_ = start.u;
    kinematics_.update(q_, u_);
  }

  Kinematics moved(double h) const {
    VecX q = q_;
    for (const Link& link : equations_.topology().links) {
      const Span& joint = equations_.topology().joints[link.joint];
      const VecX step = h * u_.segment(joint.first_u, joint.n_u);
      kinematics_.mobilizer(link.joint).advance(q.data() + joint.first_q, step.data());
      const Span& modes = equations_.topology().modes[link.body];
      q.segment(modes.first_q, modes.n_q) += h * u_.segment(modes.first_u, modes.n_u);
    }
    Kinematics kinematics(model_);
    kinematics.update(q, u_);
    return kinematics;
  }

  Model model_;
  Equations equations_;
  Kinematics kinematics_;
  VecX q_;
  VecX u_;
};

constexpr double kStep = 1e-5;

TEST_P(MovingMachine, VelocitiesAreDerivativesOfPoses) {
  const Kinematics ahead = moved(kStep);
  const Kinematics behind = moved(-kStep);
  for (BodyIndex i(1); i < static_cast<int>(model_.bodies.size()); ++i) {
    const Vec3 v = (ahead.body(i).r - behind.body(i).r) / (2 * kStep);
    const Vec3 omega = rotation_vector(ahead.body(i).A * behind.body(i).A.transpose()) / (2 * kStep);
    EXPECT_LT((kinematics_.body(i).v - v).norm(), 2e-8) << model_.bodies[i].name;
    EXPECT_LT((kinematics_.body(i).omega - omega).norm(), 2e-8) << model_.bodies[i].name;
  }
}

TEST_P(MovingMachine, ExplicitBMapsSpeedsToBodyVelocities) {
  EXPECT_LT((kinematics_.explicit_B() * u_ - kinematics_.Y()).norm(), 1e-13 * kinematics_.Y().norm());
}

TEST_P(MovingMachine, BdotIsTheDerivativeOfB) {
  const VecX expected = (moved(kStep).explicit_B() - moved(-kStep).explicit_B()) / (2 * kStep) * u_;
  EXPECT_LT((kinematics_.Bdot_u() - expected).norm(), 1e-8 * expected.norm());
}

/// Bdot u is the acceleration of all reference points at constant speeds.
TEST_P(MovingMachine, OriginsMoveWithTheReferencePoints) {
  const Kinematics ahead = moved(kStep);
  const Kinematics behind = moved(-kStep);
  const VecX Vdot = kinematics_.Bdot_u();
  for (BodyIndex i(1); i < static_cast<int>(model_.bodies.size()); ++i) {
    SCOPED_TRACE(model_.bodies[i].name);
    const BodyMotion before = behind.motion_of_origin(i);
    const BodyMotion after = ahead.motion_of_origin(i);
    const BodyMotion now = kinematics_.motion_of_origin(i);
    EXPECT_LT((now.v - (after.r - before.r) / (2 * kStep)).norm(), 2e-8);
    const Vec6 acceleration = kinematics_.acceleration_of_origin(i, Vdot.segment<6>(kinematics_.first_row(i)));
    const Vec3 vdot = (after.v - before.v) / (2 * kStep);
    EXPECT_LT((acceleration.head<3>() - vdot).norm(), 1e-8 * vdot.norm() + 2e-8);
    const Link& link = equations_.topology().links[*equations_.topology().link_of_body[i]];
    const Vec3 lever = kinematics_.point(link.joint, link.own_side()).lever;
    EXPECT_EQ(lever.norm() > 0.0, model_.bodies[i].modal.has_value());
    const Vec3 joint_point = model_.joints[link.joint].on(link.own_side()).point_L;
    const Vec3 from_origin = kinematics_.body(i).r - now.r;
    EXPECT_LT((from_origin - (model_.bodies[i].modal ? Vec3(Vec3::Zero()) : Vec3(now.A * joint_point))).norm(), 1e-14);
  }
}

TEST_P(MovingMachine, PlacingBodiesTakesThemAtTheirOrigins) {
  std::vector<BodyState> bodies(model_.bodies.size());
  for (BodyIndex i(1); i < static_cast<int>(bodies.size()); ++i) {
    const BodyMotion origin = kinematics_.motion_of_origin(i);
    const Span& modes = equations_.topology().modes[i];
    bodies[i] = {origin.r,     euler_parameters(origin.A, Vec4::Unit(0)), origin.v,
                 origin.omega, q_.segment(modes.first_q, modes.n_q),      u_.segment(modes.first_u, modes.n_u)};
  }
  Kinematics placed(model_);
  placed.place(bodies);
  for (BodyIndex i(1); i < static_cast<int>(bodies.size()); ++i) {
    EXPECT_LT((placed.body(i).r - kinematics_.body(i).r).norm(), 1e-14) << model_.bodies[i].name;
    EXPECT_LT((placed.body(i).v - kinematics_.body(i).v).norm(), 1e-13) << model_.bodies[i].name;
  }
}

TEST_P(MovingMachine, JointPointsOfBothSidesObeyTheMotion) {
  for (const JointIndex k : upward<JointIndex>(model_.joints.size())) {
    const JointPoint& parent = kinematics_.point(k, Side::parent);
    const JointPoint& child = kinematics_.point(k, Side::child);
    const JointMotion& motion = kinematics_.joint_motion(k);
    EXPECT_LT((parent.A.transpose() * (child.r - parent.r) - motion.d).norm(), 1e-14);
    EXPECT_LT((parent.A.transpose() * child.A - motion.R).norm(), 1e-14);
    EXPECT_LT((relative_velocity(parent, child) - motion.v_rel).norm(), 1e-13);
  }
}

INSTANTIATE_TEST_SUITE_P(Trees, MovingMachine, ::testing::Bool(),
                         [](const auto& tested) { return tested.param ? "flexible" : "rigid"; });

/// Two bodies, flexible if so wished, the second tied to the first by a joint of the type, with or against the tree.
Model two_bodies(const joints::JointType& type, bool along, bool flexible) {
  test::Numbers numbers(91);
  Model model;
  model.file = "two.toml";
  model.bodies = {test::ground()};
  for (const char* name : {"first", "second"})
    model.bodies.push_back(flexible ? test::flexible_body(name, 2, numbers) : test::rigid_body(name, numbers));
  model.joints = {test::joint(model, "flight", "free", 0, 1, numbers),
                  test::joint(model, "J", type.name.c_str(), along ? 1 : 2, along ? 2 : 1, numbers)};
  return model;
}

/// Fixed columns and turns alone are written in closed form: they are what (R20) and (R21) make of the whole motion of
/// the type's words.
TEST(Blocks, OfEveryJointTypeAreThoseOfItsWords) {
  for (const joints::JointType* type : test::all_types()) {
    for (const int variant : {0, 1, 2, 3}) {
      const bool along = variant % 2 == 0;
      const Model model = two_bodies(*type, along, variant >= 2);
      SCOPED_TRACE(type->name + (along ? " along" : " against"));
      Kinematics kinematics(model);
      const Topology& topology = kinematics.topology();
      test::Numbers numbers(92);
      VecX q = numbers.vector(topology.n_q, 0.2);
      const VecX u = numbers.vector(topology.n_u, 1.0);
      for (std::size_t k = 0; k < model.joints.size(); ++k) {
        const Joint& joint = model.joints[k];
        for (std::size_t word = 0; word < joint.start.size(); ++word) {
          const int first = topology.joints[k].first_q + first_q(*joint.type, static_cast<int>(word));
          q.segment(first, joint.start[word].q.size()) = joint.start[word].q;
        }
      }
      kinematics.update(VecX::Constant(q.size(), 0.3), -u);  // nothing is left of another pose
      kinematics.update(q, u);
      const JointIndex k(1);
      const Span& span = topology.joints[k];
      JointMotion motion;
      Mobilizer(*type, kinematics.size().length()).evaluate(q.data() + span.first_q, u.data() + span.first_u, motion);
      const JointMotion& kept = kinematics.joint_motion(k);
      EXPECT_LT((kept.R - motion.R).norm() + (kept.d - motion.d).norm() + (kept.v_rel - motion.v_rel).norm() +
                    (kept.S - motion.S).leftCols(span.n_u).norm() + (kept.Sdot_u - motion.Sdot_u).norm(),
                1e-14);
      const JointPoint& parent = kinematics.point(k, Side::parent);
      const JointPoint& child = kinematics.point(k, Side::child);
      const JointPoint& reference = along ? parent : child;
      const JointPoint& own = along ? child : parent;
      const BodyMotion& body = kinematics.body(BodyIndex(2));
      const double sign = along ? 1.0 : -1.0;
      const auto in_global = [&](const Vec6& v) {
        return (Vec6() << parent.A * v.head<3>(), parent.A * v.tail<3>()).finished();
      };
      const LinkBlocks& blocks = kinematics.blocks(LinkIndex(1));
      EXPECT_LT((blocks.rho - (body.r - kinematics.body(BodyIndex(1)).r)).norm(), 1e-14);
      for (int c = 0; c < span.n_u; ++c) {
        const Vec6 column = sign * shift_motion(in_global(motion.S.col(c)), body.r - child.r);
        EXPECT_LT((blocks.H.col(c) - column).norm(), 1e-14) << c;
      }
      const Vec3 d = parent.A * motion.d;
      Vec6 b = in_global(motion.Sdot_u);
      b.head<3>() += parent.omega.cross(parent.omega.cross(d) + 2.0 * (parent.A * motion.v_rel.head<3>()));
      b.tail<3>() += parent.omega.cross(parent.A * motion.v_rel.tail<3>());
      const Vec6 D = shift_motion(reference.bias, body.r - reference.r) + sign * shift_motion(b, body.r - child.r) -
                     shift_motion(own.bias, body.r - own.r);
      EXPECT_LT((blocks.D - D).norm(), 1e-13);
    }
  }
}

TEST(Shift, MovesMotionsAndWrenchesWithEqualPower) {
  test::Numbers numbers(2);
  const Vec6 V = numbers.vector(6, 1.0);
  const Vec6 w = numbers.vector(6, 1.0);
  const Vec3 e = numbers.vector(1.0);
  EXPECT_NEAR(w.dot(shift_motion(V, e)), shift_wrench(w, e).dot(V), 1e-15);
}

}  // namespace
}  // namespace concord::relative
