#include "compare/analyses/linearize.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/decompositions.h"
#include "common/error.h"
#include "compare/analyses/deviations.h"
#include "compare/analyses/eigenmodes.h"
#include "compare/analyses/kinematics.h"
#include "compare/equilibrium/acceleration_scale.h"
#include "compare/equilibrium/equilibrium.h"
#include "compare/equilibrium/stiffness.h"
#include "compare/verdict/chart.h"
#include "compare/verdict/motion_names.h"
#include "compare/verdict/prediction.h"

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

Steadiness steadiness_of(const Model& model, Solver& solver, const Linearization& found) {
  constexpr double kAccelerates = 1e-8;
  constexpr double kMovesBy = 1e-4;  // rad, or of the length: the prediction errs by its square
  Steadiness steadiness;
  steadiness.accelerates = found.unsteadiness > kAccelerates;
  if (found.rate <= found.resolution) return steadiness;
  const Sample now{found.state, solver.evaluate(found.state), 0.0};
  const auto later = solver.close(predict(model, now, kMovesBy / found.rate));
  if (!later) return steadiness;
  const Linearization there = linearize(model, solver, *later, found.axes);
  if (there.directions.cols() != found.directions.cols()) return steadiness;
  const MatX to_here = least_squares(found.directions, there.directions);
  const MatX from_here = least_squares(there.directions, found.directions);
  double fastest = found.rate;
  for (const Mode& mode : found.modes) fastest = std::max(fastest, std::abs(mode.eigenvalue));
  steadiness.change = std::max((to_here * there.A * from_here - found.A).norm() / (fastest * fastest),
                               (to_here * there.B * from_here - found.B).norm() / fastest) /
                      kMovesBy;
  return steadiness;
}

std::optional<TurningLinearization> linearize_in_steady_axes(const Model& model, Solver& solver, const State& state) {
  std::vector<TurningAxes> candidates;
  if (const auto of_balls = Deviations(model, solver, state).steady_axes()) {
    candidates.assign(2, *of_balls);
    candidates.back().carry_places = true;
  }
  if (const auto of_bodies = axes_of_fastest_body(state)) candidates.push_back(*of_bodies);
  std::optional<TurningLinearization> nearly;
  for (const TurningAxes& axes : candidates) {
    TurningLinearization turning{linearize(model, solver, state, axes), {}};
    turning.steadiness = steadiness_of(model, solver, turning.found);
    if (turning.steadiness.is_steady()) return turning;
    if (!nearly && turning.steadiness.has_constant_matrices()) nearly = std::move(turning);
  }
  return nearly;
}

}  // namespace concord::compare::analyses
