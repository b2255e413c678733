#pragma once

#include <optional>

#include "common/solver.h"
#include "compare/verdict/chart.h"

/// Small deviations of a machine from a motion, in the coordinates of its joints.
namespace concord::compare::analyses {

/// Deviations delta from the motion that leads through a state, frozen at its time: the chart's coordinates there, but
/// measured in what all joints and modes have moved beyond what the motion itself moves them. In these coordinates the
/// steady motion of a rotor, or of a machine on an arm that turns, is a rest: its matrices do not depend on time, and
/// gyroscopic and centrifugal terms stand in them. Angles and displacements deviate as numbers; the orientation of a
/// ball by a rotation vector eps in the axes of the side that turns slower, with epsdot = omega - omega* - eps x omega*
/// on the parent's side (plus on the child's), omega* being that of the motion.
///
/// Model and solver must outlive it; the state is closed.
class Deviations {
 public:
  Deviations(const Model& model, Solver& solver, const State& state);

  /// Coordinates at the state, in which deviations of first order are measured.
  [[nodiscard]] const Chart& chart() const { return chart_; }
  /// Speeds of joints and modes, scaled by the machine's length and deflections, that belong to rates of 1.
  [[nodiscard]] const MatX& directions() const { return scaled_directions_; }
  /// Size of all its speeds, those of drivers too, in units of the machine [1/s].
  [[nodiscard]] double speed() const { return weights_.cwiseProduct(speeds_).norm(); }
  /// Second derivatives of the coordinates along the motion itself [1/s2]: zero where it is steady.
  [[nodiscard]] const VecX& accelerations() const { return accelerations_; }

  /// Second derivatives of the deviations [1/s2] where they are delta, with rates deltadot of the deviations; exact to
  /// first order in both, and even in the rest. Nothing if the solver finds no closed state there.
  [[nodiscard]] std::optional<VecX> accelerations_at(const VecX& delta, const VecX& deltadot);

 private:
  /// Speeds of all joints, then rates of all modal coordinates, and the same of their rates; balls in their own axes.
  [[nodiscard]] VecX speeds(const State& state) const;
  [[nodiscard]] VecX speed_rates(const State& state, const Evaluation& evaluation) const;
  /// eps x values over the rows of balls, + or - by their axes; zero elsewhere.
  [[nodiscard]] VecX turned_with(const VecX& deviation, const VecX& values) const;
  void choose_axes(const State& state);
  void find_weights();

  struct BallRows {
    Eigen::Index first;
    double sign;  // of omega* x eps in epsdot
  };

  const Model& model_;
  Solver& solver_;
  Chart chart_;
  std::vector<bool> by_child_;  // joints whose ball is seen from the child
  std::vector<BallRows> balls_;
  VecX weights_;     // of the rows
  MatX directions_;  // rows of speeds() by coordinates
  MatX scaled_directions_;
  MatX inverse_;  // left inverse of directions_
  VecX speeds_;
  VecX speed_rates_;
  VecX rates_;
  VecX accelerations_;
};

}  // namespace concord::compare::analyses
