#include "compare/verdict/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <exception>
#include <utility>

#include "common/error.h"
#include "compare/attribution/attribution.h"
#include "compare/attribution/correction.h"
#include "compare/audit/balance.h"
#include "compare/audit/digits.h"
#include "compare/audit/energy.h"
#include "compare/audit/geometric_stiffness.h"
#include "compare/states/start_states.h"
#include "compare/states/states.h"
#include "compare/verdict/assemble_both.h"
#include "compare/verdict/blame.h"
#include "compare/verdict/judge.h"
#include "compare/verdict/redundant.h"
#include "compare/verdict/runs.h"
#include "compare/verdict/same_state.h"
#include "compare/verdict/third_words.h"
#include "compare/verdict/two_by_two.h"

namespace concord::compare {

RunOptions run_options(const Model& model, const VerifyOptions& options) {
  RunOptions run;
  run.until = options.until.value_or(model.run.until);
  run.rtol = options.rtol.value_or(model.run.rtol.value_or(model.is_flexible() ? kFlexibleRtol : kRigidRtol));
  run.samples = options.samples.value_or(model.run.samples.value_or(kSamples));
  return run;
}

std::string chosen_integrator(const Model& model, const Solver& solver, const std::string& asked) {
  const std::vector<std::string> known = solver.integrators();
  if (asked.empty()) return known.empty() ? "" : known.front();
  if (std::find(known.begin(), known.end(), asked) != known.end()) return asked;
  throw InputError({model.file, 0, 0}, fmt::format("the {} solver has no integrator '{}'; it has {}", solver.name(),
                                                   asked, fmt::join(known, ", ")));
}

namespace {

/// Perturbed states that are drawn to tell a body's terms apart: more than any family has terms, for a few modes.
constexpr int kStatesOfTerms = 300;

/// Rows of the run so that at least `states` of them exist and the rows asked for are among them.
int run_rows(int samples, int states) {
  const int parts = (states - 1 + samples - 1) / samples;
  return samples * std::max(1, parts);
}

std::vector<Check> checks_of(const VerifyOptions& options) {
  if (!options.integrates) return {Check::same_state};
  return {kChecks.begin(), kChecks.end()};
}

/// The same for each solver: what is found out about a model's beams is found out once.
std::array<Auditor, 2> two_of(const Auditor& auditor) { return {auditor, auditor}; }

/// The verification of one model by runs, check by check.
class Verification {
 public:
  Verification(const Model& model, Solver& cartesian, Solver& relative, const VerifyOptions& options)
      : model_(model),
        layout_(model),
        solvers_{&cartesian, &relative},
        options_(options),
        progress_(options.progress),
        judge_(layout_, checks_of(options), verdict_),
        same_state_(layout_, solvers_, options.seed, judge_, verdict_),
        runs_(layout_, solvers_, options.seed, judge_, progress_, verdict_),
        auditors_(two_of(Auditor(model))),
        redraws_{answers_within_roundoff(model, cartesian, options.seed),
                 answers_within_roundoff(model, relative, options.seed)} {}

  Verdict run() {
    check_needs(model_);
    describe_case();
    try {
      starts_ = assemble_both(model_, solvers_, options_.seed, options_.explains, verdict_);
      if (!verdict_.failures.empty()) {
        attribute_stop();
        return std::move(verdict_);
      }
      check_rank();
      make_rows(layout_, verdict_);
      options_.integrates ? verify_runs() : verify_states();
    } catch (const IncompleteResult& error) {
      verdict_.failures.emplace_back(error.what());
    } catch (const SolverError& error) {
      verdict_.failures.emplace_back(error.what());
    }
    attribute_stop();
    conclude();
    return std::move(verdict_);
  }

 private:
  void verify_runs() {
    RunPair pair = runs_.integrate_beside_refined(verdict_.run, options_.refines ? options_.makers : nullptr);
    std::vector<OwnedState> states = run_states(view(pair.trajectories), trajectory_states());
    if (states.empty()) {
      for (const Who who : kBothSolvers) states.push_back({starts_[index(who)], who, 0});
    }
    ask_in_same_states(states, trajectory_states());
    runs_.judge_same_run(pair, same_state_.weighed());
    hand_to_audit(view(pair.trajectories));
    if (options_.refines) runs_.refine(pair, same_state_.weighed());
    audit(pair);
    note_geometric_stiffness(view(pair.trajectories));
    keep(view(pair.trajectories));
    attribute();
    const bool explains = options_.explains && !(verdict_.findings.empty() && verdict_.failures.empty());
    if (options_.orders || explains) runs_.study_orders(options_.orders);
  }

