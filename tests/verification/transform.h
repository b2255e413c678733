#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <functional>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "common/rotation.h"
#include "common/solver.h"

/// One machine, said in another way: other frames, other sides, another order, other units. What is physical stays.
namespace concord::verification {

using Uniqueness = std::vector<JointUniqueness>;

/// A way to say a machine anew. `model` and `state` lead from the first statement to the second; `evaluation` and
/// `unique` lead what a solver found for the second statement back to the first (`before` is the state in the first).
struct Change {
  std::function<Model(Model)> model = [](Model same) { return same; };
  std::function<State(State)> state = [](State same) { return same; };
  std::function<Evaluation(const State&, Evaluation)> evaluation = [](const State&, Evaluation same) { return same; };
  std::function<Uniqueness(Uniqueness)> unique = [](Uniqueness same) { return same; };
};

/// Numbers in [-1, 1] from a fixed seed.
class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}

  double one(double size = 1.0) { return size * uniform_(engine_); }
  Vec3 vector(double size) { return {one(size), one(size), one(size)}; }
  Mat3 rotation() {
    const double angle = one(3.0);
    return rotation_about(Vec3(vector(1.0).normalized()), angle);
  }
  Pose pose(double size) { return {vector(size), rotation()}; }
  /// A permutation that leaves 0 .. first - 1 in place, and none of `first` .. n - 1.
  std::vector<int> order(std::size_t n, std::size_t first) {
    std::vector<int> order(n);
    std::iota(order.begin(), order.end(), 0);
    for (std::size_t last = n; last > first + 1; --last) {
      std::swap(order[last - 1], order[first + engine_() % (last - first - 1)]);
    }
    return order;
  }

 private:
  std::mt19937 engine_;
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

inline Mat3 rotation_of(const Vec4& p) { return Eigen::Quaterniond(p(0), p(1), p(2), p(3)).toRotationMatrix(); }

inline Vec4 euler_parameters_of(const Mat3& A) {
  const Eigen::Quaterniond p(A);
  return {p.w(), p.x(), p.y(), p.z()};
}

/// Every wrench of an evaluation, one side at a time.
template <class Edit>
void for_each_side_wrench(Evaluation& evaluation, const Edit& edit) {
  for (JointWrenches& joint : evaluation.joints) {
    for (auto* wrenches : {&joint.reaction, &joint.total}) {
      for (SideWrench& side : *wrenches) edit(side);
    }
  }
}

// The cut joint ------------------------------------------------------------------------------------------------------

/// Names one joint as the cut joint of its loop.
inline Change cut_at(std::size_t joint) {
  Change change;
  change.model = [joint](Model model) {
    for (std::size_t k = 0; k < model.joints.size(); ++k) model.joints[k].named_as_cut = k == joint;
    return model;
  };
  return change;
}

// Sides --------------------------------------------------------------------------------------------------------------

/// The words of a joint type read backwards: the same words in the same order if the axes of both joint frames are
/// turned by Q, C' = C Q.
struct Reversal {
  Mat3 Q = Mat3::Identity();
  bool words_change_places = false;
};

inline Reversal reversal_of(const joints::JointType& type) {
  std::vector<Axis> axes;
  for (const joints::Permit& word : type.permits) {
    if (const auto* turn = std::get_if<joints::Turn>(&word)) axes.push_back(turn->axis);
    if (const auto* slide = std::get_if<joints::Slide>(&word)) axes.push_back(slide->axis);
  }
  const bool one_axis = std::all_of(axes.begin(), axes.end(), [&](Axis axis) { return axis == axes.front(); });
  if (one_axis && (axes.empty() || axes.size() == type.permits.size())) return {};
  // The half turn about (x + y) / sqrt 2 changes x and y.
  if (axes == std::vector{Axis::x, Axis::y}) return {rotation_about(Vec3(1, 1, 0).normalized(), EIGEN_PI), true};
  throw std::logic_error("no rule to swap the sides of a joint of type " + type.name);
}

/// Coordinates of the child in the parent turned into those of the parent in the child: slides and turns along one axis
/// change sign, a ball's Euler parameters are conjugated.
inline VecX reversed_coordinates(const VecX& q) {
  if (q.size() != 4) return -q;
  return Vec4(q(0), -q(1), -q(2), -q(3));
}

