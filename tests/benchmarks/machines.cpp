#include "tests/benchmarks/machines.h"

#include <Eigen/Geometry>
#include <functional>
#include <random>

#include "cartesian/solver.h"
#include "common/joints/revolute.h"
#include "common/joints/spherical.h"
#include "common/joints/universal.h"
#include "common/reading/model_file.h"
#include "common/rotation.h"
#include "compare/equilibrium/started_machine.h"
#include "relative/solver.h"

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

Vec4 parameters_of(const Mat3& A) {
  const Eigen::Quaterniond p = Eigen::Quaterniond(A).normalized();
  return {p.w(), p.x(), p.y(), p.z()};
}

Model empty_model(const std::string& name) {
  Model model;
  model.name = name;
  model.gravity = Vec3(1.0, -2.0, -9.5);
  model.bodies.resize(1);
  model.bodies[kGround].name = "ground";
  model.bodies[kGround].a_start = model.bodies[kGround].adot_start = VecX(0);
  return model;
}

Body make_body(std::size_t number, Numbers& numbers) {
  Body body;
  body.name = "body " + std::to_string(number);
  body.mass = 1.0 + 0.5 * numbers.next();
  body.center_of_mass_L = Vec3(0.2, 0.0, 0.0) + 0.05 * numbers.vector();
  const Mat3 axes = numbers.rotation();
  const Vec3 second_moments = body.mass * (Vec3::Constant(0.006) + 0.004 * numbers.vector());
  const Vec3 principal = Vec3::Constant(second_moments.sum()) - second_moments;
  body.inertia_L = axes * principal.asDiagonal() * axes.transpose();
  body.a_start = body.adot_start = VecX(0);
  return body;
}

/// A joint between two bodies, its frames and points generic, with room for its start.
Joint make_joint(std::size_t number, const joints::JointType& type, int parent, int child, Numbers& numbers) {
  Joint joint;
  joint.name = "J" + std::to_string(number);
  joint.type = &type;
  Attachment& on_parent = joint.sides[index(Side::parent)];
  Attachment& on_child = joint.sides[index(Side::child)];
  on_parent.body = parent;
  on_parent.point_L = Vec3(0.4, 0.0, 0.0) + 0.05 * numbers.vector();
  on_parent.C = numbers.rotation();
  on_child.body = child;
  on_child.point_L = 0.05 * numbers.vector();
  on_child.C = numbers.rotation();
  for (const joints::Permit& word : type.permits) {
    joint.start.push_back({StartRole::guess, StartRole::guess, VecX::Zero(n_q(word)), VecX::Zero(n_u(word))});
  }
  return joint;
}

/// Motion of the child from that of the parent, where the joint has turned by R and turns at `speed`, both in the
/// parent's joint frame.
BodyState move_child(const Joint& joint, const BodyState& parent, const Mat3& R, const Vec3& speed) {
  const auto rotation = [](const Vec4& p) { return Eigen::Quaterniond(p(0), p(1), p(2), p(3)).toRotationMatrix(); };
  const Attachment& on_parent = joint.on(Side::parent);
  const Attachment& on_child = joint.on(Side::child);
  const Mat3 A_parent = rotation(parent.p);
  const Mat3 A_joint = A_parent * on_parent.C;
  BodyState child;
  child.p = parameters_of(A_joint * R * on_child.C.transpose());
  const Vec3 to_joint = A_parent * on_parent.point_L;
  const Vec3 from_joint = -(rotation(child.p) * on_child.point_L);
  child.r = parent.r + to_joint + from_joint;
  child.omega = parent.omega + A_joint * speed;
  child.v = parent.v + parent.omega.cross(to_joint) + child.omega.cross(from_joint);
  child.a = child.adot = VecX(0);
  return child;
}

/// Bodies that hang each from one that was there before: body k from parent_of(k), the first from ground.
Machine make_branches(const std::string& name, int n, const joints::JointType& type,
                      const std::function<int(int)>& parent_of) {
  Numbers numbers;
  Machine machine{empty_model(name), {}};
  machine.state.bodies.resize(1);
  machine.state.bodies[kGround].a = machine.state.bodies[kGround].adot = VecX(0);
  for (int k = 1; k <= n; ++k) {
    machine.model.bodies.push_back(make_body(k, numbers));
    machine.model.joints.push_back(make_joint(k, type, parent_of(k), k, numbers));
    const bool is_ball = &type == &joints::spherical;
    const Mat3 R = is_ball ? numbers.rotation() : rotation_about(Axis::z, 0.8 * numbers.next());
    const Vec3 speed = is_ball ? numbers.vector() : Vec3(0.0, 0.0, numbers.next());
    machine.state.bodies.push_back(
        move_child(machine.model.joints.back(), machine.state.bodies[parent_of(k)], R, speed));
  }
  return machine;
}