  void verify_states() {
    const double longest = verdict_.run.until / asked_samples_;
    const std::vector<OwnedState> states = states_from_starts(model_, solvers_, starts_, longest);
    ask_in_same_states(states, static_cast<int>(states.size()));
    verdict_.run.samples = static_cast<int>(states.size()) / 2 - 1;
    for (const Who who : kBothSolvers) {
      const Trajectory own = samples_of(who, *solvers_[index(who)], states);
      judge_audit_of(who, &own);
      verdict_.trajectories[index(who)] = samples_of(Who::cartesian, *solvers_[index(who)], states);
    }
    if (!same_state_.weighed().states.empty()) {
      verdict_.unique = weigh_run(same_state_.weighed(), verdict_.run.samples + 1).mask;
    }
    attribute();
  }

  void describe_case() {
    judge_.describe(solvers_);
    verdict_.run = run_options(model_, options_);
    verdict_.integrates = options_.integrates;
    verdict_.seed = options_.seed;
    asked_samples_ = verdict_.run.samples;
    verdict_.energy_allowed = kEnergyPerTolerance * verdict_.run.rtol;
    verdict_.run.samples = run_rows(asked_samples_, trajectory_states());
    for (const Who who : kBothSolvers) {
      SolverSummary& summary = verdict_.solvers[index(who)];
      const Solver& solver = *solvers_[index(who)];
      summary.integrator = chosen_integrator(model_, solver, options_.integrators[index(who)]);
      summary.cut_joints = solver.cut_joints();
    }
    runs_.allow_switching({options_.integrators[0].empty(), options_.integrators[1].empty()});
  }

  /// What must hold at the start before anything else is asked. Uniqueness is compared state by state later.
  void check_rank() {
    for (const SolverSummary& solver : verdict_.solvers) {
      if (solver.rank.joints.size() != model_.joints.size()) {
        throw IncompleteResult(fmt::format("{}: the rank report has {} joints, the model {}", solver.name,
                                           solver.rank.joints.size(), model_.joints.size()));
      }
      if (!solver.rank.undecided) continue;
      verdict_.notes.push_back(fmt::format(
          "{}: the rank of the constraints is undecided at the start: relative singular values {:.1e} kept, {:.1e} "
          "dropped; what depends on it is not judged there",
          solver.name, solver.rank.smallest_kept, solver.rank.largest_dropped));
    }
  }

  [[nodiscard]] int trajectory_states() const { return options_.states.value_or(kTrajectoryStates); }
  [[nodiscard]] int random_states() const {
    return options_.states ? std::max(1, *options_.states / 4) : kRandomStates;
  }

  /// States that the solvers found, `needed` of them, and perturbed ones.
  void ask_in_same_states(const std::vector<OwnedState>& run, int needed) {
    progress_.begin("same state");
    SharedStates shared = share(solvers_, run);
    SharedStates random = share_random(model_, solvers_, run, options_.seed, random_states());
    // Beside a pose that is singular because of its drivers nothing may close: that is no reason of its own.
    if (!shared.singular.empty() && random.states.empty()) random.failures.clear();
    check_enough(shared, random, needed);
    verdict_.drawn_anew = random.drawn_anew;
    if (random.left_open > 0) {
      verdict_.notes.push_back(fmt::format("{} of {} perturbed states were left out: neither solver closes there",
                                           random.left_open, random_states()));
    }
    const std::vector<Measured> measured = same_state_.judge_states(std::move(shared), std::move(random));
    const WeighedStates& weighed = same_state_.weighed();
    if (weighed.states.empty()) return;
    for (const SharedState& one : weighed.states) {
      for (const Who who : kBothSolvers) {
        auditors_[index(who)].add(one.state, one.evaluations[index(who)], redraws_[index(who)]);
      }
    }
    judge_redundant(layout_, weighed, measured, verdict_);
    ask_third_opinion();
  }

  void ask_third_opinion() {
    if (options_.third == nullptr) return;
    progress_.begin(options_.third->name());
    verdict_.third = ask_third(layout_, *options_.third, same_state_.weighed().states, same_state_.weighed().budget());
    judge_third(model_, verdict_);
  }

  void check_enough(const SharedStates& shared, const SharedStates& random, int needed_of_run) {
    if (!shared.refusals.empty() || !random.refusals.empty()) return;  // a difference already
    // A run that stopped, or singular poses, are the reason why there are fewer.
    if (!verdict_.failures.empty() || !shared.singular.empty() || !random.singular.empty()) return;
    const auto require = [&](std::size_t found, int needed, const char* what) {
      if (found >= static_cast<std::size_t>(needed)) return;
      verdict_.failures.push_back(fmt::format("same state: {} {} states, need {}", found, what, needed));
    };
    require(shared.states.size(), needed_of_run, options_.integrates ? "trajectory" : "start");
    require(random.states.size() + static_cast<std::size_t>(random.left_open), random_states(), "random");
  }

