#include "compare/audit/same_machine.h"

#include <gmock/gmock.h>

#include <functional>
#include <memory>
#include <utility>

#include "common/flexible/beam.h"
#include "common/reading/model_file.h"
#include "common/rotation.h"

namespace concord::compare {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

/// A rigid body, and a beam on it, in tilted frames far from them, with loads and a spring.
Model far_machine() {
  return parse_model(R"toml(format = 1
gravity = [0.7, -9.6, 1.5]
[[body]]
name = "lever"
mass = 0.9
center_of_mass = [17.36, -8.13, 6.42]
inertia = [0.0041, 0.0067, 0.0054, 0.0006, -0.0003, 0.0008]
[[body]]
name = "leaf"
start.a = [2e-3, -1e-3]
[body.beam]
first_end = [17.52, -8.03, 6.29]
x = [6, 2, -3]
z = [2, 3, 6]
length = 0.4
elements = 4
section = { width_y = 0.02, width_z = 0.012 }
youngs_modulus = 2.0e9
poissons_ratio = 0.3
density = 1500
support = "simply_supported"
modes = { bending_xy = [1], bending_xz = [1] }
[[joint]]
name = "pin"
type = "revolute"
parent = { body = "ground", point = [0.2, -0.1, 0.3], x = [1, 2, 2], z = [2, 1, -2] }
child = { body = "lever", point = [17.3, -8.1, 6.4], axis = [1, -1, 2], angle = "35 deg" }
start.turn_z = { keep = 0.4, keep_speed = 4.0 }
[[joint]]
name = "cross"
type = "universal"
parent = { body = "lever", point = [17.45, -8.07, 6.34], axis = [2, 1, -1], angle = "50 deg" }
child = { body = "leaf", node = "first", offset = [0.01, -0.02, 0.015], axis = [-1, 2, 1], angle = "25 deg" }
start.turn_x = { keep = 0.3 }
start.turn_y = { keep = -0.5 }
[[load]]
name = "push"
body = "lever"
point = [17.31, -8.2, 6.35]
axes = "body"
force = [2.0, -3.0, 1.0]
torque = [0.3, 0.2, -0.5]
[[line_spring]]
name = "strut"
parent = { body = "ground", point = [-0.1, 0.3, 0.5] }
child = { body = "leaf", node = "2" }
stiffness = 40.0
free = 0.3
)toml",
                     "far.toml");
}

const Vec3 kWorld(3.0, -40.0, 12.0);
const Vec3 kAway(17.4, -8.1, 6.3);

/// The frame of each body: of ground moved, of the others moved and turned.
Pose frame_of(int body) {
  if (body == kGround) return {kWorld, Mat3::Identity()};
  return {kAway + 0.1 * body * Vec3(1, 2, -1), rotation_about(Vec3(2, -1, 2) / 3.0, 0.4 * body)};
}

Vec3 moved(const Vec3& s_L, const Pose& frame) { return frame.A.transpose() * (s_L - frame.r); }

void move(Attachment& side) {
  const Pose frame = frame_of(side.body);
  side.point_L = moved(side.point_L, frame);
  side.C = frame.A.transpose() * side.C;
  side.Psi_t_L = frame.A.transpose() * side.Psi_t_L;
  side.Psi_r_L = frame.A.transpose() * side.Psi_r_L;
}

void move(ModalData& modal, const Pose& frame) {
  for (ModalNode& node : modal.nodes) {
    node.s0_L = moved(node.s0_L, frame);
    node.Psi_t_L = frame.A.transpose() * node.Psi_t_L;
    node.Psi_r_L = frame.A.transpose() * node.Psi_r_L;
  }
  for (MassPoint& point : modal.mass_points) {
    point.s0_L = moved(point.s0_L, frame);
    point.Psi_t_L = frame.A.transpose() * point.Psi_t_L;
  }
  modal.G = mass_integrals(modal.mass_points, modal.n_modes());
  BeamSpecification beam = *modal.beam;
  beam.first_end_L = moved(beam.first_end_L, frame);
  beam.axes = frame.A.transpose() * beam.axes;
  modal.beam = std::make_shared<const BeamSpecification>(beam);
}

/// The same machine in other frames, by hand.
Model in_other_frames(Model model) {
  Body& lever = model.bodies[1];
  const Pose frame = frame_of(1);
  lever.center_of_mass_L = moved(lever.center_of_mass_L, frame);
  lever.inertia_L = frame.A.transpose() * lever.inertia_L * frame.A;
  move(*model.bodies[2].modal, frame_of(2));
  for (Joint& joint : model.joints) {
    for (Attachment& side : joint.sides) move(side);
  }
  auto& push = std::get<Load>(model.elements[0].what);
  move(push.at);
  push.force = frame.A.transpose() * push.force;
  push.torque = frame.A.transpose() * push.torque;
  for (Attachment& end : std::get<LineSpring>(model.elements[1].what).ends) move(end);
  return model;
}

