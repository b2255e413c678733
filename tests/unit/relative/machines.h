#pragma once

#include <Eigen/Geometry>
#include <random>
#include <string>
#include <vector>

#include "common/joints/by_function.h"
#include "common/joints/catalogue.h"
#include "common/model.h"
#include "common/results.h"
#include "common/rotation.h"
#include "relative/bodies/mobilizer.h"

/// Machines for the tests of the relative solver, all in generic poses: tilted frames, offsets along no axis, unequal
/// inertias; and a referee of their motion that uses Newton's and Euler's laws for bodies and mass points, nothing
/// else.
namespace concord::relative::test {

/// A reproducible source of numbers in [-1, 1]; draws stand in statements of their own, for compilers order arguments
/// as they like.
class Numbers {
 public:
  explicit Numbers(unsigned seed) : engine_(seed) {}

  double operator()() { return uniform_(engine_); }
  Vec3 vector(double size) {
    const double z = (*this)();
    const double y = (*this)();
    const double x = (*this)();
    return size * Vec3(x, y, z);
  }
  VecX vector(Eigen::Index n, double size) {
    VecX v(n);
    for (double& entry : v) entry = size * (*this)();
    return v;
  }
  Mat3X columns(Eigen::Index n, double size) {
    Mat3X m(3, n);
    for (Eigen::Index c = 0; c < n; ++c) m.col(c) = vector(size);
    return m;
  }
  Mat3 rotation() {
    const double angle = 2.5 * (*this)();
    return rotation_about(Vec3(vector(1.0).normalized()), angle);
  }

