#include "compare/resolution/run_pairs.h"

#include <fmt/format.h>

namespace concord::compare {

RunPair first_samples(const QuantityLayout& layout, const RunPair& pair, int samples) {
  RunPair first{pair.run, {}, {}, {}, {}, pair.integrators};
  for (std::size_t who = 0; who < 2; ++who) {
    Trajectory& run = first.trajectories[who].emplace();
    const std::vector<Sample>& all = pair.trajectories[who]->samples;
    run.samples.assign(all.begin(), all.begin() + samples);
  }
  first.series = align(layout, {&*first.trajectories[0], &*first.trajectories[1]}, samples);
  return first;
}

std::array<double, 2> own_motion_digits(const Model& model, const RunPair& looser, const RunPair& tighter) {
  std::array<double, 2> digits{};
  for (std::size_t who = 0; who < 2; ++who) {
    digits[who] = compare_motions(model, {&*looser.trajectories[who], &*tighter.trajectories[who]}).digits;
  }
  return digits;
}

namespace {

/// Runs whose motions agree to so many digits are the same.
constexpr double kTheSame = 14.0;

}  // namespace

bool is_the_same_run(const Model& model, const RunPair& looser, const RunPair& tighter, std::size_t who) {
  return own_motion_digits(model, looser, tighter)[who] >= kTheSame;
}

std::optional<std::size_t> run_that_stands(const Model& model, const RunPair& looser, const RunPair& tighter) {
  if (!looser.is_complete() || !tighter.is_complete()) return std::nullopt;
  if (looser.run.samples != tighter.run.samples) return std::nullopt;
  const std::array<double, 2> digits = own_motion_digits(model, looser, tighter);
  const std::size_t nearer = digits[0] >= digits[1] ? 0 : 1;
  return digits[nearer] >= kTheSame ? std::optional(nearer) : std::nullopt;
}

std::string advice_on_integrator(const RunPair& pair, std::size_t who) {
  return fmt::format("{} holds its steps no tighter, another integrator (--{}-integrator) may",
                     pair.integrators[who].empty() ? "its integrator" : pair.integrators[who],
                     who == 0 ? "cartesian" : "relative");
}

std::string advice_on_standing(const RunPair& pair, std::size_t who) {
  return fmt::format("; the {} run is the same at rtol {:g} as at a looser one: {}",
                     who == 0 ? "cartesian" : "relative", pair.run.rtol, advice_on_integrator(pair, who));
}

}  // namespace concord::compare
