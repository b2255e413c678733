#include "compare/joint_check/rig.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/joints/catalogue.h"
#include "common/rotation.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/referee.h"
#include "compare/joint_check/parts.h"
#include "compare/quantities/observe.h"
#include "relative/dynamics/equations.h"
#include "relative/start/states.h"

namespace concord::compare::joint_check {

namespace {

ForceTable table(double reach, double force, Numbers& numbers) {
  std::vector<double> x;
  std::vector<double> forces;
  for (int k = -3; k <= 3; ++k) {
    x.push_back(reach * k / 3.0);
    forces.push_back(force * (0.3 * k + numbers()));
  }
  return {x, forces};
}

/// A spring and damper with everything that a law can have; stops that are reached at some poses.
ForceLaw law_of(const Coordinate& coordinate, Numbers& numbers) {
  const double reach = 0.5 * (coordinate.greatest - coordinate.least);
  const double middle = 0.5 * (coordinate.greatest + coordinate.least);
  const double force = 10.0;  // N, N m
  ForceLaw law;
  law.stiffness = force / reach * (1.0 + 0.5 * numbers());
  law.damping = 3.0 + numbers();
  law.free = middle + 0.3 * reach * numbers();
  law.preload = 0.3 * force * numbers();
  law.spring_table = table(reach, 0.5 * force, numbers);
  law.damper_table = table(2.0, 0.5 * force, numbers);
  law.lower = SmoothStop{middle - 0.5 * reach, force / reach, 0.4, 0.1 * reach};
  law.upper = SmoothStop{middle + 0.6 * reach, force / reach, 0.6, 0.2 * reach};
  return law;
}

std::string_view name_of(Load load) {
  switch (load) {
    case Load::none:
      return "free";
    case Load::spring:
      return "sprung";
    case Load::motor:
      return "motored";
    default:
      return "driven";
  }
}

}  // namespace

std::string describe(const Arrangement& arrangement) {
  std::string text = arrangement.parent_bends ? "flexible parent" : "rigid parent";
  text += arrangement.child_bends ? ", flexible child" : ", rigid child";
  text += arrangement.tree_runs_against ? ", tree against the joint" : ", tree along the joint";
  for (std::size_t k = 0; k < arrangement.loads.size(); ++k) {
    text += fmt::format("{} coordinate {} {}", k == 0 ? ";" : ",", k + 1, name_of(arrangement.loads[k]));
  }
  return text;
}

Rig::Rig(const JointType& type, const Arrangement& arrangement, std::uint32_t seed)
    : type_(type), arrangement_(arrangement), seed_(seed), poses_(type, seed) {
  Numbers numbers(seed, streams::kRig);
  open_ = build_open(numbers);
  close_loops(numbers);
  equations_ = std::make_unique<relative::Equations>(open_);
  states_ = std::make_unique<relative::States>(*equations_);
}

Rig::~Rig() = default;

Model Rig::build_open(Numbers& numbers) const {
  Model model;
  model.name = "rig";
  model.file = "rig";
  model.gravity = Vec3(2.3, -8.9, 3.7);
  model.bodies.emplace_back();
  model.bodies.front().name = "ground";
  for (const int i : {1, 2}) {
    const bool bends = i == parent() ? arrangement_.parent_bends : arrangement_.child_bends;
    const std::string name = i == 1 ? "inner" : "outer";
    model.bodies.push_back(bends ? flexible_body(name, 4 - i, numbers) : rigid_body(name, numbers));
  }
  const VecX q = free_q(numbers);
  const VecX u = numbers.vector(6, 1.5);
  model.joints.push_back(joint(model, "holder", *joints::find("free"), kGround, 1, q, u, StartRole::keep, numbers));
  model.joints.push_back(build_tested(model, numbers));
  return model;
}

Joint Rig::build_tested(const Model& model, Numbers& numbers) const {
  const MotionPose start = poses_.pose(0);
  Joint tested = joint(model, "tested", type_, parent(), child(), start.q, start.u, StartRole::keep, numbers);
  const std::vector<Coordinate> coordinates = coordinates_of(type_);
  for (std::size_t k = 0; k < coordinates.size(); ++k) {
    const Load how = arrangement_.loads.empty() ? Load::none : arrangement_.loads[k];
    load(tested, coordinates[k], how, numbers);
  }
  if (type_.nonholonomic_rows() > 0) keep_possible_speeds(tested);
  return tested;
}

/// Of the speeds that are left to each other, the start keeps the last ones.
void Rig::keep_possible_speeds(Joint& tested) const {
  int possible = type_.n_u() - type_.nonholonomic_rows() - static_cast<int>(tested.drivers.size());
  for (int word = static_cast<int>(tested.start.size()) - 1; word >= 0; --word) {
    WordStart& start = tested.start[word];
    if (start.role_u != StartRole::keep) continue;
    const int speeds = n_u(type_.permits[word]);
    if (speeds > possible) {
      start.role_u = StartRole::guess;
    } else {
      possible -= speeds;
    }
  }
}

/// Laws move gently about the start, away from singular poses. Of a word that is driven throughout the start says
/// nothing.
void Rig::load(Joint& tested, const Coordinate& coordinate, Load how, Numbers& numbers) const {
  WordStart& start = tested.start[coordinate.word];
  const double reach = 0.5 * (coordinate.greatest - coordinate.least);
  if (how == Load::driver) {
    const double amplitude = std::min(0.15, 0.2 * reach);
    tested.drivers.push_back({coordinate.word,
                              Harmonic{start.q(coordinate.component), amplitude, 6.0 + numbers(), 3.0 * numbers()},
                              coordinate.component});
    const auto is_of_word = [&](const Driver& driver) { return driver.word == coordinate.word; };
    if (std::count_if(tested.drivers.begin(), tested.drivers.end(), is_of_word) == start.u.size()) {
      start.role_q = StartRole::unsaid;
      start.role_u = StartRole::unsaid;
    }
  } else if (how == Load::spring) {
    tested.springs.push_back({coordinate.word, law_of(coordinate, numbers), coordinate.component});
  } else if (how == Load::motor) {
    ForceLaw law;
    law.actuator = Harmonic{4.0 * numbers(), 9.0, 5.0 + numbers(), 3.0 * numbers()};
    tested.springs.push_back({coordinate.word, law, coordinate.component});
  }
}

void Rig::close_loops(Numbers& numbers) {
  idle_loop_ = open_;
  idle_loop_.joints[kTested].named_as_cut = true;
  const VecX unmoved = (VecX(7) << 0, 0, 0, 1, 0, 0, 0).finished();
  idle_loop_.joints.push_back(joint(idle_loop_, "closer", *joints::find("free"), kGround, 2, unmoved, VecX::Zero(6),
                                    StartRole::guess, numbers));

  loop_cut_at_tested_ = open_;
  // The ball decides the place of the whole rig: the start keeps its orientation only.
  for (int slide = 0; slide < 3; ++slide) {
    WordStart& start = loop_cut_at_tested_.joints[kHolder].start[slide];
    start.role_q = StartRole::guess;
    start.role_u = StartRole::guess;
  }
  loop_cut_at_tested_.joints.push_back(joint(loop_cut_at_tested_, "closer", *joints::find("spherical"), kGround, 2,
                                             VecX::Unit(4, 0), VecX::Zero(3), StartRole::guess, numbers));
  loop_cut_at_ball_ = loop_cut_at_tested_;
  loop_cut_at_tested_.joints[kTested].named_as_cut = true;
  loop_cut_at_ball_.joints[kCloser].named_as_cut = true;
}

VecX Rig::on_laws(double t, VecX q) const {
  for (const Driver& driver : open_.joints[kTested].drivers) {
    q(first_q(type_, driver.word) + driver.component) = evaluate(driver.law, t).f;
  }
  return q;
}

std::vector<SpeedValue> Rig::speeds_on_laws(double t) const {
  std::vector<SpeedValue> speeds;
  for (const Driver& driver : open_.joints[kTested].drivers) {
    speeds.push_back({first_u(type_, driver.word) + driver.component, evaluate(driver.law, t).fdot});
  }
  return speeds;
}

/// Whether the driven speeds are well among those that the type permits at q: a skate is not driven sideways.
bool Rig::can_follow_laws(double t, const VecX& q) const {
  constexpr double kLeastPart = 0.3;
  if (type_.permits_speeds.empty()) return true;
  const joints::FunctionOfCoordinates::Motion motion = referee_permits(type_, q, VecX::Zero(type_.n_u()));
  const MatX free = free_speeds(type_, motion.placement.R, motion.S.leftCols(type_.n_u()));
  const std::vector<SpeedValue> driven = speeds_on_laws(t);
  return std::all_of(driven.begin(), driven.end(),
                     [&](const SpeedValue& one) { return free.row(one.speed).norm() > kLeastPart; });
}

State Rig::write_state(double t, const VecX& q, const VecX& u, Numbers& numbers) {
  const relative::Topology& topology = equations_->topology();
  VecX all_q = VecX::Zero(topology.n_q);
  VecX all_u = VecX::Zero(topology.n_u);
  const relative::Span& holder = topology.joints[kHolder];
  const relative::Span& tested = topology.joints[kTested];
  all_q.segment(holder.first_q, 7) = free_q(numbers);
  all_u.segment(holder.first_u, 6) = numbers.vector(6, 1.6);
  all_q.segment(tested.first_q, q.size()) = q;
  all_u.segment(tested.first_u, u.size()) = nearest_possible(type_, q, u, speeds_on_laws(t));
  for (const relative::Span& modes : topology.modes) {
    all_q.segment(modes.first_q, modes.n_q) = numbers.vector(modes.n_q, 0.16);
    all_u.segment(modes.first_u, modes.n_u) = numbers.vector(modes.n_u, 1.6);
  }
  return states_->write(equations_->move(t, all_q, all_u), {});
}

State Rig::state(int number) {
  constexpr int kMostPoses = 1000;
  Numbers numbers(seed_, streams::kFirstState + static_cast<std::uint32_t>(number));
  const double t = 0.4 + 0.3 * numbers();
  MotionPose pose = poses_.pose(number);
  pose.q = on_laws(t, pose.q);
  for (int tries = 0; tries < kMostPoses && !(poses_.is_regular(pose.q) && can_follow_laws(t, pose.q)); ++tries) {
    pose.q = on_laws(t, poses_.draw_q(numbers));
  }
  return write_state(t, pose.q, pose.u, numbers);
}

State Rig::state_at(const VecX& q) {
  Numbers numbers(seed_, streams::kFirstState);
  return write_state(0.4, q, poses_.pose(0).u, numbers);
}

State Rig::in_idle_loop(State state) {
  state.q.emplace_back((VecX(7) << 0, 0, 0, 1, 0, 0, 0).finished());
  state.u.emplace_back(VecX::Zero(6));
  return state;
}

State Rig::in_loop(State state) const {
  const Joint& closer = loop_cut_at_tested_.joints[kCloser];
  const Attachment& ball = closer.on(Side::child);
  const BodyState& outer = state.bodies[ball.body];
  const Vec3 place = joint_point(loop_cut_at_tested_, state, closer, Side::child);
  const Mat3 A = rotation_of(outer.p);
  const Vec3 velocity = outer.v + outer.omega.cross(place - outer.r) + A * (ball.Psi_t_L * outer.adot);
  const Vec3 way = closer.on(Side::parent).point_L - place;
  for (std::size_t i = 1; i < state.bodies.size(); ++i) {
    state.bodies[i].r += way;
    state.bodies[i].v -= velocity;
  }
  state.q.emplace_back(VecX::Unit(4, 0));
  state.u.emplace_back(VecX::Zero(3));
  return state;
}

double Rig::weight() const {
  double mass = 0.0;
  for (const Body& body : open_.bodies) mass += body.modal ? body.modal->G(0, 0) : body.mass;
  return mass * open_.gravity.norm();
}

}  // namespace concord::compare::joint_check