 private:
  std::mt19937 engine_;
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

inline Body rigid_body(const std::string& name, Numbers& numbers) {
  Body body;
  body.name = name;
  body.mass = 1.3 + 0.8 * numbers();
  body.center_of_mass_L = numbers.vector(0.2);
  const Mat3 axes = numbers.rotation();
  body.inertia_L = axes * Vec3(0.021, 0.034, 0.047).asDiagonal() * axes.transpose() * (1.5 + 0.5 * numbers());
  return body;
}

/// A cloud of eleven mass points with m random modes; stiffness and damping are full matrices.
inline Body flexible_body(const std::string& name, int m, Numbers& numbers) {
  Body body;
  body.name = name;
  ModalData modal;
  for (int p = 0; p < 11; ++p)
    modal.mass_points.push_back({0.2 + 0.1 * numbers(), numbers.vector(0.4), numbers.columns(m, 0.7)});
  modal.G = mass_integrals(modal.mass_points, m);
  MatX factor(m, m);
  for (Eigen::Index c = 0; c < m; ++c) factor.col(c) = numbers.vector(m, 1.0);
  modal.stiffness = 90.0 * (factor * factor.transpose() + MatX::Identity(m, m));
  modal.damping = 0.004 * modal.stiffness;
  body.modal = modal;
  body.a_start = numbers.vector(m, 0.15);
  body.adot_start = numbers.vector(m, 0.8);
  return body;
}

/// Types that no page of the catalogue has: turns that carry arms and turns, so that speeds displace and rotate at
/// once; arms before, between and after slides and a ball; and a motion by functions with an angle and a length. What
/// they forbid is left unsaid: the relative solver does not read it.
inline const std::vector<const joints::JointType*>& own_types() {
  using namespace joints;
  static const JointType knee{
      "knee", {}, {Slide{Axis::y}, Turn{Axis::x}, Arm{Axis::z, 0.3}, Turn{Axis::y}, Arm{Axis::x, -0.2}}, {}};
  static const JointType davit{
      "davit",
      {},
      {Arm{Axis::x, 0.15}, Slide{Axis::z}, Turn{Axis::z}, Arm{Axis::y, 0.25}, Arm{Axis::z, 0.1}, Ball{}},
      {}};
  static const JointType spiral{
      "spiral",
      {},
      {ByMotion{function_of_coordinates<2>([]<class T>(const VectorOf<T, 2>& q) {
                  const T radius = 0.3 + 0.1 * sin(q(0)) + 0.5 * q(1);
                  const Mat3Of<T> R = rotation_by(Axis::z, q(0)) * rotation_by(Axis::x, T(0.7 * q(1) + 0.2 * q(0)));
                  return PlacementOf<T>{Vec3Of<T>(radius * cos(q(0)), radius * sin(q(0)), 0.2 * q(0)), R};
                }),
                {true, false},
                {"turn", "stretch"}}},
      {}};
  // An upright wheel that rolls without slipping: the axis below which it rolls is the child's.
  static const JointType wheel{
      .name = "wheel",
      .forbids = {},
      .permits = {Slide{Axis::x}, Slide{Axis::y}, Turn{Axis::z}, Turn{Axis::y}},
      .reads = {},
      .permits_speeds = {SpeedAbout{Side::child, Axis::y, 0.3}, SpeedAbout{Side::parent, Axis::z}}};
  static const std::vector<const JointType*> types{&knee, &davit, &spiral, &wheel};
  return types;
}

/// The catalogue and these.
inline std::vector<const joints::JointType*> all_types() {
  std::vector<const joints::JointType*> types = joints::catalogue();
  types.insert(types.end(), own_types().begin(), own_types().end());
  return types;
}

inline const joints::JointType* type_named(const std::string& name) {
  for (const joints::JointType* type : all_types()) {
    if (type->name == name) return type;
  }
  return nullptr;
}

inline Body ground() {
  Body body;
  body.name = "ground";
  return body;
}

/// A random place on a body, with mode shapes there if it is flexible.
inline Attachment attachment(const Model& model, int body, Numbers& numbers) {
  const int m = model.bodies[body].n_modes();
  return {body, numbers.vector(0.35), numbers.rotation(), numbers.columns(m, 0.6), numbers.columns(m, 1.1)};
}

/// A joint at random places whose words all start, kept, at random coordinates and speeds.
inline Joint joint(const Model& model, const std::string& name, const char* type, int parent, int child,
                   Numbers& numbers) {
  Joint made;
  made.name = name;
  made.type = type_named(type);
  made.sides = {attachment(model, parent, numbers), attachment(model, child, numbers)};
  for (const joints::Permit& word : made.type->permits) {
    WordStart start;
    start.role_q = StartRole::keep;
    start.role_u = StartRole::keep;
    start.q = numbers.vector(n_q(word), 0.9);
    if (std::holds_alternative<joints::Ball>(word)) start.q.normalize();
    start.u = numbers.vector(n_u(word), 1.7);
    made.start.push_back(start);
  }
  return made;
}

/// A tree with every joint type, along and against the joints, on rigid bodies, or on rigid and flexible ones in turn.
inline Model tree_of_all_joints(bool flexible, unsigned seed = 7) {
  Numbers numbers(seed);
  Model model;
  model.name = "tree of all joints";
  model.file = "tree.toml";
  model.gravity = Vec3(1.7, -9.1, 3.2);
  model.bodies.push_back(ground());
  const std::vector<std::string> types{"revolute",  "translational", "cylindrical", "spherical",
                                       "universal", "free",          "weld",        "revolute"};
  for (std::size_t i = 0; i < types.size(); ++i) {
    const std::string name = "body " + std::to_string(i + 1);
    const bool bends = flexible && i % 3 != 1;
    model.bodies.push_back(bends ? flexible_body(name, 2 + static_cast<int>(i) % 2, numbers)
                                 : rigid_body(name, numbers));
  }
  const std::vector<int> references{0, 1, 1, 2, 3, 2, 5, 4};
  for (std::size_t i = 0; i < types.size(); ++i) {
    const int body = static_cast<int>(i) + 1;
    const bool along = i % 2 == 0;
    model.joints.push_back(joint(model, "joint " + types[i] + std::to_string(i), types[i].c_str(),
                                 along ? references[i] : body, along ? body : references[i], numbers));
  }
  return model;
}

/// Marks the start of all words of a joint as a guess.
inline void release(Joint& joint) {
  for (WordStart& word : joint.start) {
    word.role_q = StartRole::guess;
    word.role_u = StartRole::guess;
  }
}

/// Keeps the first word of a joint at the start, with the given speed.
inline void keep_first_word(Joint& joint, double speed) {
  joint.start[0].role_q = StartRole::keep;
  joint.start[0].role_u = StartRole::keep;
  joint.start[0].u(0) = speed;
}

/// Turns the place and frame of a joint's child side so that the joint fits the guessed poses of its bodies, deformed
/// as at the start, with its start coordinates: loops closed from the outset, in whatever generic poses.
inline void fit_child_side(const Model& model, Joint& joint) {
  const auto deformed = [&](const Attachment& side) {
    const Body& body = model.bodies[side.body];
    if (body.n_modes() == 0) return Pose{};
    const Vec3 theta = side.Psi_r_L * body.a_start;
    return Pose{side.Psi_t_L * body.a_start, rotation_about(Vec3(theta.normalized()), theta.norm())};
  };
  const auto pose_of = [&](int body) { return model.bodies[body].pose_guess.value_or(Pose{}); };
  const Attachment& parent = joint.sides[0];
  Attachment& child = joint.sides[1];
  const Pose on_parent = deformed(parent);
  const Pose on_child = deformed(child);
  const Pose from = pose_of(parent.body);
  const Pose to = pose_of(child.body);
  VecX q(joint.type->n_q());
  const VecX u = VecX::Zero(joint.type->n_u());
  for (std::size_t word = 0; word < joint.start.size(); ++word) {
    q.segment(first_q(*joint.type, static_cast<int>(word)), joint.start[word].q.size()) = joint.start[word].q;
  }
  JointMotion motion;
  Mobilizer(*joint.type).evaluate(q.data(), u.data(), motion);
  const Mat3 A_parent = from.A * on_parent.A * parent.C;
  const Vec3 r_child = from.r + from.A * (parent.point_L + on_parent.r) + A_parent * motion.d;
  child.C = on_child.A.transpose() * to.A.transpose() * A_parent * motion.R;
  child.point_L = to.A.transpose() * (r_child - to.r) - on_child.r;
}

/// A random joint at a place in the global frame, released, that fits the guessed poses of its bodies.
inline Joint fitting_joint(const Model& model, const std::string& name, const char* type, int parent, int child,
                           const Vec3& place, Numbers& numbers) {
  Joint made = joint(model, name, type, parent, child, numbers);
  const Body& body = model.bodies[parent];
  const Pose pose = body.pose_guess.value_or(Pose{});
  made.sides[0].point_L = pose.A.transpose() * (place - pose.r);
  if (body.n_modes() > 0) made.sides[0].point_L -= made.sides[0].Psi_t_L * body.a_start;
  fit_child_side(model, made);
  release(made);
  return made;
}

/// A spatial four-joint loop, ground - revolute - crank - spherical - coupler - universal - slider - translational -
/// ground, with every frame tilted; one degree of freedom, the crank's. The coupler is flexible if so wished.
inline Model spatial_slider_crank(bool flexible) {
  Numbers numbers(21);
  Model model;
  model.name = "spatial slider-crank";
  model.file = "slider_crank.toml";
  model.gravity = Vec3(0.4, -9.2, 1.9);
  model.bodies = {ground(), rigid_body("crank", numbers),
                  flexible ? flexible_body("coupler", 3, numbers) : rigid_body("coupler", numbers),
                  rigid_body("slider", numbers)};
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    model.bodies[i].pose_guess =
        Pose{Vec3(0.3 * static_cast<double>(i), 0, 0) + numbers.vector(0.2), numbers.rotation()};
  }
  model.joints = {fitting_joint(model, "A", "revolute", 0, 1, Vec3(0.03, -0.02, 0.05), numbers),
                  fitting_joint(model, "B", "spherical", 2, 1, Vec3(0.12, 0.06, -0.03), numbers),
                  fitting_joint(model, "C", "universal", 2, 3, Vec3(0.55, 0.17, 0.08), numbers),
                  fitting_joint(model, "D", "translational", 3, 0, Vec3(0.61, 0.11, 0.13), numbers)};
  for (Joint& each : model.joints) each.where = {"slider_crank.toml", 10, 1};
  keep_first_word(model.joints[0], 2.3);
  return model;
}

/// A four-bar linkage, ground - A - crank - B - coupler - C - rocker - D - ground, of revolute joints with parallel
/// axes along a direction tilted in space: 20 constraints of rank 17. Bodies and points are generic, also out of the
/// plane. With `folded`, the four joints stand on one line, where the closure loses one more row.
inline Model four_bar(bool folded = false) {
  Numbers numbers(5);
  Model model;
  model.name = "four-bar";
  model.file = "four_bar.toml";
  model.gravity = Vec3(2.1, -8.7, 1.1);
  model.bodies = {ground(), rigid_body("crank", numbers), rigid_body("coupler", numbers),
                  rigid_body("rocker", numbers)};
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    model.bodies[i].pose_guess = Pose{numbers.vector(0.3), numbers.rotation()};
  }
  const Mat3 plane = rotation_about(Vec3(Vec3(1, 2, -1).normalized()), 0.8);
  const auto hinge = [&](const std::string& name, int parent, int child, const Vec3& in_plane) {
    Joint made = joint(model, name, "revolute", parent, child, numbers);
    const Pose pose = model.bodies[parent].pose_guess.value_or(Pose{});
    made.sides[0].point_L = pose.A.transpose() * (plane * in_plane - pose.r);
    made.sides[0].C = pose.A.transpose() * plane * rotation_about(Axis::z, numbers());
    fit_child_side(model, made);
    release(made);
    made.where = {"four_bar.toml", 7, 3};
    return made;
  };
  const double up = folded ? 0.0 : 1.0;
  model.joints = {hinge("A", 0, 1, Vec3(0.0, 0.0, 0.1)), hinge("B", 1, 2, Vec3(0.1, 0.18 * up, -0.05)),
                  hinge("C", 3, 2, Vec3(0.6, 0.37 * up, 0.12)), hinge("D", 3, 0, Vec3(0.45, -0.05 * up, 0.03))};
  keep_first_word(model.joints[0], 1.9);
  return model;
}

