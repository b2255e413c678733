#include "compare/quantities/align.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace concord::compare {

namespace {

Series make_series(const QuantityLayout& layout, std::size_t samples) {
  Series series;
  series.times.resize(samples);
  series.spin.assign(layout.model().bodies.size(), 0.0);
  for (MatX& values : series.values) {
    values.resize(static_cast<Eigen::Index>(layout.quantities().size()), static_cast<Eigen::Index>(samples));
  }
  return series;
}

void put(const QuantityLayout& layout, Series& series, std::size_t column, int who, const State& state,
         const Evaluation& evaluation) {
  const VecX values = layout.observe_to_judge(state, evaluation, kSolverNames[who]);
  series.values[who].col(static_cast<Eigen::Index>(column)) = values;
  for (std::size_t i = 0; i < series.spin.size(); ++i) {
    series.spin[i] = std::max(series.spin[i], state.bodies[i].omega.norm());
  }
}

}  // namespace

Series align(const QuantityLayout& layout, const std::array<const Trajectory*, 2>& trajectories, int samples) {
  for (int who = 0; who < 2; ++who) {
    const auto found = static_cast<int>(trajectories[who]->samples.size());
    if (found == samples) continue;
    throw IncompleteResult(fmt::format("{}: {} samples, {} were asked for", kSolverNames[who], found, samples));
  }
  Series series = make_series(layout, static_cast<std::size_t>(samples));
  const double end = samples > 0 ? std::abs(trajectories[0]->samples.back().state.t) : 0.0;
  for (std::size_t k = 0; k < series.times.size(); ++k) {
    const double t = trajectories[0]->samples[k].state.t;
    const double other = trajectories[1]->samples[k].state.t;
    if (!(std::abs(t - other) <= 1e-12 * end)) {
      throw IncompleteResult(
          fmt::format("sample {}: cartesian stands at t = {:.9g} s, relative at t = {:.9g} s; they must share a grid",
                      k, t, other));
    }
    series.times[k] = t;
    for (int who = 0; who < 2; ++who) {
      const Sample& sample = trajectories[who]->samples[k];
      put(layout, series, k, who, sample.state, sample.evaluation);
    }
  }
  return series;
}

Series align(const QuantityLayout& layout, const std::vector<SharedState>& states) {
  Series series = make_series(layout, states.size());
  for (std::size_t k = 0; k < states.size(); ++k) {
    series.times[k] = states[k].state.t;
    for (int who = 0; who < 2; ++who) put(layout, series, k, who, states[k].state, states[k].evaluations[who]);
  }
  return series;
}

}  // namespace concord::compare
