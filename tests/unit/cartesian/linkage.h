#pragma once

#include <cmath>
#include <string>

#include "common/joints/catalogue.h"
#include "machines.h"

namespace concord::cartesian::testing {

/// Planar linkages in a tilted world: hinges along z, cranks of `crank`, couplers of `coupler`, ground points `pitch`
/// apart; the first crank starts at `angle` and turns at `rate`, by a driver or by itself.
struct Linkage {
  double crank = 0.3;
  double last_crank = 0.3;
  double coupler = 0.7;
  double pitch = 0.7;
  double angle = 0.5;
  double rate = 2.0;
  int loops = 1;
  bool is_driven = true;
  /// Units of length, mass and time that the same machine is stated in.
  double length = 1.0;
  double mass = 1.0;
  double time = 1.0;

  [[nodiscard]] Model make() const {
    Numbers numbers(151);
    Model model;
    model.name = "linkage";
    model.file = "linkage.toml";
    model.gravity = {1.1, -2.3, 0.4};
    model.bodies.resize(1);
    for (int i = 0; i <= 2 * loops; ++i) model.bodies.push_back(make_body(numbers, "link", 0));
    add_hinge(model, "A0", kGround, Vec3::Zero(), 1, Vec3::Zero());
    for (int loop = 0; loop < loops; ++loop) {
      const int before = 1 + 2 * loop;
      const double own = loop + 1 == loops ? last_crank : crank;
      add_hinge(model, "B", before, Vec3(crank, 0.0, 0.0), before + 1, Vec3::Zero());
      add_hinge(model, "C", before + 1, Vec3(coupler, 0.0, 0.0), before + 2, Vec3(own, 0.0, 0.0));
      add_hinge(model, "D", kGround, Vec3((loop + 1) * pitch, 0.0, 0.0), before + 2, Vec3::Zero());
    }
    place(model);
    change_units(model);
    if (is_driven) {
      model.joints[0].drivers = {{0, ConstantSpeed{angle, rate / time}, 0}};
    } else {
      WordStart& start = model.joints[0].start[0];
      start.role_q = start.role_u = StartRole::keep;
      start.q(0) = angle;
      start.u(0) = rate / time;
    }
    return model;
  }

 private:
  static void add_hinge(Model& model, const std::string& name, int parent, const Vec3& at_parent, int child,
                        const Vec3& at_child) {
    Numbers numbers(152);
    Joint joint = make_joint(numbers, model, *joints::find("revolute"), parent, child);
    joint.name = name;
    joint.sides = {rigid(parent, at_parent, Mat3::Identity()), rigid(child, at_child, Mat3::Identity())};
    model.joints.push_back(joint);
  }

  void change_units(Model& model) const {
    model.gravity *= length / (time * time);
    for (Body& body : model.bodies) {
      body.mass *= mass;
      body.center_of_mass_L *= length;
      body.inertia_L *= mass * length * length;
      if (body.pose_guess) body.pose_guess->r *= length;
    }
    for (Joint& joint : model.joints) {
      for (Attachment& side : joint.sides) side.point_L *= length;
    }
  }

  void place(Model& model) const {
    const Vec3 along(std::cos(angle), std::sin(angle), 0.0);
    for (int i = 1; i < static_cast<int>(model.bodies.size()); ++i) {
      const bool is_crank = i % 2 == 1;
      const int column = (i - 1) / 2;
      const Vec3 at = Vec3(column * pitch, 0.0, 0.0) + (is_crank ? Vec3(Vec3::Zero()) : Vec3(crank * along));
      model.bodies[i].pose_guess = Pose{at, rotation_about(Axis::z, is_crank ? angle : 0.0)};
    }
  }
};

}  // namespace concord::cartesian::testing