/// Four or more cranks side by side on ground, each tied to the next by a rod: loops, of which those that share a crank
/// couple. If so wished, the second and third crank are tied by two rods between the same points: one more loop, of
/// which a row depends on others.
inline Model ladder(bool doubled, int cranks = 4) {
  Numbers numbers(83);
  Model model;
  model.name = "ladder";
  model.file = "ladder.toml";
  model.gravity = Vec3(1.4, -9.0, 2.2);
  model.bodies = {ground()};
  const auto add_body = [&](const std::string& name) {
    model.bodies.push_back(rigid_body(name, numbers));
    model.bodies.back().pose_guess = Pose{numbers.vector(0.5), numbers.rotation()};
    return static_cast<int>(model.bodies.size()) - 1;
  };
  for (int crank = 1; crank <= cranks; ++crank) {
    add_body("crank " + std::to_string(crank));
    model.joints.push_back(fitting_joint(model, "A" + std::to_string(crank), "revolute", 0, crank,
                                         Vec3(0.4 * crank, 0, 0) + numbers.vector(0.1), numbers));
  }
  for (int crank = 1; crank < cranks; ++crank) {
    const Vec3 from = Vec3(0.4 * crank, 0.3, 0) + numbers.vector(0.1);
    const Vec3 to = Vec3(0.4 * crank + 0.4, 0.2, 0.1) + numbers.vector(0.1);
    for (int rod = 0; rod < (doubled && crank == 2 ? 2 : 1); ++rod) {
      const std::string name = std::to_string(crank) + (rod == 0 ? "" : " again");
      const int body = add_body("rod " + name);
      model.joints.push_back(fitting_joint(model, "S" + name, "spherical", crank, body, from, numbers));
      model.joints.push_back(fitting_joint(model, "U" + name, "universal", body, crank + 1, to, numbers));
    }
  }
  keep_first_word(model.joints[0], 1.6);
  return model;
}