  /// The third opinion on each solver alone: every sample of its own run and every state that was handed to it.
  void hand_to_audit(const std::array<const Trajectory*, 2>& trajectories) {
    progress_.begin("audit");
    for (const Who who : kBothSolvers) {
      const Trajectory* trajectory = trajectories[index(who)];
      if (trajectory == nullptr) continue;
      for (const Sample& sample : trajectory->samples) {
        auditors_[index(who)].add(sample.state, sample.evaluation, redraws_[index(who)]);
      }
    }
  }

  void audit(const RunPair& pair) {
    const std::array<const Trajectory*, 2> trajectories = view(pair.trajectories);
    for (const Who who : kBothSolvers) {
      const Trajectory* run = trajectories[index(who)];
      if (run != nullptr) judge_energy(who, audit_energy(model_, *run), pair);
      judge_audit_of(who, run);
    }
  }

  /// `trajectory`: the solver's own samples; null: none.
  void judge_audit_of(Who who, const Trajectory* trajectory) {
    judge_.judge_audit(who, auditors_[index(who)].report());
    if (trajectory == nullptr || trajectory->samples.empty()) return;
    judge_.judge_start(who, audit_kept_start(model_, *trajectory));
    judge_.judge_reported(who, audit_reported_coordinates(model_, *trajectory));
  }

  /// Whether an integrator that holds its steps no tighter leaves an error of energy: its run is the same at a looser
  /// tolerance, and at one that is looser still the error is clearly larger. One that stays is none of the steps.
  bool is_left_by_integrator(Who who, const EnergyReport& found, const RunPair& pair) {
    constexpr double kClearly = 3.0;
    if (runs_.stands(who) || !pair.is_complete()) return runs_.stands(who);
    const std::optional<RunPair> looser = runs_.try_looser(pair.run, "energy");
    if (!looser || !is_the_same_run(model_, *looser, pair, index(who))) return false;
    const std::optional<RunPair> loosest = runs_.try_looser(looser->run, "energy");
    return loosest && audit_energy(model_, *loosest->trajectories[index(who)]).relative() > kClearly * found.relative();
  }

  /// A run whose integrator holds its steps no tighter keeps no energy as far as is asked: no difference, but no
  /// answer.
  void judge_energy(Who who, const EnergyReport& found, const RunPair& pair) {
    SolverSummary& summary = verdict_.solvers[index(who)];
    summary.energy_error = found.relative();
    summary.energy = found;
    if (found.relative() <= verdict_.energy_allowed) return;
    std::string what = fmt::format("{} does not keep its energy: relative error {:.2e} at t = {:.4g} s, allowed {:.1e}",
                                   summary.name, found.relative(), found.t, verdict_.energy_allowed);
    if (is_left_by_integrator(who, found, pair)) {
      verdict_.failures.push_back(what + ": " + advice_on_integrator(pair, index(who)));
      return;
    }
    verdict_.findings.push_back(
        {std::move(what), fmt::format("same run: allowed is {:g} times the relative tolerance", kEnergyPerTolerance)});
  }

  void note_geometric_stiffness(const std::array<const Trajectory*, 2>& trajectories) {
    const Trajectory* run = trajectories[trajectories[0] != nullptr ? 0 : 1];
    if (run == nullptr) return;
    verdict_.geometric_stiffness = geometric_stiffness(model_, *run);
    for (std::string& note : notes_on(*verdict_.geometric_stiffness)) verdict_.notes.push_back(std::move(note));
  }

  /// Keeps the rows that were asked for.
  void keep(const std::array<const Trajectory*, 2>& trajectories) {
    const auto stride = static_cast<std::size_t>(verdict_.run.samples / asked_samples_);
    for (const Who who : kBothSolvers) {
      if (trajectories[index(who)] == nullptr) continue;
      Trajectory& kept = verdict_.trajectories[index(who)].emplace();
      kept.statistics = trajectories[index(who)]->statistics;
      const auto& samples = trajectories[index(who)]->samples;
      for (std::size_t k = 0; k < samples.size(); k += stride) kept.samples.push_back(samples[k]);
    }
    const Mask& of_run = runs_.weighed_run().mask;
    if (of_run.cols() == 0) return;
    Mask& unique = verdict_.unique.emplace(of_run.rows(), asked_samples_ + 1);
    for (int k = 0; k <= asked_samples_; ++k) unique.col(k) = of_run.col(k * static_cast<int>(stride));
  }

