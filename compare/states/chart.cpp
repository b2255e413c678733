#include "compare/states/chart.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/decompositions.h"
#include "common/error.h"
#include "common/products.h"
#include "compare/audit/machine_size.h"
#include "compare/audit/places.h"
#include "compare/states/motion_names.h"

namespace concord::compare {

namespace {

/// Directions at a neighbour belong to the chart as long as it sees so much of each.
constexpr double kSameDirection = 1e-6;

/// Calls `use` with each moving body's index and its first row.
template <class Use>
void for_each_body(const Model& model, const Use& use) {
  Eigen::Index row = 0;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    use(i, row);
    row += 6 + model.bodies[i].n_modes();
  }
}

VecX row_weights(const Model& model, double length) {
  Eigen::Index rows = 0;
  for_each_body(model, [&](std::size_t i, Eigen::Index row) { rows = row + 6 + model.bodies[i].n_modes(); });
  VecX weights = VecX::Ones(rows);
  for_each_body(model, [&](std::size_t i, Eigen::Index row) {
    weights.segment<3>(row).setConstant(1.0 / length);
    weights.segment(row + 6, model.bodies[i].n_modes()) = modal_sizes(model, i);
  });
  return weights;
}

State at_rest(State state) {
  for (BodyState& body : state.bodies) {
    body.v.setZero();
    body.omega.setZero();
    body.adot.setZero();
  }
  return state;
}

/// The rotation vector from one orientation to another, global axes.
Vec3 rotation_between(const Vec4& from, const Vec4& to) {
  return rotation_vector_of(rotation_of(to) * rotation_of(from).transpose());
}

/// thetadot = omega - theta x omega / 2 + c theta x (theta x omega), c = (1 - (t/2) cot(t/2)) / t^2 by its series, and
/// its time derivative; good for small turns, such as those of differences.
struct TurnRates {
  Vec3 thetadot;
  Vec3 thetaddot;

  TurnRates(const Vec3& theta, const Vec3& omega, const Vec3& omegadot) {
    const double s = theta.squaredNorm();
    const double c = 1.0 / 12.0 + s * (1.0 / 720.0 + s * (1.0 / 30240.0 + s / 1209600.0));
    const double slope = 1.0 / 720.0 + s * (2.0 / 30240.0 + s * 3.0 / 1209600.0);  // dc/ds
    const Vec3 once = theta.cross(omega);
    thetadot = omega - 0.5 * once + c * theta.cross(once);
    const Vec3 once_dot = thetadot.cross(omega) + theta.cross(omegadot);
    thetaddot = omegadot - 0.5 * once_dot + 2.0 * slope * theta.dot(thetadot) * theta.cross(once) +
                c * (thetadot.cross(once) + theta.cross(once_dot));
  }
};

}  // namespace

Chart::Chart(const Model& model, Solver& solver, const State& origin)
    : model_(model),
      solver_(solver),
      origin_(origin),
      length_(model.length_scale()),
      weights_(row_weights(model, length_)) {
  V_ = scaled_tangent(origin);
  if (n() > 0) put_modes_first();
}

void Chart::put_modes_first() {
  constexpr double kMovesNoMode = 1e-7;  // of what moves modes most
  constexpr double kRoundOff = 1e-12;    // of the scaled, orthonormal basis: joints may hold all modes
  int n_modes = 0;
  for (const Body& body : model_.bodies) n_modes += body.n_modes();
  if (n_modes == 0) return;
  MatX modal(n_modes, V_.cols());
  Eigen::Index next = 0;
  for_each_body(model_, [&](std::size_t i, Eigen::Index row) {
    const int modes = model_.bodies[i].n_modes();
    modal.middleRows(next, modes) = V_.middleRows(row + 6, modes);
    next += modes;
  });
  Eigen::ColPivHouseholderQR<MatX> split(MatX(modal.transpose()));
  if (split.maxPivot() <= kRoundOff) return;
  split.setThreshold(kMovesNoMode);
  n_modal_ = static_cast<int>(split.rank());
  V_ = product(V_, orthogonal_factor(split));
}