/// Keeps n speeds of the second flight of a pair: of its turn, or of its place.
inline void keep_speeds_in_space(Model& pair, std::size_t n) {
  std::vector<WordStart>& words = pair.joints[1].start;
  for (WordStart& word : words) word.role_u = StartRole::guess;
  if (n == 3) words.back().role_u = StartRole::keep;  // a point of a ball that rolls has two speeds only
  for (std::size_t axis = 0; n < 3 && axis < n; ++axis) words[axis].role_u = StartRole::keep;
}

/// Two bodies that otherwise move freely, and a joint J of the type between them that starts anywhere. Bits of
/// `flexible`: parent, child.
inline Model pair(const joints::JointType& type, int flexible) {
  Numbers numbers(61);
  Model model;
  model.file = "pair.toml";
  model.gravity = Vec3(0.9, -9.3, 1.2);
  model.bodies = {ground()};
  for (int i = 0; i < 2; ++i) {
    const std::string name = i == 0 ? "parent" : "child";
    model.bodies.push_back((flexible >> i) % 2 == 1 ? flexible_body(name, 3, numbers) : rigid_body(name, numbers));
    model.bodies.back().pose_guess = Pose{numbers.vector(0.5), numbers.rotation()};
  }
  model.joints = {joint(model, "first flight", "free", 0, 1, numbers),
                  joint(model, "second flight", "free", 2, 0, numbers),
                  fitting_joint(model, "J", type.name.c_str(), 1, 2, numbers.vector(0.4), numbers)};
  for (WordStart& word : model.joints[2].start) word.role_q = word.role_u = StartRole::keep;
  release(model.joints[1]);
  if (type.permits_speeds.empty()) return model;
  // Where fewer speeds are free than coordinates, the child's velocity in space says them.
  for (WordStart& word : model.joints[2].start) word.role_u = StartRole::guess;
  keep_speeds_in_space(model, type.permits_speeds.size());
  return model;
}

