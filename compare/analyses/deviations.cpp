#include "compare/analyses/deviations.h"

#include <algorithm>
#include <cmath>

#include "common/decompositions.h"
#include "common/joints/joint_type.h"
#include "compare/audit/joint_kinematics.h"
#include "compare/resolution/resolution.h"
#include "compare/states/states.h"

namespace concord::compare::analyses {

namespace {

/// The first speed of a joint's ball; -1 without one.
int ball_of(const joints::JointType& type) {
  for (std::size_t word = 0; word < type.permits.size(); ++word) {
    if (is_orientation(type.permits[word])) return first_u(type, static_cast<int>(word));
  }
  return -1;
}

/// The places and the orientation of a body that is free: slides along x, y, z, then a ball.
bool is_free_joint(const joints::JointType& type) {
  return turning_speeds(type) == std::vector<bool>{false, false, false, true, true, true} && ball_of(type) == 3;
}

/// Of a body's v, then omega, where bodies deviate.
Eigen::Index first_row_of(std::size_t body) { return 6 * static_cast<Eigen::Index>(body - 1); }

PlacedFrame place_of(const Joint& joint, Side side, const State& state) {
  const Attachment& attachment = joint.on(side);
  return place(attachment, state.bodies[static_cast<std::size_t>(attachment.body)]);
}

}  // namespace

Deviations::Deviations(const Model& model, Solver& solver, const State& state, const TurningAxes& axes)
    : model_(model), solver_(solver), chart_(model, solver, state) {
  if (chart_.n() == 0) return;
  if (axes.of_bodies) {
    are_of_bodies_ = true;
    choose_axes_of_bodies(state, axes);
    find_weights_of_bodies(state, *axes.of_bodies);
  } else {
    choose_axes(state, axes);
    find_weights();
  }
  directions_.resize(weights_.size(), chart_.n());
  for (int k = 0; k < chart_.n(); ++k) {
    directions_.col(k) = speeds(chart_.origin_moving(VecX::Unit(chart_.n(), k)));
  }
  scaled_directions_ = weights_.asDiagonal() * directions_;
  inverse_ = least_squares(scaled_directions_, MatX(weights_.asDiagonal()));
  speeds_ = speeds(state);
  speed_rates_ = speed_rates(state, solver_.evaluate(state));
  rates_ = inverse_ * speeds_;
  accelerations_ = inverse_ * (speed_rates_ - turned_by_axes(speeds_));
}

void Deviations::choose_axes(const State& state, const TurningAxes& axes) {
  constexpr double kClearlySlower = 1.0 - 1e-6;
  constexpr double kTurns = 1e-9;  // of how the machine moves, or falls: less is round-off of a side that stands still
  const double falls = std::sqrt(model_.gravity.norm() / model_.length_scale());
  const double least = kTurns * std::max(falls, MachineSize(model_, state).turning);
  Eigen::Index row = 0;
  for (std::size_t k = 0; k < model_.joints.size(); ++k) {
    const Joint& joint = model_.joints[k];
    const double parent = place_of(joint, Side::parent, state).omega_joint.norm();
    const double child = place_of(joint, Side::child, state).omega_joint.norm();
    by_child_.push_back(parent > least && child < kClearlySlower * parent);
    const int ball = ball_of(*joint.type);
    if (ball >= 0) balls_.push_back({k, row + ball, by_child_.back() ? 1.0 : -1.0});
    if (ball >= 0 && !axes.rates.empty() && !axes.rates[k].isZero(0.0)) {
      const Mat3 Q = exponential_of(axes.rates[k] * (state.t - axes.since));
      turned_.push_back({row + ball, axes.rates[k], Q});
      if (axes.carry_places && is_free_joint(*joint.type) && !by_child_.back())
        turned_.push_back({row, axes.rates[k], Q});
    }
    row += joint.type->n_u();
  }
}

void Deviations::choose_axes_of_bodies(const State& state, const TurningAxes& axes) {
  const Vec3& W = *axes.of_bodies;
  const Mat3 Q = exponential_of(W * (state.t - axes.since));
  for (std::size_t i = 1; i < model_.bodies.size(); ++i) {
    const Eigen::Index row = first_row_of(i);
    balls_.push_back({i, row + 3, -1.0});
    turned_.push_back({row, W, Q});
    turned_.push_back({row + 3, W, Q});
  }
}

void Deviations::find_weights() {
  std::vector<double> weights;
  const double length = model_.length_scale();
  for (const Joint& joint : model_.joints) {
    for (const bool turns : turning_speeds(*joint.type)) weights.push_back(turns ? 1.0 : 1.0 / length);
  }
  add_weights_of_modes(weights);
}

void Deviations::find_weights_of_bodies(const State& state, const Vec3& W) {
  constexpr double kTurnsAlong = 1e-3;
  constexpr double kOfOthers = 1e-4;
  std::vector<double> weights;
  const double length = model_.length_scale();
  for (std::size_t i = 1; i < model_.bodies.size(); ++i) {
    const bool turns_along = (state.bodies[i].omega - W).norm() <= kTurnsAlong * W.norm();
    const double weight = turns_along ? 1.0 : kOfOthers;
    weights.insert(weights.end(), 3, weight / length);
    weights.insert(weights.end(), 3, weight);
  }
  add_weights_of_modes(weights);
}

void Deviations::add_weights_of_modes(std::vector<double>& weights) {
  first_mode_ = static_cast<Eigen::Index>(weights.size());
  for (std::size_t i = 1; i < model_.bodies.size(); ++i) {
    if (model_.bodies[i].n_modes() == 0) continue;
    for (const double size : modal_sizes(model_, i)) weights.push_back(size);
  }
  weights_ = Eigen::Map<const VecX>(weights.data(), static_cast<Eigen::Index>(weights.size()));
}

void Deviations::put_joint_speeds(const State& state, VecX& rows) const {
  Eigen::Index next = 0;
  for (std::size_t k = 0; k < model_.joints.size(); ++k) {
    const Joint& joint = model_.joints[k];
    const RelativeMotion relative = relative_motion_of(joint, state);
    VecX u = read_motion(*joint.type, relative, state.q[k]).u;
    const int ball = ball_of(*joint.type);
    if (ball >= 0 && by_child_[k]) u.segment<3>(ball) = relative.R.transpose() * Vec3(u.segment<3>(ball));
    rows.segment(next, u.size()) = u;
    next += u.size();
  }
}

void Deviations::put_joint_speed_rates(const State& state, const Evaluation& evaluation, VecX& rows) const {
  Eigen::Index next = 0;
  for (std::size_t k = 0; k < model_.joints.size(); ++k) {
    const Joint& joint = model_.joints[k];
    VecX udot = joint_accelerations(joint, state, evaluation, state.q[k], model_.length_scale());
    const int ball = ball_of(*joint.type);
    // d/dt (R^T omega_rel) = R^T omegadot_rel.
    if (ball >= 0 && by_child_[k]) {
      udot.segment<3>(ball) = relative_motion_of(joint, state).R.transpose() * Vec3(udot.segment<3>(ball));
    }
    rows.segment(next, udot.size()) = udot;
    next += udot.size();
  }
}

VecX Deviations::speeds(const State& state) const {
  VecX rows(weights_.size());
  if (are_of_bodies_) {
    for (std::size_t i = 1; i < model_.bodies.size(); ++i) {
      rows.segment<6>(first_row_of(i)) << state.bodies[i].v, state.bodies[i].omega;
    }
  } else {
    put_joint_speeds(state, rows);
  }
  Eigen::Index next = first_mode_;
  for (std::size_t i = 1; i < model_.bodies.size(); ++i) {
    const VecX& adot = state.bodies[i].adot;
    rows.segment(next, adot.size()) = adot;
    next += adot.size();
  }
  turn_rows(rows);
  return rows;
}

VecX Deviations::speed_rates(const State& state, const Evaluation& evaluation) const {
  VecX rows(weights_.size());
  if (are_of_bodies_) {
    for (std::size_t i = 1; i < model_.bodies.size(); ++i) {
      rows.segment<6>(first_row_of(i)) << evaluation.bodies[i].vdot, evaluation.bodies[i].omegadot;
    }
  } else {
    put_joint_speed_rates(state, evaluation, rows);
  }
  Eigen::Index next = first_mode_;
  for (std::size_t i = 1; i < model_.bodies.size(); ++i) {
    const VecX& addot = evaluation.bodies[i].addot;
    rows.segment(next, addot.size()) = addot;
    next += addot.size();
  }
  turn_rows(rows);
  return rows;
}

VecX Deviations::turned_with(const VecX& deviation, const VecX& values) const {
  VecX rows = VecX::Zero(values.size());
  for (const BallRows& ball : balls_) {
    const Vec3 eps = deviation.segment<3>(ball.first);
    rows.segment<3>(ball.first) = ball.sign * eps.cross(Vec3(values.segment<3>(ball.first)));
  }
  return rows;
}

VecX Deviations::turned_by_axes(const VecX& values) const {
  VecX rows = VecX::Zero(values.size());
  for (const TurnedRows& vector : turned_) {
    rows.segment<3>(vector.first) = vector.W.cross(Vec3(values.segment<3>(vector.first)));
  }
  return rows;
}

void Deviations::turn_rows(VecX& rows) const {
  for (const TurnedRows& vector : turned_) {
    rows.segment<3>(vector.first) = (vector.Q.transpose() * rows.segment<3>(vector.first)).eval();
  }
}

std::vector<TurningAxes> axes_of_bodies(const Model& model, const State& state) {
  constexpr std::size_t kMost = 3;
  constexpr double kSame = 1e-6;  // of the fastest
  constexpr double kRoundOff = 1e-12;
  std::vector<std::size_t> order;
  double fastest = 0.0;
  for (std::size_t i = 1; i < state.bodies.size(); ++i) {
    order.push_back(i);
    fastest = std::max(fastest, state.bodies[i].omega.norm());
  }
  const auto rank_of = [&](std::size_t i) {
    return std::pair(model.bodies[i].n_modes() > 0, state.bodies[i].omega.norm());
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return rank_of(a) > rank_of(b); });
  std::vector<TurningAxes> all;
  for (const std::size_t i : order) {
    const Vec3& W = state.bodies[i].omega;
    const auto is_it = [&](const TurningAxes& axes) { return (*axes.of_bodies - W).norm() <= kSame * fastest; };
    if (all.size() == kMost || !(W.norm() > kSame * fastest) || std::any_of(all.begin(), all.end(), is_it)) continue;
    all.push_back({state.t, {}});
    all.back().of_bodies = (W.array().abs() > kRoundOff * W.norm()).select(W, 0.0);
  }
  return all;
}