/// The same for the speeds of a word: a ball's are seen from the other side.
inline VecX reversed_speeds(const VecX& q, const VecX& u) {
  if (q.size() != 4) return -u;
  return -(rotation_of(q.normalized()).transpose() * u);
}

inline Joint with_sides_swapped(Joint joint) {
  if (!joint.drivers.empty()) throw std::logic_error("no rule to swap the sides of a driven joint");
  const Reversal reversal = reversal_of(*joint.type);
  std::swap(joint.sides[0], joint.sides[1]);
  for (Attachment& side : joint.sides) side.C = side.C * reversal.Q;
  if (reversal.words_change_places) std::reverse(joint.start.begin(), joint.start.end());
  for (WordStart& word : joint.start) {
    word.u = reversed_speeds(word.q, word.u);
    word.q = reversed_coordinates(word.q);
  }
  return joint;
}

/// Swaps parent and child of every joint.
inline Change with_sides_swapped(const Model& first) {
  std::vector<Reversal> reversals;
  for (const Joint& joint : first.joints) reversals.push_back(reversal_of(*joint.type));
  Change change;
  change.model = [](Model model) {
    for (Joint& joint : model.joints) joint = with_sides_swapped(std::move(joint));
    return model;
  };
  change.state = [reversals](State state) {
    for (std::size_t k = 0; k < reversals.size(); ++k) {
      state.u[k] = reversed_speeds(state.q[k], state.u[k]);
      state.q[k] = reversed_coordinates(state.q[k]);
      if (reversals[k].words_change_places) {
        state.q[k].reverseInPlace();
        state.u[k].reverseInPlace();
      }
    }
    return state;
  };
  change.evaluation = [reversals](const State&, Evaluation evaluation) {
    for (std::size_t k = 0; k < reversals.size(); ++k) {
      for (auto* wrenches : {&evaluation.joints[k].reaction, &evaluation.joints[k].total}) {
        std::swap((*wrenches)[0], (*wrenches)[1]);
        for (SideWrench& side : *wrenches) {
          side.in_C = {reversals[k].Q * side.in_C.force, reversals[k].Q * side.in_C.torque};
        }
      }
    }
    return evaluation;
  };
  change.unique = [reversals](Uniqueness flags) {
    for (std::size_t k = 0; k < reversals.size(); ++k) {
      std::swap(flags[k].unique[0], flags[k].unique[1]);
      if (!reversals[k].words_change_places) continue;
      for (auto& side : flags[k].unique) {
        std::swap(side[0], side[1]);
        std::swap(side[3], side[4]);
      }
    }
    return flags;
  };
  return change;
}

// Frames of the bodies -----------------------------------------------------------------------------------------------

/// A body whose frame is moved: `frame` is the new one seen from the old one.
inline Body with_frame(Body body, const Pose& frame) {
  const Mat3 to_new = frame.A.transpose();
  if (body.pose_guess)
    body.pose_guess = Pose{body.pose_guess->r + body.pose_guess->A * frame.r, body.pose_guess->A * frame.A};
  if (!body.modal) {
    body.center_of_mass_L = to_new * (body.center_of_mass_L - frame.r);
    body.inertia_L = to_new * body.inertia_L * frame.A;
    return body;
  }
  ModalData& modal = *body.modal;
  // w = [1; s_0; psi_1; ...] becomes X w.
  MatX X = MatX::Identity(modal.G.rows(), modal.G.cols());
  for (Eigen::Index block = 1; block < X.rows(); block += 3) X.block<3, 3>(block, block) = to_new;
  X.block<3, 1>(1, 0) = -to_new * frame.r;
  modal.G = X * modal.G * X.transpose();
  for (ModalNode& node : modal.nodes) {
    node.s0_L = to_new * (node.s0_L - frame.r);
    node.Psi_t_L = to_new * node.Psi_t_L;
    node.Psi_r_L = to_new * node.Psi_r_L;
  }
  for (MassPoint& point : modal.mass_points) {
    point.s0_L = to_new * (point.s0_L - frame.r);
    point.Psi_t_L = to_new * point.Psi_t_L;
  }
  return body;
}

