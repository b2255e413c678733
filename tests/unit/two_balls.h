#pragma once

#include "common/joints/spherical.h"
#include "compare/audit/places.h"
#include "tests/unit/fake_pendulum.h"

/// The tilted pendulum held by two balls on its axis instead of its hinge: they share the thrust along it in any way,
/// and nothing else. No axis of their frames lies along it.
namespace concord::compare {

inline Model two_balls_model() {
  Model model = pendulum_model();
  const Joint hinge = model.joints[0];
  model.joints.clear();
  for (const double along : {0.0, 0.3}) {
    Joint ball = hinge;
    ball.name = model.joints.empty() ? "near" : "far";
    ball.type = &joints::spherical;
    ball.start = {{}};
    for (Attachment& side : ball.sides) {
      side.point_L += along * side.C.col(2);
      side.C = side.C * rotation_about(Vec3(2, 1, 2) / 3.0, 0.7 - 9.0 * along);
    }
    ball.sides[0].C = ball.sides[0].C * rotation_about(Vec3(-1, 2, 2) / 3.0, 0.4);
    model.joints.push_back(ball);
  }
  return model;
}

/// Of the pendulum that swings about the same axis.
inline State on_two_balls(State of_pendulum) {
  of_pendulum.q = {Vec4::Unit(0), Vec4::Unit(0)};
  of_pendulum.u = {Vec3::Zero(), Vec3::Zero()};
  return of_pendulum;
}

/// The axis, global axes.
inline Vec3 axis_of_balls() { return pendulum_model().joints[0].sides[0].C.col(2); }

/// From the joint's frame on a side to global axes.
inline Mat3 joint_frame_on(const Model& model, const State& state, int joint, Side side) {
  const Attachment& end = model.joints[static_cast<std::size_t>(joint)].on(side);
  return place(end, state.bodies[static_cast<std::size_t>(end.body)]).A_joint;
}

}  // namespace concord::compare
