#include <catch2/catch.hpp>

#include "common/joints/catalogue.h"
#include "common/joints/facts.h"
#include "common/rotation.h"
#include "judged_machines.h"

/// A model that no file states: what an importer gives.
namespace concord::verification {
namespace {

Body rigid(const std::string& name, double mass, const Vec3& center, const Vec3& principal) {
  Body body;
  body.name = name;
  body.mass = mass;
  body.center_of_mass_L = center;
  const Mat3 axes = rotation_about(Vec3(0.3, -0.5, 0.8).normalized(), 0.4);
  body.inertia_L = axes * principal.asDiagonal() * axes.transpose();
  return body;
}

Attachment place(int body, const Vec3& point, const Vec3& axis, double angle) {
  Attachment end;
  end.body = body;
  end.point_L = point;
  end.C = rotation_about(axis.normalized(), angle);
  return end;
}

Joint joint(const std::string& name, const std::string& type, const Attachment& parent, const Attachment& child) {
  Joint made;
  made.name = name;
  made.type = joints::find(type);
  made.sides = {parent, child};
  for (const joints::Permit& word : made.type->permits) {
    WordStart start;
    start.role_q = StartRole::keep;
    start.role_u = StartRole::keep;
    start.q = joints::home_of(word).array() + 0.3;
    start.u = VecX::Constant(n_u(word), 0.7);
    made.start.push_back(start);
  }
  return made;
}

/// Two links on tilted axes, hung on ground, that a bushing holds against it.
Model two_links() {
  Model model;
  model.name = "two_links";
  model.gravity = Vec3(1.3, -9.2, 2.4);
  Body ground;
  ground.name = "ground";
  model.bodies = {ground, rigid("upper", 2.3, Vec3(0.2, -0.1, 0.05), Vec3(0.05, 0.08, 0.06)),
                  rigid("lower", 1.1, Vec3(0.1, 0.2, -0.1), Vec3(0.02, 0.03, 0.04))};
  model.joints = {joint("shoulder", "revolute", place(0, Vec3(0.1, 0.2, 0.3), Vec3(1.0, 2.0, 0.5), 0.6),
                        place(1, Vec3(-0.2, 0.1, 0.0), Vec3(0.4, -1.0, 0.7), 1.1)),
                  joint("elbow", "universal", place(1, Vec3(0.4, -0.1, 0.1), Vec3(-0.3, 0.2, 1.0), 0.8),
                        place(2, Vec3(-0.1, 0.05, 0.2), Vec3(0.9, 0.1, -0.4), 0.5))};
  Bushing mount;
  mount.ends = {place(0, Vec3(0.5, -0.3, 0.2), Vec3(0.2, 1.0, 0.3), 0.4),
                place(2, Vec3(0.3, 0.1, 0.0), Vec3(1.0, 0.3, 0.1), 0.2)};
  mount.stiffness.diagonal() << 300.0, 200.0, 250.0, 0.0, 0.0, 0.0;  // turns freely
  mount.damping.diagonal() << 2.0, 1.5, 1.0, 0.02, 0.03, 0.01;
  model.elements = {{"mount", mount, {}}};
  model.run.until = 0.5;
  return model;
}

}  // namespace

TEST_CASE("A model that is built in code, without a file, is judged like one that was read", "[importer][quick]") {
  const Model model = two_links();
  const compare::Verdict verdict = judged(model, in_short(model, 1.0));
  INFO(compare::format_verdict(model, verdict, false));
  CHECK(verdict.outcome == compare::Outcome::agree);
  CHECK(verdict.audit.passed);
  CHECK(verdict.rows.size() > 6);

  Model slipped = model;
  std::get<Bushing>(slipped.elements[0].what).stiffness(1, 1) *= 1.0 + 1e-6;
  const auto cartesian_solver = cartesian::make_solver(model);
  const auto relative_solver = relative::make_solver(slipped);
  CHECK(compare::verify(model, *cartesian_solver, *relative_solver, in_short(model, 1.0)).outcome ==
        compare::Outcome::differ);
}

}  // namespace concord::verification
