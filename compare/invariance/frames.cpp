#include "compare/invariance/frames.h"

#include <memory>

#include "common/overloaded.h"
#include "compare/audit/places.h"

namespace concord::compare::invariance {

namespace {

Pose inverse_frame(const Pose& frame) { return {-(frame.A.transpose() * frame.r), frame.A.transpose()}; }

Model with_frames(Model model, const std::vector<Pose>& frames) {
  for (std::size_t i = 1; i < frames.size(); ++i) model.bodies[i] = with_frame(std::move(model.bodies[i]), frames[i]);
  for (ForceElement& element : model.elements) {
    auto* load = std::get_if<Load>(&element.what);
    if (load == nullptr || load->axes != LoadAxes::body || load->at.body == kGround) continue;
    const Mat3 to_new = frames[static_cast<std::size_t>(load->at.body)].A.transpose();
    load->force = to_new * load->force;
    load->torque = to_new * load->torque;
  }
  for_each_attachment(model, [&](Attachment& side) {
    const Pose& frame = frames[static_cast<std::size_t>(side.body)];
    if (side.body != kGround) side = with_frame(std::move(side), frame);
  });
  return model;
}

State moved_state(State state, const std::vector<Pose>& frames) {
  for (std::size_t i = 1; i < frames.size(); ++i) state.bodies[i] = moved_motion(std::move(state.bodies[i]), frames[i]);
  return state;
}

}  // namespace

Change with_body_frames(const std::vector<Pose>& frames) {
  std::vector<Pose> inverse;
  for (const Pose& frame : frames) inverse.push_back(inverse_frame(frame));
  Change change;
  change.model = [frames](Model model) { return with_frames(std::move(model), frames); };
  change.state = [frames](State state) { return moved_state(std::move(state), frames); };
  change.back = [inverse](State state) { return moved_state(std::move(state), inverse); };
  change.evaluation = [frames](const State& before, Evaluation evaluation) {
    for (std::size_t i = 1; i < frames.size(); ++i) {
      const Vec3 arm = rotation_of(before.bodies[i].p) * frames[i].r;
      take_arm_off(arm, before.bodies[i].omega, evaluation.bodies[i]);
    }
    return evaluation;
  };
  return change;
}

namespace {

Road moved_road(Road road, const Vec3& by) {
  std::visit(
      Overloaded{[&](FlatRoad& flat) { flat.height += by.z(); }, [&](HalfSineBump& bump) { bump.start += by.x(); },
                 [&](RoadTable& table) {
                   std::vector<double> xs = table.spline.times();
                   std::vector<double> heights = table.spline.values();
                   for (double& x : xs) x += by.x();
                   for (double& height : heights) height += by.z();
                   table = {SplineTable(xs, heights), table.first + by.x(), table.last + by.x()};
                 }},
      road.profile);
  return road;
}

Model model_in_world(Model model, const Pose& world) {
  model.gravity = world.A * model.gravity;
  for (Body& body : model.bodies) {
    if (body.pose_guess) body.pose_guess = Pose{world.r + world.A * body.pose_guess->r, world.A * body.pose_guess->A};
  }
  for_each_attachment(model, [&](Attachment& side) {
    if (side.body != kGround) return;
    side.point_L = world.r + world.A * side.point_L;
    side.C = world.A * side.C;
  });
  for (ForceElement& element : model.elements) {
    if (auto* tire = std::get_if<Tire>(&element.what)) {
      tire->road = std::make_shared<const Road>(moved_road(*tire->road, world.r));
    }
    auto* load = std::get_if<Load>(&element.what);
    if (load == nullptr) continue;
    // Ground's own axes turn with the world.
    if (load->axes == LoadAxes::global || (load->axes == LoadAxes::body && load->at.body == kGround)) {
      load->force = world.A * load->force;
      load->torque = world.A * load->torque;
    }
  }
  return model;
}

State state_in_world(State state, const Pose& world) {
  for (std::size_t i = 1; i < state.bodies.size(); ++i) {
    BodyState& body = state.bodies[i];
    body.r = world.r + world.A * body.r;
    body.p = euler_parameters_of(world.A * rotation_of(body.p));
    body.v = world.A * body.v;
    body.omega = world.A * body.omega;
  }
  return state;
}

}  // namespace

namespace {

bool is_level(const Road& road) {
  const auto* bump = std::get_if<HalfSineBump>(&road.profile);
  return std::holds_alternative<FlatRoad>(road.profile) || (bump != nullptr && bump->height == 0.0);
}

}  // namespace

WorldFreedom freedom_of_world(const Model& model) {
  WorldFreedom freedom;
  for (const ForceElement& element : model.elements) {
    const auto* tire = std::get_if<Tire>(&element.what);
    if (tire == nullptr) continue;
    freedom.turns = false;
    if (!is_level(*tire->road)) freedom.turns_about_vertical = false;
    if (std::holds_alternative<HalfSineBump>(tire->road->profile)) freedom.rises = false;
  }
  return freedom;
}

Change in_world(const Pose& world) {
  const Pose inverse = inverse_frame(world);
  Change change;
  change.model = [world](Model model) { return model_in_world(std::move(model), world); };
  change.state = [world](State state) { return state_in_world(std::move(state), world); };
  change.back = [inverse](State state) { return state_in_world(std::move(state), inverse); };
  change.evaluation = [world](const State&, Evaluation evaluation) {
    const Mat3 back = world.A.transpose();
    for (BodyAcceleration& body : evaluation.bodies) {
      body.vdot = back * body.vdot;
      body.omegadot = back * body.omegadot;
    }
    for_each_wrench(evaluation, [&](SideWrench& side) {
      side.in_global = {back * side.in_global.force, back * side.in_global.torque};
    });
    return evaluation;
  };
  return change;
}

}  // namespace concord::compare::invariance