inline Attachment with_frame(Attachment side, const Pose& frame) {
  const Mat3 to_new = frame.A.transpose();
  side.point_L = to_new * (side.point_L - frame.r);
  side.C = to_new * side.C;
  side.Psi_t_L = to_new * side.Psi_t_L;
  side.Psi_r_L = to_new * side.Psi_r_L;
  return side;
}

/// Moves and turns the frame of every body in the body; frames[0], ground's, is not used.
inline Change with_body_frames(const std::vector<Pose>& frames) {
  Change change;
  change.model = [frames](Model model) {
    for (std::size_t i = 1; i < frames.size(); ++i) model.bodies[i] = with_frame(std::move(model.bodies[i]), frames[i]);
    for (Joint& joint : model.joints) {
      for (Attachment& side : joint.sides) {
        if (side.body != kGround) side = with_frame(std::move(side), frames[side.body]);
      }
    }
    return model;
  };
  change.state = [frames](State state) {
    for (std::size_t i = 1; i < frames.size(); ++i) {
      BodyState& body = state.bodies[i];
      const Mat3 A = rotation_of(body.p);
      const Vec3 arm = A * frames[i].r;
      body.r += arm;
      body.v += body.omega.cross(arm);
      body.p = euler_parameters_of(A * frames[i].A);
    }
    return state;
  };
  change.evaluation = [frames](const State& before, Evaluation evaluation) {
    for (std::size_t i = 1; i < frames.size(); ++i) {
      const Vec3 arm = rotation_of(before.bodies[i].p) * frames[i].r;
      const Vec3& omega = before.bodies[i].omega;
      BodyAcceleration& body = evaluation.bodies[i];
      body.vdot -= body.omegadot.cross(arm) + omega.cross(omega.cross(arm));
    }
    return evaluation;
  };
  return change;
}

// The world ----------------------------------------------------------------------------------------------------------

/// Moves and turns everything, gravity and what stands on ground included: r' = world.r + world.A r.
inline Change in_world(const Pose& world) {
  Change change;
  change.model = [world](Model model) {
    model.gravity = world.A * model.gravity;
    for (Body& body : model.bodies) {
      if (body.pose_guess) body.pose_guess = Pose{world.r + world.A * body.pose_guess->r, world.A * body.pose_guess->A};
    }
    for (Joint& joint : model.joints) {
      for (Attachment& side : joint.sides) {
        if (side.body != kGround) continue;
        side.point_L = world.r + world.A * side.point_L;
        side.C = world.A * side.C;
      }
    }
    return model;
  };
  change.state = [world](State state) {
    for (std::size_t i = 1; i < state.bodies.size(); ++i) {
      BodyState& body = state.bodies[i];
      body.r = world.r + world.A * body.r;
      body.p = euler_parameters_of(world.A * rotation_of(body.p));
      body.v = world.A * body.v;
      body.omega = world.A * body.omega;
    }
    return state;
  };
  change.evaluation = [world](const State&, Evaluation evaluation) {
    const Mat3 back = world.A.transpose();
    for (BodyAcceleration& body : evaluation.bodies) {
      body.vdot = back * body.vdot;
      body.omegadot = back * body.omegadot;
    }
    for_each_side_wrench(evaluation, [&](SideWrench& side) {
      side.in_global = {back * side.in_global.force, back * side.in_global.torque};
    });
    return evaluation;
  };
  return change;
}

// The order in the file ----------------------------------------------------------------------------------------------

/// picked[k] = all[order[k]].
template <class T>
std::vector<T> pick(const std::vector<T>& all, const std::vector<int>& order) {
  std::vector<T> picked;
  for (const int k : order) picked.push_back(all[k]);
  return picked;
}

inline std::vector<int> inverse_of(const std::vector<int>& order) {
  std::vector<int> inverse(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) inverse[order[k]] = static_cast<int>(k);
  return inverse;
}