/// The solver scales only v, by the machine's length; here modal rows are scaled too, and columns orthonormal again.
MatX Chart::scaled_tangent(const State& state) const {
  MatX tangent = solver_.tangent(state);
  for_each_body(model_, [&](std::size_t i, Eigen::Index row) {
    const int modes = model_.bodies[i].n_modes();
    tangent.middleRows(row + 6, modes) =
        weights_.segment(row + 6, modes).asDiagonal() * MatX(tangent.middleRows(row + 6, modes));
  });
  if (tangent.cols() == 0) return MatX::Zero(weights_.size(), 0);
  return orthonormal_columns(tangent);
}

VecX Chart::velocities(const VecX& delta) const { return (V_ * delta).cwiseQuotient(weights_); }

VecX Chart::coordinates_of(const VecX& velocities) const { return V_.transpose() * velocities.cwiseProduct(weights_); }

std::string Chart::describe(const VecX& delta) const { return describe_motion(model_, origin_, velocities(delta)); }

VecX Chart::own_rates(const State& state) const {
  VecX scaled(weights_.size());
  for_each_body(model_, [&](std::size_t i, Eigen::Index row) {
    const BodyState& body = state.bodies[i];
    const Vec3 theta = rotation_between(origin_.bodies[i].p, body.p);
    scaled.segment<3>(row) = body.v;
    scaled.segment<3>(row + 3) = TurnRates(theta, body.omega, Vec3::Zero()).thetadot;
    scaled.segment(row + 6, body.adot.size()) = body.adot;
  });
  return V_.transpose() * scaled.cwiseProduct(weights_);
}

VecX Chart::coordinates(const State& state) const {
  VecX scaled(weights_.size());
  for_each_body(model_, [&](std::size_t i, Eigen::Index row) {
    const BodyState& body = state.bodies[i];
    scaled.segment<3>(row) = body.r - origin_.bodies[i].r;
    scaled.segment<3>(row + 3) = rotation_between(origin_.bodies[i].p, body.p);
    scaled.segment(row + 6, body.a.size()) = body.a - origin_.bodies[i].a;
  });
  return V_.transpose() * scaled.cwiseProduct(weights_);
}

namespace {

/// The state that `close` gives near coordinates, with exactly the wanted ones; nothing if it is not found. `size`: of
/// the coordinates' round-off.
template <class Close, class CoordinatesOf>
std::optional<State> closed_exactly(const VecX& wanted, double size, const Close& close,
                                    const CoordinatesOf& coordinates_of) {
  constexpr int kCorrections = 30;
  VecX aim = wanted;
  double last_miss = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kCorrections; ++k) {
    std::optional<State> state = close(aim);
    if (!state) return std::nullopt;
    const VecX miss = wanted - coordinates_of(*state);
    if (miss.norm() <= 1e-14 * size || (miss.norm() <= 1e-12 * size && miss.norm() >= 0.5 * last_miss)) return state;
    if (!(miss.norm() < last_miss)) return std::nullopt;
    last_miss = miss.norm();
    aim += miss;
  }
  return std::nullopt;
}

}  // namespace

std::optional<State> Chart::exactly_at(const VecX& delta) {
  return closed_exactly(
      delta, std::max(size_of_places(origin_, length_) / length_, delta.norm()),
      [&](const VecX& aim) { return at(aim, VecX::Zero(n())); },
      [&](const State& state) { return coordinates(state); });
}

