#pragma once

#include <optional>
#include <vector>

#include "common/solver.h"
#include "compare/states/chart.h"

/// Small deviations of a machine from a motion, in the coordinates of its joints.
namespace concord::compare::analyses {

/// Axes that turn steadily against those of a joint's side, with which they coincide at a time: where a machine
/// precesses or spins about an axis of its own, its motion is a rest in them and in no others.
struct TurningAxes {
  double since = 0.0;       // s
  std::vector<Vec3> rates;  // by joint, in the axes of its side [rad/s]; empty: none turns
  /// Whether displacements of free joints are seen in them, too: those of a body whose origin goes round.
  bool carry_places = false;
  /// One rate for all [rad/s, in ground axes]: instead of joint coordinates the places and orientations of bodies
  /// deviate, seen in axes that turn so. A rotor in bearings that themselves tilt, as in a universal joint or a housing
  /// on springs, stands still in no joint's axes, but it does in these if what carries it is alike all around.
  std::optional<Vec3> of_bodies = std::nullopt;
};

/// Deviations delta from the motion that leads through a state, frozen at its time: the chart's coordinates there, but
/// measured in what all joints and modes have moved beyond what the motion itself moves them. In these coordinates the
/// steady motion of a rotor, or of a machine on an arm that turns, is a rest: its matrices do not depend on time, and
/// gyroscopic and centrifugal terms stand in them. Angles and displacements deviate as numbers; the orientation of a
/// ball by a rotation vector eps in the axes of the child where that clearly turns slower, of the parent otherwise,
/// with epsdot = omega - omega* - eps x omega* on the parent's side (plus on the child's), omega* being that of the
/// motion. Where TurningAxes turn at W against that side, eps and the displacements of a free joint are taken in them:
/// their rates in these axes are less by W x eps. Where one rate holds for all bodies, their places and orientations
/// take the place of what joints have moved, as if each hung on the ground by a free joint.
///
/// Model and solver must outlive it; the state is closed.
class Deviations {
 public:
  Deviations(const Model& model, Solver& solver, const State& state, const TurningAxes& axes = {});

  /// Coordinates at the state, in which deviations of first order are measured.
  [[nodiscard]] const Chart& chart() const { return chart_; }
  /// Speeds of joints and modes, scaled by the machine's length and deflections, that belong to rates of 1.
  [[nodiscard]] const MatX& directions() const { return scaled_directions_; }
  /// Size of all its speeds, those of drivers too, in units of the machine [1/s].
  [[nodiscard]] double speed() const { return weights_.cwiseProduct(speeds_).norm(); }
  /// Second derivatives of the coordinates along the motion itself [1/s2], as seen in the axes that turn: zero where it
  /// is steady.
  [[nodiscard]] const VecX& accelerations() const { return accelerations_; }

  /// Second derivatives of the deviations [1/s2] where they are delta, with rates deltadot of the deviations; exact to
  /// first order in both, and even in the rest. Nothing if the solver finds no closed state there.
  [[nodiscard]] std::optional<VecX> accelerations_at(const VecX& delta, const VecX& deltadot);

  /// Axes in which the motion of each ball would be a rest if it is steady: those that turn with its angular velocity w
  /// about an axis that stands still, (wdot x wddot) / |wdot|^2; where w itself stands still, those of the other side.
  /// Nothing if the solver finds no closed state a little later and earlier.
  [[nodiscard]] std::optional<TurningAxes> steady_axes();

 private:
  /// Speeds of all joints, or velocities of all bodies, then rates of all modal coordinates, and the same of their
  /// rates; balls in their own axes.
  [[nodiscard]] VecX speeds(const State& state) const;
  [[nodiscard]] VecX speed_rates(const State& state, const Evaluation& evaluation) const;
  void put_joint_speeds(const State& state, VecX& rows) const;
  void put_joint_speed_rates(const State& state, const Evaluation& evaluation, VecX& rows) const;
  /// Over the rows of balls eps x values, + or - by their axes; zero elsewhere.
  [[nodiscard]] VecX turned_with(const VecX& deviation, const VecX& values) const;
  /// W x values over the rows that are seen in turning axes; zero elsewhere.
  [[nodiscard]] VecX turned_by_axes(const VecX& values) const;
  /// Seen in the turning axes instead of those of the sides.
  void turn_rows(VecX& rows) const;
  void choose_axes(const State& state, const TurningAxes& axes);
  void choose_axes_of_bodies(const State& state, const TurningAxes& axes);
  void find_weights();
  /// Of the rows of bodies: those that turn with the axes say how the machine deviates, others where these do not.
  void find_weights_of_bodies(const State& state, const Vec3& W);
  void add_weights_of_modes(std::vector<double>& weights);

  struct BallRows {
    std::size_t joint;  // or body
    Eigen::Index first;
    double sign;  // of omega* x eps in epsdot
  };
  /// Three rows that are a vector, seen in axes that have turned by Q and turn at W.
  struct TurnedRows {
    Eigen::Index first;
    Vec3 W;
    Mat3 Q;
  };

  const Model& model_;
  Solver& solver_;
  Chart chart_;
  bool are_of_bodies_ = false;   // the rows before those of modes
  Eigen::Index first_mode_ = 0;  // the first row of a mode
  std::vector<bool> by_child_;   // joints whose ball is seen from the child
  std::vector<BallRows> balls_;
  std::vector<TurnedRows> turned_;
  VecX weights_;     // of the rows
  MatX directions_;  // rows of speeds() by coordinates
  MatX scaled_directions_;
  MatX inverse_;  // left inverse of directions_
  VecX speeds_;
  VecX speed_rates_;
  VecX rates_;
  VecX accelerations_;
};

/// Axes that turn as one of the bodies does, for all bodies: of each speed one, those of flexible bodies first, in
/// whose axes modes deviate, then the fastest; at most three.
std::vector<TurningAxes> axes_of_bodies(const Model& model, const State& state);

}  // namespace concord::compare::analyses