/// Tells bodies and joints in another order: body k of the new one is bodies[k] of the old one; ground stays first.
inline Change in_order(const std::vector<int>& bodies, const std::vector<int>& joints) {
  const std::vector<int> place_of_body = inverse_of(bodies);
  const std::vector<int> place_of_joint = inverse_of(joints);
  Change change;
  change.model = [bodies, joints, place_of_body](Model model) {
    model.bodies = pick(model.bodies, bodies);
    model.joints = pick(model.joints, joints);
    for (Joint& joint : model.joints) {
      for (Attachment& side : joint.sides) side.body = place_of_body[side.body];
    }
    return model;
  };
  change.state = [bodies, joints](State state) {
    state.bodies = pick(state.bodies, bodies);
    state.q = pick(state.q, joints);
    state.u = pick(state.u, joints);
    return state;
  };
  change.evaluation = [place_of_body, place_of_joint](const State&, Evaluation evaluation) {
    evaluation.bodies = pick(evaluation.bodies, place_of_body);
    evaluation.joints = pick(evaluation.joints, place_of_joint);
    return evaluation;
  };
  change.unique = [place_of_joint](const Uniqueness& flags) { return pick(flags, place_of_joint); };
  return change;
}

// Modes --------------------------------------------------------------------------------------------------------------

/// Combines the modes of every flexible body anew, a = T b with a regular T for each body (0 x 0 for rigid ones).
inline Change with_modes(const std::vector<MatX>& T) {
  Change change;
  change.model = [T](Model model) {
    for (std::size_t i = 1; i < T.size(); ++i) {
      if (!model.bodies[i].modal) continue;
      Body& body = model.bodies[i];
      ModalData& modal = *body.modal;
      modal.stiffness = T[i].transpose() * modal.stiffness * T[i];
      modal.damping = T[i].transpose() * modal.damping * T[i];
      modal.frequencies.resize(0);
      MatX X = MatX::Identity(modal.G.rows(), modal.G.cols());
      for (Eigen::Index row = 0; row < T[i].rows(); ++row) {
        for (Eigen::Index column = 0; column < T[i].cols(); ++column) {
          X.block<3, 3>(4 + 3 * row, 4 + 3 * column) = T[i](column, row) * Mat3::Identity();
        }
      }
      modal.G = X * modal.G * X.transpose();
      for (ModalNode& node : modal.nodes) {
        node.Psi_t_L = node.Psi_t_L * T[i];
        node.Psi_r_L = node.Psi_r_L * T[i];
      }
      for (MassPoint& point : modal.mass_points) point.Psi_t_L = point.Psi_t_L * T[i];
      body.a_start = T[i].lu().solve(body.a_start);
      body.adot_start = T[i].lu().solve(body.adot_start);
    }
    for (Joint& joint : model.joints) {
      for (Attachment& side : joint.sides) {
        if (T[side.body].size() == 0) continue;
        side.Psi_t_L = side.Psi_t_L * T[side.body];
        side.Psi_r_L = side.Psi_r_L * T[side.body];
      }
    }
    return model;
  };
  change.state = [T](State state) {
    for (std::size_t i = 1; i < T.size(); ++i) {
      if (T[i].size() == 0) continue;
      state.bodies[i].a = T[i].lu().solve(state.bodies[i].a);
      state.bodies[i].adot = T[i].lu().solve(state.bodies[i].adot);
    }
    return state;
  };
  change.evaluation = [T](const State&, Evaluation evaluation) {
    for (std::size_t i = 1; i < T.size(); ++i) {
      if (T[i].size() > 0) evaluation.bodies[i].addot = T[i] * evaluation.bodies[i].addot;
    }
    return evaluation;
  };
  return change;
}

// Units --------------------------------------------------------------------------------------------------------------

/// Factors by which the numbers of lengths, masses and times grow: {1000, 1e-3, 1} tells a machine in mm, t, s and N.
/// Modal coordinates keep their numbers unless `modal` says how they grow.
struct Units {
  double length = 1.0;
  double mass = 1.0;
  double time = 1.0;
  double modal = 1.0;

  [[nodiscard]] double force() const { return mass * length / (time * time); }
  [[nodiscard]] double torque() const { return force() * length; }
  /// How a coordinate grows, and the force on it.
  [[nodiscard]] double coordinate(bool is_length) const { return is_length ? length : 1.0; }
  [[nodiscard]] double force_on(bool is_length) const { return is_length ? force() : torque(); }
};