/// A law with all that a law can have; the stop at `stop` is pressed by any x above it.
inline ForceLaw force_law(double size, double free, double stop) {
  ForceLaw law;
  law.stiffness = 3.1 * size;
  law.damping = 0.4 * size;
  law.free = free;
  law.preload = 0.7 * size;
  law.spring_table = ForceTable({-1.0, -0.2, 0.1, 0.9, 2.0}, {-2.0 * size, -0.1 * size, 0.4 * size, size, 2.5 * size});
  law.upper = SmoothStop{stop, 5.0 * size, 0.3 * size, 0.2};
  law.actuator = Harmonic{0.2 * size, 1.3 * size, 5.0, 0.4};
  return law;
}

/// One force element of every kind between bodies of the model, a load in every kind of axes.
inline void add_force_elements(Model& model, Numbers& numbers) {
  const auto any_body = [&, next = 0]() mutable { return ++next % static_cast<int>(model.bodies.size()); };
  auto body = any_body;
  const auto ends = [&] { return std::array{attachment(model, body(), numbers), attachment(model, body(), numbers)}; };
  for (const LoadAxes axes : {LoadAxes::global, LoadAxes::body, LoadAxes::follower}) {
    int loaded = body();
    if (loaded == kGround) loaded = body();
    model.elements.push_back({"load",
                              Load{attachment(model, loaded, numbers), axes, numbers.vector(4.0), numbers.vector(1.5),
                                   Harmonic{1.0, 0.6, 3.0, 0.2}},
                              {}});
  }
  model.elements.push_back({"line", LineSpring{ends(), force_law(20.0, 0.3, 0.1)}, {}});
  model.elements.push_back({"turn", TurnSpring{ends(), force_law(2.0, 0.1, -3.1)}, {}});
  Bushing bushing{ends(), Mat6::Zero(), Mat6::Zero(), Vec6::Zero()};
  for (Mat6* matrix : {&bushing.stiffness, &bushing.damping}) {
    Mat6 factor;
    for (int c = 0; c < 6; ++c) factor.col(c) = numbers.vector(6, 1.0);
    *matrix = (matrix == &bushing.stiffness ? 30.0 : 0.5) * factor * factor.transpose();
  }
  bushing.preload = numbers.vector(6, 3.0);
  model.elements.push_back({"bushing", bushing, {}});
}

/// A spring on every turn and slide of a joint, and on every coordinate of a motion by functions.
inline void add_springs(Joint& joint) {
  for (std::size_t word = 0; word < joint.type->permits.size(); ++word) {
    const joints::Permit& permit = joint.type->permits[word];
    if (std::holds_alternative<joints::Ball>(permit)) continue;
    for (int c = 0; c < n_u(permit); ++c) {
      joint.springs.push_back({static_cast<int>(word), force_law(4.0 + c, 0.2, -0.3), c});
    }
  }
}

/// What is left over when all forces and moments on a body, mass times acceleration included, are added up.
struct Imbalance {
  double force = 0.0;   // N
  double torque = 0.0;  // N m, about the global origin
  double modal = 0.0;   // generalized
};

inline Mat3 rotation_of(const BodyState& body) {
  return Eigen::Quaterniond(body.p(0), body.p(1), body.p(2), body.p(3)).toRotationMatrix();
}

/// Left tangent of the exponential map by its defining integral, J = integral over s in (0, 1) of exp(s theta~), with
/// Gauss-Legendre points: independent of the solver's closed forms.
inline Mat3 tangent_by_quadrature(const Vec3& theta) {
  const double length = theta.norm();
  if (length == 0.0) return Mat3::Identity();
  const double x[] = {0.1488743389816312, 0.4333953941292472, 0.6794095682990244, 0.8650633666889845,
                      0.9739065285171717};
  const double w[] = {0.2955242247147529, 0.2692667193099963, 0.2190863625159821, 0.1494513491505806,
                      0.0666713443086881};
  Mat3 sum = Mat3::Zero();
  for (int i = 0; i < 5; ++i) {
    for (const double sign : {-1.0, 1.0}) {
      sum += 0.5 * w[i] * rotation_about(Vec3(theta / length), 0.5 * (1.0 + sign * x[i]) * length);
    }
  }
  return sum;
}

