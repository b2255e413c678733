#include "compare/resolution/horizon.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "compare/audit/places.h"
#include "compare/quantities/motions.h"
#include "compare/states/chart.h"
#include "compare/states/draws.h"

namespace concord::compare {

namespace {

/// Digits that the errors of all steps together may cost beside those of one.
constexpr double kAllSteps = 2.0;
/// Growth is that of a small displacement: nothing is concluded from less than this.
constexpr double kLeastGrowth = 10.0;
/// How far a displaced start has gone from the run where the horizon is: little, so that its growth is that of a small
/// displacement [of the machine's length, or rad].
constexpr double kLargestParted = 1e-2;

double distance(const State& one, const State& other, double length) {
  double largest = 0.0;
  for (std::size_t i = 1; i < one.bodies.size(); ++i) {
    const BodyState& a = one.bodies[i];
    const BodyState& b = other.bodies[i];
    largest = std::max({largest, (a.r - b.r).norm() / length, angle_between(rotation_of(a.p), rotation_of(b.p))});
  }
  return largest;
}

/// A velocity of every body, by the machine's length, as if nothing held it.
VecX drawn_velocity(const Model& model, std::uint64_t seed) {
  Draws draws(seed);
  Eigen::Index rows = 0;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) rows += 6 + model.bodies[i].n_modes();
  VecX drawn = VecX::Zero(rows);
  Eigen::Index row = 0;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    for (Eigen::Index k = 0; k < 6; ++k) drawn(row + k) = (k < 3 ? model.length_scale() : 1.0) * draws.next();
    row += 6 + model.bodies[i].n_modes();
  }
  return drawn;
}

/// The part of a drawn displacement that the constraints permit, of the size asked for.
std::optional<State> displaced(const Model& model, Solver& solver, const State& start, double size,
                               std::uint64_t seed) {
  Chart chart(model, solver, start);
  const VecX permitted = chart.coordinates_of(drawn_velocity(model, seed));
  if (!(permitted.size() > 0 && permitted.norm() > 0.0)) return std::nullopt;
  return chart.at(size / permitted.norm() * permitted, chart.rates_at_origin());
}

}  // namespace

int Growth::samples_within(double allowed) const {
  return static_cast<int>(std::upper_bound(factors.begin(), factors.end(), allowed) - factors.begin());
}

std::optional<Growth> measure_growth(const Model& model, Solver& solver, const RunOptions& options,
                                     const Trajectory& run, double size, std::uint64_t seed) {
  try {
    RunOptions beside = options;
    beside.start = displaced(model, solver, run.samples.front().state, size, seed);
    if (!beside.start) return std::nullopt;
    const Trajectory other = solver.integrate(beside, {});
    const double length = model.length_scale();
    const double at_start = distance(run.samples.front().state, other.samples.front().state, length);
    if (!(at_start > 0.0)) return std::nullopt;
    Growth growth;
    for (std::size_t k = 0; k < run.samples.size(); ++k) {
      const double grown = distance(run.samples[k].state, other.samples[k].state, length) / at_start;
      growth.times.push_back(run.samples[k].state.t);
      growth.factors.push_back(std::max(grown, growth.factors.empty() ? 0.0 : growth.factors.back()));
    }
    return growth;
  } catch (const SolverError&) {
    return std::nullopt;  // it stops beside the run: nothing is known
  }
}

double allowed_growth(double rtol, double need) {
  return std::max(kLeastGrowth, std::pow(10.0, -std::log10(rtol) - need - kAllSteps));
}

std::optional<Horizon> find_horizon(const std::array<Growth, 2>& growths, double allowed) {
  Horizon horizon;
  horizon.growth = allowed;
  std::array<int, 2> samples{};
  for (std::size_t who = 0; who < 2; ++who) {
    samples[who] = growths[who].samples_within(allowed);
    if (samples[who] < 1 || samples[who] == static_cast<int>(growths[who].factors.size())) return std::nullopt;
    horizon.times[who] = growths[who].times[static_cast<std::size_t>(samples[who]) - 1];
  }
  horizon.samples = std::min(samples[0], samples[1]);
  const auto [shorter, longer] = std::minmax(horizon.times[0], horizon.times[1]);
  horizon.agree = longer - shorter <= kSameHorizon * longer || std::abs(samples[0] - samples[1]) <= 1;
  return horizon;
}

void Sensitivity::measure(const RunPair& pair, const std::array<std::string, 2>& integrators, double need) {
  is_measured_ = true;
  growths_.reset();
  const double size = kLargestParted / allowed_growth(pair.run.rtol, need);
  std::array<Growth, 2> found;
  for (std::size_t who = 0; who < 2; ++who) {
    RunOptions own = pair.run;
    own.integrator = integrators[who];
    auto growth = measure_growth(model_, *solvers_[who], own, *pair.trajectories[who], size, seed_);
    if (!growth) return;
    found[who] = std::move(*growth);
  }
  growths_ = std::move(found);
}

std::optional<Horizon> Sensitivity::horizon(double rtol, double need) const {
  if (!growths_) return std::nullopt;
  return find_horizon(*growths_, allowed_growth(rtol, need));
}

std::string disagreement_on(const Horizon& horizon, Check check) {
  return fmt::format(
      "{}: nearby motions part too far to be compared from t = {:.4g} s on by the cartesian solver alone, from {:.4g} "
      "s by the relative: the solvers do not agree on the horizon",
      name_of(check), horizon.times[0], horizon.times[1]);
}

std::string note_on(const Horizon& horizon, Check check, const RunOptions& run, double need) {
  return fmt::format(
      "{}: judged up to t = {:.4g} s of {:g} s: by then motions from nearby starts have parted by a factor of {:.0e} "
      "(by the cartesian solver alone at {:.4g} s, the relative {:.4g} s), and beyond no integration at rtol {:g} "
      "keeps {:g} digits; states are judged over the whole run",
      name_of(check), std::min(horizon.times[0], horizon.times[1]), run.until, horizon.growth, horizon.times[0],
      horizon.times[1], run.rtol, need);
}

}  // namespace concord::compare