/// Whether coordinate `component` of a word is a length.
inline bool is_length(const joints::Permit& word, int component) {
  if (std::holds_alternative<joints::Slide>(word)) return true;
  const auto* motion = std::get_if<joints::ByMotion>(&word);
  return motion != nullptr && !motion->turns[static_cast<std::size_t>(component)];
}

/// A law of values that grow by `value`.
inline TimeFunction in_units(const TimeFunction& law, double value, const Units& units) {
  struct Tell {
    double value;
    double time;
    TimeFunction operator()(ConstantSpeed law) const {
      return ConstantSpeed{law.start * value, law.speed * value / time};
    }
    TimeFunction operator()(Polynomial law) const {
      double factor = value;
      for (double& coefficient : law.coefficients) {
        coefficient *= factor;
        factor /= time;
      }
      return law;
    }
    TimeFunction operator()(const Harmonic& law) const {
      return Harmonic{law.offset * value, law.amplitude * value, law.frequency / time, law.phase};
    }
    TimeFunction operator()(const SmoothStep& law) const {
      return SmoothStep{law.t0 * time, law.t1 * time, law.from * value, law.to * value};
    }
    TimeFunction operator()(const SplineTable& law) const { return scaled(law, time, value); }
    static SplineTable scaled(const SplineTable& table, double x, double y) {
      std::vector<double> xs = table.times();
      std::vector<double> ys = table.values();
      for (double& one : xs) one *= x;
      for (double& one : ys) one *= y;
      return {xs, ys};
    }
  };
  return std::visit(Tell{value, units.time}, law);
}

inline std::optional<ForceTable> in_units(const std::optional<ForceTable>& table, double x, double force) {
  if (!table) return {};
  std::vector<double> xs = table->points().times();
  std::vector<double> forces = table->points().values();
  for (double& one : xs) one *= x;
  for (double& one : forces) one *= force;
  return ForceTable(xs, forces);
}

/// A force law over a length or an angle.
inline ForceLaw in_units(ForceLaw law, bool over_length, const Units& units) {
  const double x = units.coordinate(over_length);
  const double force = units.force_on(over_length);
  law.stiffness *= force / x;
  law.damping *= force / x * units.time;
  law.free *= x;
  law.preload *= force;
  law.spring_table = in_units(law.spring_table, x, force);
  law.damper_table = in_units(law.damper_table, x / units.time, force);
  for (std::optional<SmoothStop>* stop : {&law.lower, &law.upper}) {
    if (!*stop) continue;
    (*stop)->at *= x;
    (*stop)->width *= x;
    (*stop)->stiffness *= force / x;
    (*stop)->damping *= force / x * units.time;
  }
  if (law.actuator) law.actuator = in_units(*law.actuator, force, units);
  return law;
}

inline Attachment in_units(Attachment side, const Units& units) {
  side.point_L *= units.length;
  side.Psi_t_L *= units.length / units.modal;
  side.Psi_r_L /= units.modal;
  return side;
}

inline Body in_units(Body body, const Units& units) {
  if (body.pose_guess) body.pose_guess->r *= units.length;
  body.a_start *= units.modal;
  body.adot_start *= units.modal / units.time;
  body.mass *= units.mass;
  body.center_of_mass_L *= units.length;
  body.inertia_L *= units.mass * units.length * units.length;
  if (!body.modal) return body;
  ModalData& modal = *body.modal;
  const double stiffness = units.torque() / (units.modal * units.modal);
  modal.stiffness *= stiffness;
  modal.damping *= stiffness * units.time;
  modal.frequencies /= units.time;
  VecX scale = VecX::Constant(modal.G.rows(), units.length / units.modal);
  scale(0) = 1.0;
  scale.segment<3>(1).setConstant(units.length);
  modal.G = units.mass * (scale.asDiagonal() * modal.G * scale.asDiagonal());
  for (ModalNode& node : modal.nodes) {
    node.s0_L *= units.length;
    node.Psi_t_L *= units.length / units.modal;
    node.Psi_r_L /= units.modal;
  }
  for (MassPoint& point : modal.mass_points) {
    point.mass *= units.mass;
    point.s0_L *= units.length;
    point.Psi_t_L *= units.length / units.modal;
  }
  return body;
}

