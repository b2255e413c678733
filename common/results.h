#pragma once

#include <array>
#include <vector>

#include "common/types.h"

/// What leaves a solver: motions, wrenches, and which of these are unique.
namespace concord {

/// Motion of one body: origin r [m], Euler parameters p (scalar first), velocity v of the origin and angular velocity
/// omega, all in global axes; modal coordinates a and their rates.
struct BodyState {
  Vec3 r = Vec3::Zero();
  Vec4 p{1.0, 0.0, 0.0, 0.0};
  Vec3 v = Vec3::Zero();
  Vec3 omega = Vec3::Zero();
  VecX a;
  VecX adot;
};

/// The angle of a turn spring that nothing is known of lies within half a turn of this [rad]: in (-pi, pi], and ends
/// that stand half a turn apart to within it have the angle pi, whichever side round-off puts them on.
inline constexpr double kUnwound = 1e-6;

/// A complete state of the machine. `bodies` has ground at index 0, at rest.
struct State {
  double t = 0.0;
  std::vector<BodyState> bodies;
  /// Joint coordinates and speeds of every joint (n_q and n_u numbers of its type), turns counted. They follow from the
  /// bodies but for the number of turns and the sign of Euler parameters; whoever receives a state uses them as hints.
  std::vector<VecX> q;
  std::vector<VecX> u;
  /// Of every force element that is a turn spring its angle [rad], turns counted (S34); zero for other elements. They
  /// follow from the bodies but for the number of turns, as above.
  std::vector<double> spring_angles;

  /// From which the turns of a turn spring are counted, at most half a turn away; kUnwound where nothing is said.
  [[nodiscard]] double known_angle(std::size_t element) const {
    return element < spring_angles.size() ? spring_angles[element] : kUnwound;
  }
};

/// Force [N] and torque [N m] about a point that the owner names (S20).
struct Wrench {
  Vec3 force = Vec3::Zero();
  Vec3 torque = Vec3::Zero();

  Wrench& operator+=(const Wrench& other) {
    force += other.force;
    torque += other.torque;
    return *this;
  }
  [[nodiscard]] Vec6 vector() const {
    Vec6 stacked;
    stacked << force, torque;
    return stacked;
  }
};

/// A wrench on one side of a joint: on the child at P_i or on the parent at P_j (its own material point), in that
/// side's joint frame and in global axes (S23).
struct SideWrench {
  Wrench in_C;
  Wrench in_global;
};

/// Who pushes along a joint's coordinates; the force of a coupling is a number of its own (Evaluation::couplings).
enum class Actor { driver, motor, spring, damper };
inline constexpr std::array kActors{Actor::driver, Actor::motor, Actor::spring, Actor::damper};
inline constexpr std::size_t index(Actor actor) { return static_cast<std::size_t>(actor); }

/// Wrenches of one joint. Reaction = total minus the coordinate wrenches of drivers, springs, actuators and couplings
/// on the joint: the total holds all that passes through it (S21), (S22).
struct JointWrenches {
  std::array<SideWrench, 2> reaction;
  std::array<SideWrench, 2> total;
  /// Coordinate force of driver, spring, actuator and couplings on each joint speed (n_u numbers): tau > 0 pushes the
  /// speed to grow [N, N m]; zero where there is none.
  VecX tau;
  /// The shares that make up tau, by actor, n_u numbers each and of tau's sign: what a driver exerts to keep its law;
  /// the law of time of a motor; what a spring and a damper exert, tables and stops included: at rest in the same
  /// place, and what the rate adds to that (S26). The rest is what couplings exert.
  std::array<VecX, kActors.size()> shares;

  [[nodiscard]] const VecX& share_of(Actor actor) const { return shares[index(actor)]; }
  [[nodiscard]] const SideWrench& reaction_on(Side side) const { return reaction[index(side)]; }
  [[nodiscard]] const SideWrench& total_on(Side side) const { return total[index(side)]; }
};

/// What a force element exerts: on the child at its end P_i and on the parent at P_j, each in its end's frame A' and in
/// global axes. A load and a tire have no parent: zero there.
struct ElementWrenches {
  std::array<SideWrench, 2> on;

  [[nodiscard]] const SideWrench& on_side(Side side) const { return on[index(side)]; }
};

/// Acceleration of one body: of its origin, angular, and of its modal coordinates; global axes.
struct BodyAcceleration {
  Vec3 vdot = Vec3::Zero();
  Vec3 omegadot = Vec3::Zero();
  VecX addot;
};

/// What a solver computes from a state, without integration.
struct Evaluation {
  std::vector<BodyAcceleration> bodies;  // ground included
  std::vector<JointWrenches> joints;
  std::vector<ElementWrenches> elements;
  /// Force f of each coupling: it adds factor_k f to the coordinate force of every coordinate that it relates.
  std::vector<double> couplings;
};

struct Sample {
  State state;
  Evaluation evaluation;
  /// Work done since the start by drivers, joint springs, force elements and modal damping [J], integrated with the
  /// motion: all that changes kinetic energy plus that of gravity and of modal stiffness (S41).
  double work = 0.0;
};

struct SolverStatistics {
  double wall_s = 0.0;
  long steps = 0;
  long evaluations = 0;
  /// Largest closure residual of positions and velocities over the samples (m, rad and per s, mixed, as the solver
  /// measures it) after projection.
  double max_constraint = 0.0;
  /// The largest |work| at any step, between samples too [J]: what errors of the work are small beside.
  double largest_work = 0.0;
};

struct Trajectory {
  std::vector<Sample> samples;
  SolverStatistics statistics;
};

/// What of a joint's wrenches a solver finds unique.
struct JointUniqueness {
  /// Per side and component (F_x ... T_z in that side's joint frame): of the reaction, and of the total wrench.
  std::array<std::array<bool, 6>, 2> unique;
  std::array<std::array<bool, 6>, 2> unique_total;
  /// Forces of drivers and couplings by speed of the joint.
  std::array<bool, 6> unique_tau;
  /// Forces of the drivers alone by speed of the joint.
  std::array<bool, 6> unique_driver;

  JointUniqueness() {
    for (auto& side : unique) side.fill(true);
    for (auto& side : unique_total) side.fill(true);
    unique_tau.fill(true);
    unique_driver.fill(true);
  }
};

/// Rank of the constraints at a state, found by one solver alone.
struct RankReport {
  int constraints = 0;  // rows, drivers included, Euler parameter norms not
  int rank = 0;
  int degrees_of_freedom = 0;  // rigid ones and modal ones
  bool undecided = false;      // a singular value between 1e-12 and 1e-8 of the largest: of the rank, beside `decided`
  double smallest_kept = 0.0;  // relative to the largest singular value
  double largest_dropped = 0.0;
  std::vector<JointUniqueness> joints;
  /// Whether each flag of `joints` stays what it is when the thresholds that decide it are multiplied or divided by the
  /// square root of 1000; false: the flag is undecided. Empty: all stay.
  std::vector<JointUniqueness> decided;
  /// The same two of the force of each coupling. Empty: all unique, and all stay.
  std::vector<bool> unique_coupling;
  std::vector<bool> decided_coupling;
};

}  // namespace concord