std::optional<State> Chart::with_modes_at(const VecX& delta) {
  constexpr int kCorrections = 10;
  constexpr double kRoundOff = 1e-14;
  std::optional<State> moved = closed_exactly(
      delta, std::max(size_of_places(origin_, length_) / length_, delta.norm()),
      [&](const VecX& aim) { return place_at(aim); }, [&](const State& state) { return coordinates(state); });
  if (n_modal_ == 0) return moved;
  const State changes = origin_moving(delta);
  for (int k = 0; moved && k < kCorrections; ++k) {
    State wanted = *moved;
    double missed = 0.0;
    for (std::size_t i = 1; i < wanted.bodies.size(); ++i) {
      if (wanted.bodies[i].a.size() == 0) continue;
      wanted.bodies[i].a = origin_.bodies[i].a + changes.bodies[i].adot;
      const VecX miss = modal_sizes(model_, i).cwiseProduct(wanted.bodies[i].a - moved->bodies[i].a);
      missed = std::max(missed, miss.lpNorm<Eigen::Infinity>());
    }
    if (missed <= kRoundOff) break;
    std::optional<State> closed = solver_.close(wanted);
    if (!closed) break;
    moved = std::move(closed);
  }
  return moved;
}

VecX Chart::rates_at_origin() const { return own_rates(origin_); }

VecX Chart::accelerations(const State& state, const Evaluation& evaluation) const {
  VecX scaled(weights_.size());
  for_each_body(model_, [&](std::size_t i, Eigen::Index row) {
    const BodyState& body = state.bodies[i];
    const BodyAcceleration& rate = evaluation.bodies[i];
    const Vec3 theta = rotation_between(origin_.bodies[i].p, body.p);
    scaled.segment<3>(row) = rate.vdot;
    scaled.segment<3>(row + 3) = TurnRates(theta, body.omega, rate.omegadot).thetaddot;
    scaled.segment(row + 6, rate.addot.size()) = rate.addot;
  });
  return V_.transpose() * scaled.cwiseProduct(weights_);
}

void Chart::add_velocity(const VecX& scaled, State& state) const {
  const VecX velocity = scaled.cwiseQuotient(weights_);
  for_each_body(model_, [&](std::size_t i, Eigen::Index row) {
    BodyState& body = state.bodies[i];
    body.v += velocity.segment<3>(row);
    body.omega += velocity.segment<3>(row + 3);
    body.adot += velocity.segment(row + 6, body.adot.size());
  });
}

State Chart::origin_moving(const VecX& delta) const {
  State state = at_rest(origin_);
  add_velocity(V_ * delta, state);
  return state;
}

std::optional<State> Chart::at(const VecX& delta, const VecX& deltadot) {
  return at(
      delta, [this](const State& state) { return own_rates(state); }, deltadot);
}

State Chart::moved_by(const VecX& delta) const {
  const VecX moved = velocities(delta);
  State guess = origin_;
  for_each_body(model_, [&](std::size_t i, Eigen::Index row) {
    BodyState& body = guess.bodies[i];
    body.r += moved.segment<3>(row);
    body.p = turned(body.p, moved.segment<3>(row + 3));
    body.a += moved.segment(row + 6, body.a.size());
  });
  return guess;
}

std::string Chart::refusal_at(const VecX& delta) const {
  try {
    (void)solver_.evaluate(place_at(delta).value_or(at_rest(moved_by(delta))));
    return "";
  } catch (const SolverError& error) {
    return error.what();
  }
}

std::optional<State> Chart::place_at(const VecX& delta) const { return solver_.close(moved_by(delta)); }

std::optional<State> Chart::at(const VecX& delta, const Rates& rates, const VecX& wanted) {
  std::optional<State> closed = solver_.close(moved_by(delta));
  if (!closed || n() == 0) return closed;
  // Along the permitted velocities there, so that the rates are as asked.
  const MatX tangent = scaled_tangent(*closed);
  MatX map(V_.cols(), tangent.cols());
  for (Eigen::Index k = 0; k < tangent.cols(); ++k) {
    State unit = at_rest(*closed);
    add_velocity(tangent.col(k), unit);
    map.col(k) = rates(unit);
  }
  if (tangent.cols() < V_.cols()) refuse_singular_origin(map);
  Eigen::ColPivHouseholderQR<MatX> onto_chart(map);
  onto_chart.setThreshold(kSameDirection);
  if (tangent.cols() > V_.cols() || onto_chart.rank() < V_.cols()) return std::nullopt;
  add_velocity(tangent * least_squares(onto_chart, wanted - rates(*closed)), *closed);
  return solver_.close(*closed);
}

