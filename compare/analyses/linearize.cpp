#include "compare/analyses/linearize.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/decompositions.h"
#include "common/error.h"
#include "common/products.h"
#include "compare/analyses/deviations.h"
#include "compare/analyses/eigenmodes.h"
#include "compare/analyses/kinematics.h"
#include "compare/equilibrium/acceleration_scale.h"
#include "compare/equilibrium/equilibrium.h"
#include "compare/equilibrium/stiffness.h"
#include "compare/states/chart.h"
#include "compare/states/motion_names.h"
#include "compare/states/states.h"

namespace concord::compare::analyses {

namespace {

constexpr double kRateStep = 0.02;  // of the machine's largest rate
constexpr double kLeastRateStep = 1e-7;
constexpr double kNoDamping = 1e-11;  // of the largest frequency

struct Damping {
  MatX B;
  MatX error;
};

/// Derivatives of the accelerations of deviations with respect to their rates.
Damping damping_matrix(Deviations& deviations, const Solver& solver, double rate) {
  const Chart& chart = deviations.chart();
  const VecX none = VecX::Zero(chart.n());
  Damping damping{MatX(chart.n(), chart.n()), MatX(chart.n(), chart.n())};
  for (int k = 0; k < chart.n(); ++k) {
    const auto along = [&](double step) { return deviations.accelerations_at(none, step * VecX::Unit(chart.n(), k)); };
    const auto column = derivative_at_zero(along, kRateStep * rate, kLeastRateStep * rate, rate);
    if (!column) {
      throw SingularPose(fmt::format(
          "{}: at t = {:.6g} s no closed states with another speed along {} are found: is the pose singular?",
          solver.name(), chart.origin().t, chart.describe(VecX::Unit(chart.n(), k))));
    }
    damping.B.col(k) = column->value;
    damping.error.col(k) = column->error;
  }
  return damping;
}

}  // namespace

double Mode::frequency() const { return std::abs(eigenvalue) / (2.0 * std::numbers::pi); }

double Mode::damping_ratio() const { return is_free ? 0.0 : 0.0 - eigenvalue.real() / std::abs(eigenvalue); }

namespace {

/// Accelerations that velocities and forces cause [1/s2].
AccelerationScale scale_of_accelerations(const Model& model, Solver& solver, const Chart& chart, double speed) {
  const State& state = chart.origin();
  AccelerationScale scale = acceleration_scale(model, chart, state, solver.evaluate(state));
  scale.reference = std::max(scale.reference, speed * speed);
  return scale;
}

/// The rate at which derivatives with respect to rates are taken: the machine's largest, else that of its motions in
/// which modes follow statically, else that of its springs and of its modes. If it has none, no force depends on a time
/// of its own, and any will do.
double typical_rate(const AccelerationScale& scale, const StiffnessSplit& split, const MatX& A) {
  const double reference = scale.reference > scale.unresolved() ? scale.reference : 0.0;
  const double stiffest = split.largest() > split.least() ? split.largest() : 0.0;
  for (const double square : {std::max(reference, stiffest), scale.terms, A.norm()}) {
    if (square > 0.0) return std::sqrt(square);
  }
  return 1.0;
}

void add_free_modes(const Model& model, const Chart& chart, const MatX& directions, std::vector<Mode>& modes) {
  if (directions.cols() == 0) return;
  MatX motions(chart.basis().rows(), directions.cols());
  for (Eigen::Index k = 0; k < directions.cols(); ++k) motions.col(k) = chart.velocities(directions.col(k));
  motions = separate_motions(model, chart.origin(), std::move(motions));
  for (const auto& motion : motions.colwise()) {
    Mode mode;
    mode.is_free = true;
    set_shape(chart, chart.coordinates_of(motion).cast<std::complex<double>>(), mode);
    mode.motion = describe_motion(model, chart.origin(), motion);
    modes.push_back(std::move(mode));
  }
}

/// By |lambda|, then by its real part.
bool comes_first(const Mode& a, const Mode& b) {
  const double sizes[] = {std::abs(a.eigenvalue), std::abs(b.eigenvalue)};
  if (std::abs(sizes[0] - sizes[1]) > 1e-9 * std::max(sizes[0], sizes[1])) return sizes[0] < sizes[1];
  return a.eigenvalue.real() < b.eigenvalue.real();
}

}  // namespace

Linearization linearize(const Model& model, Solver& solver, const State& state, const TurningAxes& axes) {
  Linearization result;
  result.state = state;
  result.axes = axes;
  Deviations deviations(model, solver, state, axes);
  const Chart& chart = deviations.chart();
  if (chart.n() == 0) return result;
  const VecX none = VecX::Zero(chart.n());
  const AccelerationScale scale = scale_of_accelerations(model, solver, chart, deviations.speed());
  result.directions = deviations.directions();
  result.rate = deviations.speed();
  const double acceleration = deviations.accelerations().norm();
  if (acceleration > scale.unresolved()) result.unsteadiness = acceleration / scale.resolved_reference();
  const auto held = [&](const VecX& delta) { return deviations.accelerations_at(delta, none); };
  const Stiffness stiffness = stiffness_matrix(chart, solver, held, scale);
  if (const std::string kink = kink_at_origin(chart, held, stiffness.J, scale); !kink.empty()) {
    throw SolverError(fmt::format(
        "{}: at t = {:.6g} s there is no linearization: a force has a kink in this very state, as a tire has "
        "that just touches its road, so that {} meets another stiffness in one sense than in the other; "
        "start a little beside it, or in the equilibrium",
        solver.name(), state.t, kink));
  }
  result.A = stiffness.J;
  const StiffnessSplit split(chart, stiffness, scale, none);
  const double rate = typical_rate(scale, split, result.A);
  const double frequency = std::max(std::sqrt(result.A.norm()), rate);
  Damping damping = damping_matrix(deviations, solver, rate);
  result.B = damping.B;
  const ModeSearch search{chart, scale, result.B.norm() <= kNoDamping * frequency, frequency};
  const MotionMatrices matrices{result.A, result.B};
  const MotionMatrices errors{stiffness.error, std::move(damping.error)};
  result.A_error = errors.A;
  result.B_error = errors.B;
  FoundModes found = find_modes(search, matrices, errors);
  measure_mode_resolution(search, matrices, errors, found.moving);
  result.free_range = weigh_decisions_on_free(search, matrices, errors, found);
  split_unresolved_pairs(found.moving);
  result.resolution = found.resolution;
  result.slowest = found.slowest;
  result.modes = std::move(found.moving);
  for (Mode& mode : result.modes) mode.motion = describe_motion(model, chart.origin(), mode.shape.real());
  add_free_modes(model, chart, found.free_places, result.modes);
  add_free_modes(model, chart, found.free_rates, result.modes);
  std::stable_sort(result.modes.begin(), result.modes.end(), comes_first);
  return result;
}

namespace {

/// The state h seconds on: velocities by the accelerations half way there.
std::optional<State> moved_on(const Model& model, Solver& solver, const State& state, double h) {
  const auto half_way = solver.close(predict(model, {state, solver.evaluate(state), 0.0}, 0.5 * h));
  if (!half_way) return std::nullopt;
  const auto evaluation = evaluation_unless_refused(solver, *half_way);
  if (!evaluation) return std::nullopt;
  const auto later = solver.close(predict(model, {state, *evaluation, 0.0}, h));
  return later && accepts(solver, *later) ? later : std::nullopt;
}

/// [0 top; A B], of first order.
MatX first_order(const MatX& A, const MatX& B, double top) {
  const Eigen::Index n = A.rows();
  MatX S = MatX::Zero(2 * n, 2 * n);
  S.topRightCorner(n, n) = top * MatX::Identity(n, n);
  S.bottomLeftCorner(n, n) = A;
  S.bottomRightCorner(n, n) = B;
  return S;
}

/// How fast changes dA, dB within dt couple modes to each other and to themselves, for each two as a part of the square
/// of the faster one's rate; beyond what differences leave open, and of modes that are told from zero. A pair that is
/// nearly one, as of a body that drifts in axes that turn, feels every change many times over: by so much less is
/// asked.
double coupling_of_modes(const Linearization& found, const MatX& dA, const MatX& dB, double dt) {
  constexpr double kTimesOpen = 4.0;
  constexpr double kRoundOff = 1e-11;
  const MatX S = first_order(found.A, found.B, 1.0);
  const GeneralEigenpairs modes = eigenpairs(S);
  const Eigen::MatrixXcd inverse = inverse_of(modes.vectors);
  if (!inverse.allFinite()) return 0.0;
  const Eigen::MatrixXcd pulled = inverse * first_order(dA, dB, 0.0);
  const MatX coupling = (pulled * modes.vectors).cwiseAbs();
  const MatX errors =
      kTimesOpen * first_order(found.A_error, found.B_error, 0.0) + kRoundOff * first_order(found.A, found.B, 0.0);
  const MatX open = product(inverse.cwiseAbs(), product(errors.cwiseAbs(), modes.vectors.cwiseAbs()));
  const double slowest = std::max(found.resolution, found.slowest);
  double largest = 0.0;
  const Eigen::Index n = found.A.rows();
  for (Eigen::Index j = 0; j < coupling.rows(); ++j) {
    const double feels = std::max(1.0, inverse.row(j).tail(n).norm() * modes.vectors.col(j).tail(n).norm());
    for (Eigen::Index k = 0; k < coupling.cols(); ++k) {
      const double rates[] = {std::abs(modes.values(j)), std::abs(modes.values(k))};
      if (!(std::min(rates[0], rates[1]) > slowest)) continue;
      const double faster = std::max(rates[0], rates[1]);
      largest = std::max(largest, (coupling(j, k) - open(j, k)) / (dt * faster * faster * feels));
    }
  }
  return largest;
}

constexpr double kMovesBy = 0.01;  // rad, or of the length
constexpr double kConstant = 1e-3;

/// By how much permitted directions turn from one set to another, as the sine of an angle.
double turned_between(const MatX& directions, const MatX& others) {
  if (others.cols() != directions.cols()) return HUGE_VAL;
  const MatX here = orthonormal_columns(directions);
  const MatX there = orthonormal_columns(others);
  return outside_span(here, there).norm();
}

/// Nothing where there is none: at a kink of a force, in a singular pose.
std::optional<Linearization> linearize_if_possible(const Model& model, Solver& solver, const State& state,
                                                   const TurningAxes& axes) {
  try {
    return linearize(model, solver, state, axes);
  } catch (const SolverError&) {
    return std::nullopt;
  }
}

/// See Steadiness::change.
double change_along_motion(const Model& model, Solver& solver, const Linearization& found) {
  const double dt = kMovesBy / found.rate;
  const auto later = moved_on(model, solver, found.state, dt);
  const auto at_later = later ? linearize_if_possible(model, solver, *later, found.axes) : std::nullopt;
  if (!at_later) return HUGE_VAL;
  const Linearization& there = *at_later;
  const double turned = turned_between(found.directions, there.directions);
  if (turned == HUGE_VAL) return turned;
  const MatX to_here = least_squares(found.directions, there.directions);
  const MatX from_here = least_squares(there.directions, found.directions);
  const MatX dA = product(to_here, product(there.A, from_here)) - found.A;
  const MatX dB = product(to_here, product(there.B, from_here)) - found.B;
  double fastest = found.rate;
  for (const Mode& mode : found.modes) fastest = std::max(fastest, std::abs(mode.eigenvalue));
  return std::max(std::max({dA.norm() / (fastest * fastest), dB.norm() / fastest, turned}) / kMovesBy,
                  coupling_of_modes(found, dA, dB, dt));
}

/// Whether permitted directions stand still in axes that turn, which costs next to nothing to see.
bool directions_stand_still(const Model& model, Solver& solver, const Deviations& deviations, const TurningAxes& axes) {
  const State& state = deviations.chart().origin();
  const auto later = moved_on(model, solver, state, kMovesBy / deviations.speed());
  if (!later) return false;
  try {
    const Deviations there(model, solver, *later, axes);
    return turned_between(deviations.directions(), there.directions()) <= kConstant * kMovesBy;
  } catch (const SolverError&) {  // as in a singular pose
    return false;
  }
}

}  // namespace

Steadiness steadiness_of(const Model& model, Solver& solver, const Linearization& found) {
  constexpr double kAccelerates = 1e-8;
  Steadiness steadiness;
  steadiness.accelerates = found.unsteadiness > kAccelerates;
  if (!steadiness.accelerates && found.rate > found.resolution) {
    steadiness.change = change_along_motion(model, solver, found);
  }
  return steadiness;
}

bool has_constant_matrices(const Model& model, Solver& solver, const Linearization& found) {
  return found.rate <= found.resolution || change_along_motion(model, solver, found) <= kConstant;
}

std::optional<TurningLinearization> linearize_in_steady_axes(const Model& model, Solver& solver, const State& state) {
  constexpr double kALittle = 0.01;
  std::vector<TurningAxes> candidates;
  if (const auto of_balls = Deviations(model, solver, state).steady_axes()) {
    candidates.assign(2, *of_balls);
    candidates.back().carry_places = true;
  }
  const std::vector<TurningAxes> of_bodies = axes_of_bodies(model, state);
  candidates.insert(candidates.end(), of_bodies.begin(), of_bodies.end());
  std::optional<TurningLinearization> nearly;
  for (const TurningAxes& axes : candidates) {
    const Deviations deviations(model, solver, state, axes);
    if (!(deviations.speed() > 0.0) || !directions_stand_still(model, solver, deviations, axes)) continue;
    std::optional<Linearization> found = linearize_if_possible(model, solver, state, axes);
    if (!found) continue;
    const Steadiness steadiness = steadiness_of(model, solver, *found);
    if (steadiness.is_steady()) return TurningLinearization{std::move(*found), true};
    const bool may_be_constant = !nearly && steadiness.accelerates && found->unsteadiness <= kALittle;
    if (may_be_constant && has_constant_matrices(model, solver, *found)) {
      nearly = TurningLinearization{std::move(*found), false};
    }
  }
  return nearly;
}

}  // namespace concord::compare::analyses