/// Newton-Euler for rigid bodies, the sum over mass points for flexible ones, for the worst body.
inline Imbalance imbalance(const Model& model, const State& state, const Evaluation& evaluation) {
  Imbalance worst;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    const BodyState& s = state.bodies[i];
    const BodyAcceleration& acceleration = evaluation.bodies[i];
    const Mat3 A = rotation_of(s);
    Vec3 force = Vec3::Zero();
    Vec3 torque = Vec3::Zero();
    VecX modal = VecX::Zero(body.n_modes());
    const auto add_point = [&](double mass, const Vec3& s_L, const Mat3X& Psi) {
      const Vec3 arm = A * s_L;
      const Vec3 rate = A * (Psi * s.adot);
      const Vec3 f = mass * (acceleration.vdot + acceleration.omegadot.cross(arm) + s.omega.cross(s.omega.cross(arm)) +
                             2.0 * s.omega.cross(rate) + A * (Psi * acceleration.addot) - model.gravity);
      force -= f;
      torque -= (s.r + arm).cross(f);
      modal -= Psi.transpose() * A.transpose() * f;
    };
    if (body.modal) {
      for (const MassPoint& p : body.modal->mass_points) add_point(p.mass, p.s0_L + p.Psi_t_L * s.a, p.Psi_t_L);
      modal -= body.modal->stiffness * s.a + body.modal->damping * s.adot;
    } else {
      add_point(body.mass, body.center_of_mass_L, Mat3X(3, 0));
      const Mat3 I = A * body.inertia_L * A.transpose();
      torque -= I * acceleration.omegadot + s.omega.cross(I * s.omega);
    }
    const auto apply_wrench = [&](const Attachment& at, const Wrench& w) {
      if (at.body != static_cast<int>(i)) return;
      const Vec3 place = s.r + A * (at.point_L + at.Psi_t_L * s.a);
      force += w.force;
      torque += w.torque + place.cross(w.force);
      if (body.n_modes() == 0) return;
      const Mat3 J = tangent_by_quadrature(at.Psi_r_L * s.a);
      modal +=
          at.Psi_t_L.transpose() * A.transpose() * w.force + (J * at.Psi_r_L).transpose() * A.transpose() * w.torque;
    };
    for (const Side side : {Side::parent, Side::child}) {
      for (std::size_t k = 0; k < model.joints.size(); ++k) {
        apply_wrench(model.joints[k].on(side), evaluation.joints[k].total_on(side).in_global);
      }
      for (std::size_t e = 0; e < model.elements.size(); ++e) {
        const Attachment* end = end_of(model.elements[e], side);
        if (end != nullptr) apply_wrench(*end, evaluation.elements[e].on_side(side).in_global);
      }
    }
    worst.force = std::max(worst.force, force.norm());
    worst.torque = std::max(worst.torque, torque.norm());
    if (modal.size() > 0) worst.modal = std::max(worst.modal, modal.norm());
  }
  return worst;
}

/// Kinetic, potential and strain energy of a state, from mass points and inertia tensors.
inline double energy(const Model& model, const State& state) {
  double sum = 0.0;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    const BodyState& s = state.bodies[i];
    const Mat3 A = rotation_of(s);
    const auto add_point = [&](double mass, const Vec3& s_L, const Vec3& rate_L) {
      const Vec3 v = s.v + s.omega.cross(A * s_L) + A * rate_L;
      sum += 0.5 * mass * v.squaredNorm() - mass * model.gravity.dot(s.r + A * s_L);
    };
    if (body.modal) {
      for (const MassPoint& p : body.modal->mass_points)
        add_point(p.mass, p.s0_L + p.Psi_t_L * s.a, p.Psi_t_L * s.adot);
      sum += 0.5 * s.a.dot(body.modal->stiffness * s.a);
    } else {
      add_point(body.mass, body.center_of_mass_L, Vec3::Zero());
      const Vec3 w = A.transpose() * s.omega;
      sum += 0.5 * w.dot(body.inertia_L * w);
    }
  }
  return sum;
}

}  // namespace concord::relative::test