  /// A difference is told apart: whose it is, where, which term. Asks both solvers in more states, because families of
  /// terms can be told apart only where they differ.
  void attribute() {
    if (verdict_.findings.empty() || !options_.explains) return;
    progress_.begin("attribution");
    judge_.judge_rows();  // which checks are passed
    try {
      find_who_is_to_blame();
    } catch (const std::exception& error) {  // the difference stands without its explanation
      verdict_.notes.push_back(fmt::format("who is to blame was not found: {}", error.what()));
    }
    if (verdict_.attribution) verdict_.notes.push_back("to blame: " + describe(*verdict_.attribution));
    if (!verdict_.attribution && answers_hold(verdict_)) verdict_.notes.push_back(blame_of_run(verdict_));
    if (verdict_.two_by_two) verdict_.notes.push_back("the difference of " + describe(*verdict_.two_by_two));
  }

  void find_who_is_to_blame() {
    verdict_.two_by_two = two_by_two(model_, solvers_, verdict_);
    std::vector<OwnedState> run;
    for (const SharedState& one : same_state_.weighed().states) {
      if (one.row >= 0) run.push_back({one.state, Who::cartesian, one.row});
    }
    std::vector<SharedState> drawn;
    if (!run.empty()) drawn = share_random(model_, solvers_, run, options_.seed + 1, kStatesOfTerms).states;
    Evidence evidence{model_,
                      {auditors_[0].report(), auditors_[1].report()},
                      evaluated(same_state_.weighed().states),
                      evaluated(drawn),
                      ambiguous_joints(layout_, same_state_.weighed().mask),
                      {&starts_[0], &starts_[1]},
                      !verdict_.same_state.passed};
    if (!verdict_.rank_agrees) {
      evidence.constraints = ask_of_constraints(solvers_, states_of_ranks(model_, solvers_, run, options_.seed));
    }
    if (options_.makers == nullptr) {
      verdict_.attribution = find_cause(evidence);
    } else {
      verdict_.attribution = find_confirmed_cause(evidence, {options_.makers->cartesian, options_.makers->relative});
    }
  }

  /// A solver that stops where the other one goes on: what it says of its constraints may tell why.
  void attribute_stop() {
    const bool is_well = verdict_.failures.empty() && verdict_.findings.empty();
    if (is_well || verdict_.attribution || !options_.explains) return;
    try {
      std::vector<OwnedState> found = run_states(view(verdict_.trajectories), kStatesOfRanks);
      for (OwnedState& start : owned_starts(starts_)) found.push_back(std::move(start));
      verdict_.attribution = cause_of_stop(model_, solvers_, found, options_.seed);
    } catch (const std::exception& error) {  // the failure stands without its explanation
      verdict_.notes.push_back(fmt::format("who is to blame was not found: {}", error.what()));
    }
    if (verdict_.attribution) verdict_.notes.push_back("to blame: " + describe(*verdict_.attribution));
    const bool one_stops = verdict_.trajectories[0].has_value() != verdict_.trajectories[1].has_value();
    if (verdict_.attribution || !one_stops) return;
    judge_.judge_rows();  // which checks are passed
    if (answers_hold(verdict_)) verdict_.notes.push_back(blame_of_stop(verdict_));
  }

  void conclude() {
    judge_.judge_rows();
    if (!has_judged(verdict_)) {
      verdict_.failures.emplace_back(verdict_.total == 0 && model_.elements.empty()
                                         ? "no component was judged: no joint of this machine can carry anything, and "
                                           "no force acts on their speeds"
                                         : "no component was judged: none is unique, or none is resolved");
    } else if (verdict_.same_state.digits && !carries_something(verdict_)) {
      verdict_.failures.emplace_back(
          "no joint and no force element carries anything: agreement on zeros is no verdict; "
          "is 'gravity' missing?");
    } else if (verdict_.same_run.digits && !verdict_.same_run.carries) {
      verdict_.failures.emplace_back(
          "during the run no joint and no force element carries anything: agreement on zeros is no verdict");
    } else if (verdict_.total == 0 && model_.elements.empty()) {
      verdict_.notes.emplace_back("no joint constrains anything: judged are the forces on joint speeds");
    }
    compare::conclude(verdict_);
    require_passed_checks(verdict_);
  }

  const Model& model_;
  QuantityLayout layout_;
  std::array<Solver*, 2> solvers_;
  const VerifyOptions& options_;
  Verdict verdict_;
  CheckProgress progress_;
  Judge judge_;
  SameState same_state_;
  RunChecks runs_;
  std::array<Auditor, 2> auditors_;
  std::array<Redraw, 2> redraws_;
  int asked_samples_ = 0;
  std::array<State, 2> starts_;
};

}  // namespace

Verdict verify(const Model& model, Solver& cartesian, Solver& relative, const VerifyOptions& options) {
  return Verification(model, cartesian, relative, options).run();
}

}  // namespace concord::compare
