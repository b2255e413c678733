#include "tests/benchmarks/chain.h"

#include <Eigen/Geometry>
#include <random>

#include "common/joints/revolute.h"
#include "common/rotation.h"

namespace concord::benchmarks {

namespace {

/// Numbers between -1 and 1, the same with every compiler.
class Numbers {
 public:
  double next() { return static_cast<double>(generator_()) / 2147483647.5 - 1.0; }
  Vec3 vector() {
    const double x = next();
    const double y = next();
    return {x, y, next()};
  }
  Mat3 rotation() {
    const Vec3 axis = vector().normalized();
    return rotation_about(axis, 2.0 * next());
  }

 private:
  std::mt19937 generator_{1997};
};

Body make_body(int number, Numbers& numbers) {
  Body body;
  body.name = "link " + std::to_string(number);
  body.mass = 1.0 + 0.5 * numbers.next();
  body.center_of_mass_L = Vec3(0.2, 0.0, 0.0) + 0.05 * numbers.vector();
  const Mat3 axes = numbers.rotation();
  const Vec3 second_moments = body.mass * (Vec3::Constant(0.006) + 0.004 * numbers.vector());
  const Vec3 principal = Vec3::Constant(second_moments.sum()) - second_moments;
  body.inertia_L = axes * principal.asDiagonal() * axes.transpose();
  return body;
}

Joint make_joint(int number, Numbers& numbers) {
  Joint joint;
  joint.name = "J" + std::to_string(number);
  joint.type = &joints::revolute;
  Attachment& parent = joint.sides[index(Side::parent)];
  Attachment& child = joint.sides[index(Side::child)];
  parent.body = number;
  parent.point_L = Vec3(0.4, 0.0, 0.0) + 0.05 * numbers.vector();
  parent.C = numbers.rotation();
  child.body = number + 1;
  child.point_L = 0.05 * numbers.vector();
  child.C = numbers.rotation();
  joint.start.resize(1);
  joint.start[0] = {StartRole::keep, StartRole::keep, VecX::Zero(1), VecX::Zero(1)};
  return joint;
}

/// Pose and velocity of the child from those of the parent.
BodyState move_child(const Joint& joint, const BodyState& parent, double angle, double speed) {
  const auto rotation = [](const Vec4& p) { return Eigen::Quaterniond(p(0), p(1), p(2), p(3)).toRotationMatrix(); };
  const Attachment& on_parent = joint.on(Side::parent);
  const Attachment& on_child = joint.on(Side::child);
  const Mat3 A_parent = rotation(parent.p);
  const Mat3 A_joint = A_parent * on_parent.C;
  const Mat3 A = A_joint * rotation_about(Axis::z, angle) * on_child.C.transpose();
  const Eigen::Quaterniond p = Eigen::Quaterniond(A).normalized();
  const Vec3 to_joint = A_parent * on_parent.point_L;
  const Vec3 from_joint = -(rotation(Vec4(p.w(), p.x(), p.y(), p.z())) * on_child.point_L);
  BodyState child;
  child.p = Vec4(p.w(), p.x(), p.y(), p.z());
  child.r = parent.r + to_joint + from_joint;
  child.omega = parent.omega + speed * A_joint.col(2);
  child.v = parent.v + parent.omega.cross(to_joint) + child.omega.cross(from_joint);
  child.a = child.adot = VecX(0);
  return child;
}

}  // namespace

Chain make_chain(int n) {
  Numbers numbers;
  Chain chain;
  chain.model.name = "chain of " + std::to_string(n);
  chain.model.gravity = Vec3(1.0, -2.0, -9.5);
  chain.model.bodies.resize(1);
  chain.model.bodies[kGround].name = "ground";
  chain.angles = VecX(n);
  chain.speeds = VecX(n);
  chain.state.bodies.resize(1);
  chain.state.bodies[kGround].a = chain.state.bodies[kGround].adot = VecX(0);
  for (int k = 0; k < n; ++k) {
    chain.model.bodies.push_back(make_body(k + 1, numbers));
    chain.model.bodies.back().a_start = chain.model.bodies.back().adot_start = VecX(0);
    chain.model.joints.push_back(make_joint(k, numbers));
    chain.angles(k) = 0.8 * numbers.next();
    chain.speeds(k) = numbers.next();
    chain.state.bodies.push_back(
        move_child(chain.model.joints.back(), chain.state.bodies.back(), chain.angles(k), chain.speeds(k)));
    chain.state.q.emplace_back(chain.angles.segment<1>(k));
    chain.state.u.emplace_back(chain.speeds.segment<1>(k));
  }
  return chain;
}

}  // namespace concord::benchmarks