/// The length that a joint type with a parameter states: of its arm, its rolling radius, or its lead.
inline double length_of(const joints::JointType& type) {
  for (const joints::Permit& word : type.permits) {
    if (const auto* arm = std::get_if<joints::Arm>(&word)) return arm->length;
    if (const auto* motion = std::get_if<joints::ByMotion>(&word)) {
      joints::FunctionOfCoordinates::Motion at;
      const double q = 1.0;
      const double u = 0.0;
      motion->motion->evaluate(&q, &u, at);
      return at.placement.d.norm();
    }
  }
  for (const joints::ForbidSpeed& word : type.forbids_speeds) return std::get<joints::NoSlip>(word).below;
  throw std::logic_error("no rule to read the parameter of a joint of type " + type.name);
}

inline Joint in_units(Joint joint, const Units& units) {
  for (Attachment& side : joint.sides) side = in_units(std::move(side), units);
  const joints::JointType& type = *joint.type;
  for (std::size_t word = 0; word < joint.start.size(); ++word) {
    for (Eigen::Index c = 0; c < joint.start[word].q.size(); ++c) {
      joint.start[word].q(c) *= units.coordinate(is_length(type.permits[word], static_cast<int>(c)));
    }
    for (Eigen::Index c = 0; c < joint.start[word].u.size(); ++c) {
      joint.start[word].u(c) *= units.coordinate(is_length(type.permits[word], static_cast<int>(c))) / units.time;
    }
  }
  for (Driver& driver : joint.drivers) {
    driver.law = in_units(driver.law, units.coordinate(is_length(type.permits[driver.word], driver.component)), units);
  }
  for (JointSpring& spring : joint.springs) {
    spring.law = in_units(spring.law, is_length(type.permits[spring.word], spring.component), units);
  }
  if (type.with_parameters != nullptr) {
    joint.own_type = std::make_shared<const joints::JointType>(type.with_parameters({length_of(type) * units.length}));
    joint.type = joint.own_type.get();
  }
  return joint;
}

inline Road in_units(Road road, const Units& units) {
  if (auto* flat = std::get_if<FlatRoad>(&road.profile)) flat->height *= units.length;
  if (auto* bump = std::get_if<HalfSineBump>(&road.profile)) {
    bump->start *= units.length;
    bump->length *= units.length;
    bump->height *= units.length;
  }
  if (auto* table = std::get_if<RoadTable>(&road.profile)) {
    const Units of_lengths{1.0, 1.0, units.length};
    const TimeFunction spline = in_units(TimeFunction(table->spline), units.length, of_lengths);
    road.profile = RoadTable{std::get<SplineTable>(spline), table->first * units.length, table->last * units.length};
  }
  return road;
}

/// What a force element says, told in other units.
struct ElementInUnits {
  Units units;

  void operator()(Load& load) const {
    load.at = in_units(std::move(load.at), units);
    load.force *= units.force();
    load.torque *= units.torque();
    load.law = in_units(load.law, 1.0, units);
  }
  void operator()(LineSpring& spring) const {
    for (Attachment& end : spring.ends) end = in_units(std::move(end), units);
    spring.law = in_units(spring.law, true, units);
  }
  void operator()(TurnSpring& spring) const {
    for (Attachment& end : spring.ends) end = in_units(std::move(end), units);
    spring.law = in_units(spring.law, false, units);
  }
  void operator()(Bushing& bushing) const {
    for (Attachment& end : bushing.ends) end = in_units(std::move(end), units);
    Vec6 wrench;
    wrench << Vec3::Constant(units.force()), Vec3::Constant(units.torque());
    Vec6 motion;
    motion << Vec3::Constant(units.length), Vec3::Ones();
    const Vec6 per_motion = motion.cwiseInverse();
    bushing.stiffness = wrench.asDiagonal() * bushing.stiffness * per_motion.asDiagonal();
    bushing.damping = units.time * (wrench.asDiagonal() * bushing.damping * per_motion.asDiagonal());
    bushing.preload = wrench.cwiseProduct(bushing.preload);
  }
  void operator()(Tire& tire) const {
    tire.wheel = in_units(std::move(tire.wheel), units);
    tire.road = std::make_shared<const Road>(in_units(*tire.road, units));
    tire.radius *= units.length;
    tire.stiffness *= units.force() / units.length;
    tire.damping *= units.force() / units.length * units.time;
    tire.slip_stiffness *= units.force();
    tire.cornering_stiffness *= units.force();
    tire.speed_scale *= units.length / units.time;
  }
};