/// Puts a joint where it stands in the poses that its bodies are guessed to have: at `place`, with frame G on the
/// parent and G R on the child.
void fit(Model& model, Joint& joint, const Vec3& place, const Mat3& G, const Mat3& R) {
  for (const Side side : {Side::parent, Side::child}) {
    Attachment& on = joint.sides[index(side)];
    const Pose pose = model.bodies[on.body].pose_guess.value_or(Pose{});
    on.point_L = pose.A.transpose() * (place - pose.r);
    on.C = pose.A.transpose() * G * (side == Side::child ? R : Mat3(Mat3::Identity()));
  }
  model.joints.push_back(joint);
}

/// A machine under construction of which every body is a bar, and every joint stands where two bars meet.
class Ladder {
 public:
  explicit Ladder(int n) : model_(empty_model("ladder of " + std::to_string(n))) {
    for (int k = 0; k <= n; ++k) {
      pivots_.emplace_back(Vec3(0.5 * k, 0.0, 0.0) + near(Vec3::Zero()));
      ends_.emplace_back(near(pivots_.back() + Vec3(0.15, 0.25, 0.0)));
      add_bar(pivots_.back(), ends_.back());
      const double angle = 0.8 * numbers_.next();
      Joint pivot = make_joint(model_.joints.size(), joints::revolute, kGround, k + 1, numbers_);
      pivot.start[0].q(0) = angle;
      fit(model_, pivot, pivots_.back(), tilted(), rotation_about(Axis::z, angle));
    }
    for (int k = 0; k < n; ++k) add_rod(k);
    WordStart& first = model_.joints[0].start[0];
    first.role_q = first.role_u = StartRole::keep;
    first.u(0) = 2.0;
  }

  [[nodiscard]] const Model& model() const { return model_; }

 private:
  [[nodiscard]] Vec3 near(const Vec3& place) { return place + 0.02 * numbers_.vector(); }
  [[nodiscard]] Mat3 tilted() { return rotation_about(Vec3(numbers_.vector().normalized()), 0.1); }

  /// A body whose frame stands anyhow beside its middle, where its mass is.
  int add_bar(const Vec3& from, const Vec3& to) {
    Body body = make_body(model_.bodies.size(), numbers_);
    const Vec3 middle = near(0.5 * (from + to));
    body.pose_guess = Pose{near(middle), numbers_.rotation()};
    body.center_of_mass_L = body.pose_guess->A.transpose() * (middle - body.pose_guess->r);
    model_.bodies.push_back(body);
    return static_cast<int>(model_.bodies.size()) - 1;
  }

  /// The rod from crank k to the next. The yokes of its universal joint stand across it.
  void add_rod(int k) {
    const int rod = add_bar(ends_[k], ends_[k + 1]);
    Joint ball = make_joint(model_.joints.size(), joints::spherical, k + 1, rod, numbers_);
    const Mat3 R = numbers_.rotation();
    ball.start[0].q = parameters_of(R);
    fit(model_, ball, ends_[k], numbers_.rotation(), R);
    Joint yokes = make_joint(model_.joints.size(), joints::universal, rod, k + 2, numbers_);
    const Eigen::Vector2d turns = 0.3 * Eigen::Vector2d(numbers_.next(), numbers_.next());
    yokes.start[0].q(0) = turns(0);
    yokes.start[1].q(0) = turns(1);
    fit(model_, yokes, ends_[k + 1], tilted() * rotation_about(Axis::y, 1.5),
        rotation_about(Axis::x, turns(0)) * rotation_about(Axis::y, turns(1)));
  }

  Numbers numbers_;
  Model model_;
  std::vector<Vec3> pivots_;
  std::vector<Vec3> ends_;
};

}  // namespace

Machine make_chain(int n, const joints::JointType& type) {
  return make_branches("chain of " + std::to_string(n), n, type, [](int k) { return k - 1; });
}

Machine make_tree(int n) {
  return make_branches("tree of " + std::to_string(n), n, joints::revolute, [](int k) { return k / 2; });
}

Machine make_ladder(int n) {
  Machine machine{Ladder(n).model(), {}};
  machine.state = relative::make_solver(machine.model)->assemble();
  return machine;
}

Machine read_machine(const std::filesystem::path& file) {
  std::string note;
  Machine machine{compare::as_it_starts(read_model(file), {cartesian::make_solver, relative::make_solver}, note), {}};
  machine.state = relative::make_solver(machine.model)->assemble();
  return machine;
}

}  // namespace concord::benchmarks
