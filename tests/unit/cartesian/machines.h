#pragma once

#include <random>

#include "common/model.h"
#include "common/rotation.h"

/// Machines for the tests of this folder: generic in every respect, and small.
namespace concord::cartesian::testing {

/// Numbers from a fixed seed, so that a failure can be repeated.
class Numbers {
 public:
  explicit Numbers(unsigned seed) : engine_(seed) {}

  double one(double size = 1.0) { return size * spread_(engine_); }
  Vec3 vector(double size = 1.0) { return {one(size), one(size), one(size)}; }
  Mat3 rotation() {
    const double angle = one(2.5);  // in a statement of its own: compilers order arguments as they like
    return rotation_about(vector().normalized(), angle);
  }
  MatX matrix(int rows, int columns, double size = 1.0) {
    return MatX::NullaryExpr(rows, columns, [&] { return one(size); });
  }

 private:
  std::mt19937 engine_;
  std::uniform_real_distribution<double> spread_{-1.0, 1.0};
};

/// Five mass points with m mode shapes; stiffness and damping symmetric and positive.
inline ModalData make_modal(Numbers& numbers, int m) {
  ModalData modal;
  for (int k = 0; k < 5 + m; ++k) {
    modal.mass_points.push_back({1.5 + numbers.one(), numbers.vector(), numbers.matrix(3, m, 0.7)});
  }
  modal.G = mass_integrals(modal.mass_points, m);
  const MatX root = numbers.matrix(m, m);
  modal.stiffness = 40.0 * (root * root.transpose() + MatX::Identity(m, m));
  modal.damping = 0.02 * modal.stiffness;
  return modal;
}

inline Body make_body(Numbers& numbers, const std::string& name, int m) {
  Body body;
  body.name = name;
  if (m > 0) {
    body.modal = make_modal(numbers, m);
  } else {
    body.mass = 2.0 + numbers.one();
    body.center_of_mass_L = numbers.vector(0.4);
    const Mat3 axes = numbers.rotation();
    body.inertia_L = axes * Vec3(0.31, 0.47, 0.62).asDiagonal() * axes.transpose();
  }
  body.a_start = VecX::Zero(m);
  body.adot_start = VecX::Zero(m);
  return body;
}

inline constexpr double kGravity = 9.81;  // [m/s^2]

/// A place on a rigid body.
inline Attachment rigid(int body, const Vec3& point, const Mat3& C) {
  return {body, point, C, Mat3X(3, 0), Mat3X(3, 0)};
}

inline Attachment make_attachment(Numbers& numbers, const Model& model, int body) {
  const int m = model.bodies[body].n_modes();
  return {body, numbers.vector(), numbers.rotation(), numbers.matrix(3, m, 0.5), numbers.matrix(3, m, 0.5)};
}

inline Joint make_joint(Numbers& numbers, const Model& model, const joints::JointType& type, int parent, int child) {
  Joint joint;
  joint.name = type.name;
  joint.type = &type;
  joint.sides = {make_attachment(numbers, model, parent), make_attachment(numbers, model, child)};
  for (const joints::Permit& word : type.permits) {
    WordStart start;
    start.q = VecX::Zero(joints::n_q(word));
    if (start.q.size() == 4) start.q(0) = 1.0;
    start.u = VecX::Zero(joints::n_u(word));
    joint.start.push_back(start);
  }
  return joint;
}

/// Ground, a body with `m_parent` modes and one with `m_child` modes, joined by `type`; both else free.
inline Model make_pair(unsigned seed, const joints::JointType& type, int m_parent, int m_child) {
  Numbers numbers(seed);
  Model model;
  model.name = "pair";
  model.file = "pair.toml";
  model.gravity = {0.7, -9.1, 3.2};
  model.bodies.resize(1);
  model.bodies[kGround].name = "ground";
  model.bodies.push_back(make_body(numbers, "one", m_parent));
  model.bodies.push_back(make_body(numbers, "two", m_child));
  model.joints.push_back(make_joint(numbers, model, type, 1, 2));
  return model;
}

}  // namespace concord::cartesian::testing