/// `map`: the neighbour's directions in coordinates of the chart.
void Chart::refuse_singular_origin(const MatX& map) const {
  MatX neighbour(n(), map.cols());
  if (map.cols() > 0) neighbour = orthonormal_columns(map);
  VecX lost = VecX::Zero(n());
  for (Eigen::Index k = 0; k < n(); ++k) {
    const VecX direction = VecX::Unit(n(), k) - neighbour * neighbour.row(k).transpose();
    if (direction.norm() > lost.norm()) lost = direction;
  }
  throw SingularPose(fmt::format(
      "{}: at t = {:.6g} s the constraints permit {} direction{} of motion, but only {} in a pose nearby, "
      "where this one is lost: {}; the pose is singular and the motion may branch there: start from another "
      "one",
      solver_.name(), origin_.t, n(), n() == 1 ? "" : "s", map.cols(), describe(lost)));
}

VecX scaled_accelerations(const Model& model, const Evaluation& evaluation) {
  VecX scaled = row_weights(model, model.length_scale());
  for_each_body(model, [&](std::size_t i, Eigen::Index row) {
    const BodyAcceleration& rate = evaluation.bodies[i];
    VecX stacked(6 + rate.addot.size());
    stacked << rate.vdot, rate.omegadot, rate.addot;
    scaled.segment(row, stacked.size()).array() *= stacked.array();
  });
  return scaled;
}

std::optional<Derivative> derivative_at_zero(const std::function<std::optional<VecX>(double)>& function, double step,
                                             double least, double scale) {
  const auto difference = [&](double h) -> std::optional<VecX> {
    const auto plus = function(h);
    if (!plus) return std::nullopt;
    const auto minus = function(-h);
    if (!minus) return std::nullopt;
    VecX slope = (*plus - *minus) / (2.0 * h);
    return slope.allFinite() ? std::optional(std::move(slope)) : std::nullopt;
  };
  constexpr double kGood = 1e-12;
  constexpr double kFair = 1e-5;  // worse than that, a derivative jumps within the step
  constexpr int kPatience = 2;
  std::optional<Derivative> best;
  double least_error = 0.0;
  int worse = 0;
  double finest_step = 0.0;  // what the finest step gave is the next coarse one
  std::optional<VecX> finest;
  for (double h = step; h >= least && worse < kPatience; h *= 0.25) {
    const auto coarse = h == finest_step ? finest : difference(h);
    finest_step = 0.0;
    if (!coarse) continue;
    const auto middle = difference(0.5 * h);
    const auto fine = difference(0.25 * h);
    finest_step = 0.25 * h;
    finest = fine;
    if (!middle || !fine) continue;
    const VecX first = (4.0 * *middle - *coarse) / 3.0;
    const VecX second = (4.0 * *fine - *middle) / 3.0;
    VecX extrapolated = (16.0 * second - first) / 15.0;
    // Of truncation a fifteenth of this is left at most; of round-off, all of it may be.
    VecX difference_of_steps = second - first;
    const double error = difference_of_steps.norm() / 15.0;
    if (best && error >= least_error) {
      if (least_error <= kFair * std::max(best->value.norm(), scale)) ++worse;
      continue;
    }
    worse = 0;
    best = Derivative{std::move(extrapolated), std::move(difference_of_steps)};
    least_error = error;
    if (error <= kGood * std::max(best->value.norm(), scale)) break;
  }
  return best;
}

}  // namespace concord::compare