TEST(SameMachine, MachineInOtherFramesIsTheSame) {
  const Model given = far_machine();
  EXPECT_EQ(difference_of_machines(given, in_other_frames(given), kWorld), "");
  EXPECT_EQ(difference_of_machines(given, given, Vec3::Zero()), "");
}

TEST(SameMachine, PlaceOffIsToldWithItsDistance) {
  const Model given = far_machine();
  Model changed = in_other_frames(given);
  std::get<Load>(changed.elements[0].what).at.point_L.y() += 2e-9;
  EXPECT_THAT(difference_of_machines(given, changed, kWorld),
              StartsWith("point of the child of 'push': off by 2e-09 m, allowed 4.2e-11 m"));
}

/// Something that a change of frames forgot or did wrongly, and how it is told.
struct Slip {
  std::function<void(Model&)> spoil;
  const char* told;
};

ModalData& leaf(Model& model) { return *model.bodies[2].modal; }

TEST(SameMachine, EveryThingThatIsMovedWronglyIsNamed) {
  const Model given = far_machine();
  const std::vector<Slip> slips{
      {[](Model& m) { m.bodies[1].center_of_mass_L = far_machine().bodies[1].center_of_mass_L; },
       "mass centre of body 'lever'"},
      {[](Model& m) { m.bodies[1].mass *= 1.0 + 1e-11; }, "mass of body 'lever'"},
      {[](Model& m) { m.bodies[1].inertia_L(0, 1) += 1e-8; }, "inertia of body 'lever'"},
      {[](Model& m) { m.joints[1].sides[0].point_L.x() += 1e-9; }, "of joint 'cross'"},
      {[](Model& m) { m.joints[0].sides[0] = far_machine().joints[0].sides[0]; }, "off by 41.9 m"},
      {[](Model& m) { m.elements[0] = far_machine().elements[0]; }, "'push'"},
      {[](Model& m) { std::get<Load>(m.elements[0].what).force *= -1.0; }, "force of the load 'push'"},
      {[](Model& m) { std::get<Load>(m.elements[0].what).torque.x() += 1e-9; }, "torque of the load 'push'"},
      {[](Model& m) {
         std::get<LineSpring>(m.elements[1].what)
             .ends[1]
             .C.col(0)
             .swap(std::get<LineSpring>(m.elements[1].what).ends[1].C.col(1));
       },
       "axes of the child of 'strut'"},
      {[](Model& m) { std::get<LineSpring>(m.elements[1].what).ends[1].Psi_t_L *= -1.0; },
       "mode shapes of the child of 'strut'"},
      {[](Model& m) { leaf(m).nodes[2].s0_L.z() += 1e-9; }, "node '2' of body 'leaf'"},
      {[](Model& m) { leaf(m).nodes[2].Psi_r_L *= 1.001; }, "mode shapes of node '2' of body 'leaf'"},
      {[](Model& m) { leaf(m).mass_points[3].s0_L.z() += 1e-9; }, "of body 'leaf'"},
      {[](Model& m) { leaf(m).mass_points[3].mass *= 1.001; }, "of body 'leaf'"},
      {[](Model& m) { leaf(m).G = leaf(*std::make_unique<Model>(far_machine())).G; }, "mass integrals of body 'leaf'"},
      {[](Model& m) { leaf(m).G(1, 1) *= 1.0 + 1e-9; }, "mass integrals of body 'leaf'"},
      {[](Model& m) { leaf(m).stiffness *= 1.001; }, "modal stiffness of body 'leaf'"},
      {[](Model& m) { leaf(m).beam = far_machine().bodies[2].modal->beam; }, "of body 'leaf'"},
      {[](Model& m) { leaf(m).beam.reset(); }, "modal data of body 'leaf': not the same"},
      {[](Model& m) { m.bodies[2].pose_guess = Pose{}; }, "of joint 'cross'"},
      {[](Model& m) { m.joints[0].start[0].q(0) += 0.1; }, "off by"},
      {[](Model& m) { m.elements.pop_back(); }, "number of bodies, joints or force elements: not the same"},
  };
  for (const Slip& slip : slips) {
    Model changed = in_other_frames(given);
    slip.spoil(changed);
    EXPECT_THAT(difference_of_machines(given, changed, kWorld), HasSubstr(slip.told));
  }
  EXPECT_THAT(difference_of_machines(given, in_other_frames(given), -kWorld), HasSubstr("off by"));
}

}  // namespace
}  // namespace concord::compare