std::optional<TurningAxes> Deviations::steady_axes() {
  constexpr double kStep = 0.02;         // rad of the motion
  constexpr double kLeastStep = 1e-5;    // the same
  constexpr double kStandsStill = 1e-6;  // of w^2
  if (balls_.empty() || !(speed() > 0.0)) return std::nullopt;
  const Sample now{chart_.origin(), solver_.evaluate(chart_.origin()), 0.0};
  const auto rates_at = [&](double h) -> std::optional<VecX> {
    const auto state = solver_.close(predict(model_, now, h));
    if (!state) return std::nullopt;
    return speed_rates(*state, solver_.evaluate(*state));
  };
  const auto second_rates =
      derivative_at_zero(rates_at, kStep / speed(), kLeastStep / speed(), speed_rates_.norm() * speed());
  if (!second_rates) return std::nullopt;
  TurningAxes axes{now.state.t, std::vector<Vec3>(model_.joints.size(), Vec3::Zero())};
  for (const BallRows& ball : balls_) {
    const Vec3 w = speeds_.segment<3>(ball.first);
    const Vec3 wdot = speed_rates_.segment<3>(ball.first);
    const Vec3 wddot = second_rates->value.segment<3>(ball.first);
    const bool stands_still = wdot.norm() <= kStandsStill * w.squaredNorm();
    axes.rates[ball.joint] = stands_still ? Vec3(-ball.sign * w) : Vec3(wdot.cross(wddot) / wdot.squaredNorm());
  }
  return axes;
}

std::optional<VecX> Deviations::accelerations_at(const VecX& delta, const VecX& deltadot) {
  const VecX moved = directions_ * delta;
  // epsdot = omega - omega* -+ eps x omega* - W x eps: the speeds are as asked where those of the machine are so.
  const VecX drift = turned_with(moved, speeds_) - turned_by_axes(moved);
  const VecX wanted = rates_ + deltadot - inverse_ * drift;
  const auto state = chart_.at(
      delta, [&](const State& s) { return VecX(inverse_ * speeds(s)); }, wanted);
  if (!state) return std::nullopt;
  const auto evaluation = evaluation_unless_refused(solver_, *state);
  if (!evaluation) return std::nullopt;
  const VecX rate = speeds(*state) - speeds_ + drift;  // in axes that turn
  const VecX carried = turned_by_axes(moved);
  const VecX in_side_axes = speed_rates(*state, *evaluation) - speed_rates_ + turned_with(rate + carried, speeds_) +
                            turned_with(moved, speed_rates_);
  return VecX(inverse_ * (in_side_axes - turned_by_axes(2.0 * rate + carried)));
}

}  // namespace concord::compare::analyses