/// The whole statement in other units. The sum of a coupling keeps its number.
inline Model told_in_units(Model model, const Units& units) {
  model.gravity *= units.length / (units.time * units.time);
  model.run.until *= units.time;
  for (Coupling& coupling : model.couplings) {
    for (CouplingTerm& term : coupling.terms) {
      term.factor /= units.coordinate(is_length(model.joints[term.joint].type->permits[term.word], term.component));
    }
  }
  for (Body& body : model.bodies) body = in_units(std::move(body), units);
  for (Joint& joint : model.joints) joint = in_units(std::move(joint), units);
  for (ForceElement& element : model.elements) std::visit(ElementInUnits{units}, element.what);
  return model;
}

/// What a solver finds in other units, told in the first ones.
inline Evaluation back_from_units(Evaluation evaluation, const Units& units,
                                  const std::vector<const joints::JointType*>& types) {
  const double squared = units.time * units.time;
  for (BodyAcceleration& body : evaluation.bodies) {
    body.vdot *= squared / units.length;
    body.omegadot *= squared;
    body.addot *= squared / units.modal;
  }
  const auto back = [&](SideWrench& side) {
    for (Wrench* wrench : {&side.in_C, &side.in_global}) {
      wrench->force /= units.force();
      wrench->torque /= units.torque();
    }
  };
  for_each_side_wrench(evaluation, back);
  for (ElementWrenches& element : evaluation.elements) {
    for (SideWrench& side : element.on) back(side);
  }
  for (double& force : evaluation.couplings) force /= units.torque();
  for (std::size_t k = 0; k < types.size(); ++k) {
    for (std::size_t word = 0; word < types[k]->permits.size(); ++word) {
      const int first = first_u(*types[k], static_cast<int>(word));
      for (int c = 0; c < n_u(types[k]->permits[word]); ++c) {
        evaluation.joints[k].tau(first + c) /= units.force_on(is_length(types[k]->permits[word], c));
      }
    }
  }
  return evaluation;
}

/// Tells the machine in other units.
inline Change in_units(const Model& first, const Units& units) {
  std::vector<const joints::JointType*> types;
  for (const Joint& joint : first.joints) types.push_back(joint.type);
  Change change;
  change.model = [units](Model model) { return told_in_units(std::move(model), units); };
  change.state = [units, types](State state) {
    state.t *= units.time;
    for (BodyState& body : state.bodies) {
      body.r *= units.length;
      body.v *= units.length / units.time;
      body.omega /= units.time;
      body.a *= units.modal;
      body.adot *= units.modal / units.time;
    }
    for (std::size_t k = 0; k < types.size(); ++k) {
      for (std::size_t word = 0; word < types[k]->permits.size(); ++word) {
        const joints::Permit& permit = types[k]->permits[word];
        const int q = first_q(*types[k], static_cast<int>(word));
        const int u = first_u(*types[k], static_cast<int>(word));
        for (int c = 0; c < n_q(permit); ++c) state.q[k](q + c) *= units.coordinate(is_length(permit, c));
        for (int c = 0; c < n_u(permit); ++c) state.u[k](u + c) *= units.coordinate(is_length(permit, c)) / units.time;
      }
    }
    return state;
  };
  change.evaluation = [units, types](const State&, Evaluation evaluation) {
    return back_from_units(std::move(evaluation), units, types);
  };
  return change;
}

// Several ------------------------------------------------------------------------------------------------------------

/// One change after another.
inline Change operator|(const Change& first, const Change& then) {
  Change both;
  both.model = [first, then](Model model) { return then.model(first.model(std::move(model))); };
  both.state = [first, then](State state) { return then.state(first.state(std::move(state))); };
  both.evaluation = [first, then](const State& before, Evaluation evaluation) {
    return first.evaluation(before, then.evaluation(first.state(before), std::move(evaluation)));
  };
  both.unique = [first, then](Uniqueness flags) { return first.unique(then.unique(std::move(flags))); };
  return both;
}

}  // namespace concord::verification
