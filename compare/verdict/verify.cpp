#include "compare/verdict/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <future>
#include <limits>
#include <mutex>
#include <utility>

#include "compare/attribution/attribution.h"
#include "compare/audit/balance.h"
#include "compare/audit/digits.h"
#include "compare/audit/geometric_stiffness.h"
#include "compare/verdict/agreement.h"
#include "compare/verdict/convergence.h"
#include "compare/verdict/findings.h"
#include "compare/verdict/horizon.h"
#include "compare/verdict/refinement.h"
#include "compare/verdict/states.h"
#include "compare/verdict/sums.h"
#include "compare/verdict/third_words.h"
#include "compare/verdict/two_by_two.h"
#include "compare/verdict/weighed_states.h"

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

constexpr std::array kWho{Who::cartesian, Who::relative};
/// Perturbed states that are drawn to tell a body's terms apart: more than any family has terms, for a few modes.
constexpr int kStatesOfTerms = 300;

/// Rows of the run so that at least `states` of them exist and the rows asked for are among them.
int run_rows(int samples, int states) {
  const int parts = (states - 1 + samples - 1) / samples;
  return samples * std::max(1, parts);
}

using Trajectories = std::array<std::optional<Trajectory>, 2>;

std::array<const Trajectory*, 2> view(const Trajectories& trajectories) {
  std::array<const Trajectory*, 2> both{};
  for (const Who who : kWho) {
    if (trajectories[index(who)]) both[index(who)] = &*trajectories[index(who)];
  }
  return both;
}

/// The verification of one model, rung by rung.
class Verification {
 public:
  Verification(const Model& model, Solver& cartesian, Solver& relative, const VerifyOptions& options)
      : model_(model),
        layout_(model),
        solvers_{&cartesian, &relative},
        options_(options),
        sensitivity_(model, solvers_, options.seed),
        auditors_{Auditor(model), Auditor(model)} {}

  Verdict run() {
    check_needs(model_);
    describe_case();
    try {
      if (!assemble()) return std::move(verdict_);
      check_rank();
      make_rows(layout_, verdict_);
      RunPair pair{verdict_.run, integrate(verdict_.run, name_of(Rung::same_run)), {}, {}, {}};
      same_state(pair.trajectories);
      same_run(pair);
      if (options_.refines) refine(pair);
      audit(pair.trajectories);
      tell_geometric_stiffness(pair.trajectories);
      keep(pair.trajectories);
      attribute();
    } catch (const IncompleteResult& error) {
      verdict_.failures.emplace_back(error.what());
    } catch (const SolverError& error) {
      verdict_.failures.emplace_back(error.what());
    }
    conclude();
    return std::move(verdict_);
  }

 private:
  void describe_case() {
    verdict_.name = model_.name;
    verdict_.bodies = static_cast<int>(model_.bodies.size()) - 1;
    verdict_.joints = static_cast<int>(model_.joints.size());
    verdict_.loops = verdict_.joints - verdict_.bodies;
    for (const Body& body : model_.bodies) verdict_.modes += body.n_modes();
    verdict_.run = run_options(model_, options_);
    verdict_.seed = options_.seed;
    asked_samples_ = verdict_.run.samples;
    asked_rtol_ = verdict_.run.rtol;
    verdict_.run.samples = run_rows(asked_samples_, trajectory_states());
    verdict_.need = default_needs(model_);
    for (const Who who : kWho) {
      SolverSummary& summary = verdict_.solvers[index(who)];
      const Solver& solver = *solvers_[index(who)];
      summary.name = solver.name();
      summary.integrator = chosen_integrator(model_, solver, options_.integrators[index(who)]);
      summary.cut_joints = solver.cut_joints();
    }
  }

  bool assemble() {
    for (const Who who : kWho) {
      Solver& solver = *solvers_[index(who)];
      try {
        starts_[index(who)] = solver.assemble();
        verdict_.solvers[index(who)].rank = solver.rank(starts_[index(who)]);
        verdict_.solvers[index(who)].cut_joints = solver.cut_joints();
      } catch (const SolverError& error) {
        verdict_.failures.emplace_back(error.what());
      }
    }
    return verdict_.failures.empty();
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

  [[nodiscard]] std::array<std::string, 2> integrators() const {
    return {verdict_.solvers[0].integrator, verdict_.solvers[1].integrator};
  }

  [[nodiscard]] int trajectory_states() const { return options_.states.value_or(kTrajectoryStates); }
  [[nodiscard]] int random_states() const {
    return options_.states ? std::max(1, *options_.states / 4) : kRandomStates;
  }

  void report(std::string_view rung) {
    done_ = {};
    if (options_.progress) options_.progress(rung, done_);
  }

  void report(std::string_view rung, Who who, double done) {
    if (!options_.progress) return;
    const std::lock_guard lock(progress_guard_);
    done_[index(who)] = done;
    options_.progress(rung, done_);
  }

  /// Both solvers at once, each in its own thread; neither sees the other.
  Trajectories integrate(const RunOptions& run, std::string_view what) {
    report(what);
    std::array<std::future<Trajectory>, 2> running;
    for (const Who who : kWho) {
      running[index(who)] = std::async(std::launch::async, [this, run, what, who] {
        RunOptions own = run;
        own.integrator = verdict_.solvers[index(who)].integrator;
        return solvers_[index(who)]->integrate(own, [&](double t) { report(what, who, t / own.until); });
      });
    }
    Trajectories trajectories;
    for (const Who who : kWho) {
      try {
        trajectories[index(who)] = running[index(who)].get();
      } catch (const SolverError& error) {
        verdict_.failures.push_back(fmt::format("{}: {}", what, error.what()));
      }
    }
    return trajectories;
  }

  void same_state(const Trajectories& trajectories) {
    report("same state");
    std::vector<OwnedState> run = run_states(view(trajectories), trajectory_states());
    if (run.empty()) {
      for (const Who who : kWho) run.push_back({starts_[index(who)], who, 0});
    }
    SharedStates shared = share(solvers_, run);
    SharedStates random = share_random(model_, solvers_, run, options_.seed, random_states());
    // Beside a pose that is singular because of its drivers nothing may close: that is no reason of its own.
    if (!shared.singular.empty() && random.states.empty()) random.failures.clear();
    check_enough(shared, random);
    for (const SharedStates* part : {&shared, &random}) note_failures(*part);
    verdict_.drawn_anew = random.drawn_anew;
    if (random.left_open > 0) {
      verdict_.notes.push_back(fmt::format("{} of {} perturbed states were left out: neither solver closes there",
                                           random.left_open, random_states()));
    }
    std::move(random.states.begin(), random.states.end(), std::back_inserter(shared.states));
    weighed_ = weigh(layout_, solvers_, std::move(shared.states), options_.seed);
    if (is_singular_throughout(shared)) forget_neighbours();
    take_uniqueness();
    for (const SharedStates* part : {&shared, &random}) note_refusals(part->refusals);
    verdict_.same_state.samples = static_cast<int>(weighed_.states.size());
    if (weighed_.states.empty()) return;
    const std::vector<Measured> measured = measure(layout_, weighed_.series, weighed_.budget());
    record(layout_, measured, Rung::same_state, verdict_);
    note_singular_states();
    judge_series(weighed_.series, measured, Rung::same_state);
    note_resolution();
    for (const SharedState& one : weighed_.states) {
      for (const Who who : kWho) auditors_[index(who)].add(one.state, one.evaluations[index(who)]);
    }
    verdict_.pair_sums = compare_pair_sums(layout_, weighed_.states, measured, weighed_.budget());
    for (const PairSum& pair : verdict_.pair_sums) judge_pair_sum(pair);
    ask_third_opinion();
  }

  void ask_third_opinion() {
    if (options_.third == nullptr) return;
    report(options_.third->name());
    verdict_.third = ask_third(layout_, *options_.third, weighed_.states, weighed_.budget());
    judge_third(model_, verdict_);
  }

  void judge_pair_sum(const PairSum& pair) {
    const double need = verdict_.need.same_state;
    if (pair.unexplained_digits >= need || !verdict_.findings.empty()) return;
    verdict_.findings.push_back(
        {fmt::format("sum of {}: {} digits (need {:.1f})", pair.what, format_digits(pair.digits), need),
         "same state: the joints' total on the body differs"});
  }

  /// Whether a solver calls every state of the run a singular pose, or finds a lower rank in all of them.
  bool is_singular_throughout(const SharedStates& shared) const {
    bool some = !shared.singular.empty();
    for (std::size_t k = 0; k < weighed_.states.size(); ++k) {
      if (weighed_.states[k].row < 0) continue;  // perturbed
      if (weighed_.singular[k].empty()) return false;
      some = true;
    }
    return some;
  }

  /// A loop that is locked in a singular pose closes beside it only by the root of round-off: such states, though of
  /// full rank, tell nothing.
  void forget_neighbours() {
    weighed_.mask.setConstant(false);
    weighed_.findings.clear();
  }

  /// Both solvers said in every state what is unique there.
  void take_uniqueness() {
    if (!weighed_.dropped.empty()) verdict_.failures.push_back(weighed_.dropped);
    verdict_.rank_agrees = weighed_.findings.empty() && !weighed_.reports.empty();
    std::move(weighed_.findings.begin(), weighed_.findings.end(), std::back_inserter(verdict_.findings));
    note_singular_start();
  }

  /// Nothing is judged in a singular pose.
  void note_singular_states() {
    const std::vector<std::string>& singular = weighed_.singular;
    const auto is_singular = [](const std::string& why) { return !why.empty(); };
    const auto first = std::find_if(singular.begin(), singular.end(), is_singular);
    if (first == singular.end()) return;
    verdict_.singular_states += static_cast<int>(std::count_if(first, singular.end(), is_singular));
    verdict_.failures.push_back(*first);
  }

  void note_resolution() {
    if (weighed_.resolution.unknown_states > 0) {
      verdict_.notes.push_back(fmt::format(
          "resolution unknown in {} of {} states: fewer than {} of {} draws within round-off were accepted; "
          "judged there by the need alone",
          weighed_.resolution.unknown_states, weighed_.states.size(), kFewestDraws, kDraws));
    }
    if (weighed_.resolution.closings_left_out > 0) {
      verdict_.notes.push_back(fmt::format("resolution: {} closings found another state and were left out",
                                           weighed_.resolution.closings_left_out));
    }
  }

  void check_enough(const SharedStates& shared, const SharedStates& random) {
    if (!shared.refusals.empty() || !random.refusals.empty()) return;  // a difference already
    // A run that stopped, or singular poses, are the reason why there are fewer.
    if (!verdict_.failures.empty() || !shared.singular.empty() || !random.singular.empty()) return;
    const auto require = [&](std::size_t found, int needed, const char* what) {
      if (found >= static_cast<std::size_t>(needed)) return;
      verdict_.failures.push_back(fmt::format("same state: {} {} states, need {}", found, what, needed));
    };
    require(shared.states.size(), trajectory_states(), "trajectory");
    require(random.states.size() + static_cast<std::size_t>(random.left_open), random_states(), "random");
  }

  void note_failures(const SharedStates& shared) {
    verdict_.singular_states += static_cast<int>(shared.singular.size());
    if (!shared.singular.empty()) verdict_.failures.push_back(shared.singular.front());
    if (!shared.failures.empty()) verdict_.failures.push_back(shared.failures.front());
  }

  /// In a singular pose the solvers need not close alike: such a state is counted, and no difference.
  void note_refusals(const std::vector<RefusedState>& refused) {
    const std::array<int, 2> general = general_ranks(weighed_.reports);
    std::vector<std::string> elsewhere;
    for (const RefusedState& one : refused) {
      if (rank_in(one.state) < general[index(one.state.owner)]) {
        ++verdict_.singular_states;
        verdict_.failures.push_back(fmt::format("the pose is singular: {}", one.why));
      } else {
        elsewhere.push_back(one.why);
      }
    }
    if (elsewhere.empty()) return;
    verdict_.findings.push_back(
        {elsewhere.front(),
         fmt::format("same state: {} such states: the closures differ; hold what the joint forbids against what it "
                     "permits",
                     elsewhere.size())});
  }

  /// The rank that a state's owner finds there; a number above all ranks where it finds none.
  int rank_in(const OwnedState& state) const {
    try {
      return solvers_[index(state.owner)]->rank(state.state).rank;
    } catch (const SolverError&) {
      return std::numeric_limits<int>::max();
    }
  }

  /// A rank at the start that is lower than in other states is a singular pose.
  void note_singular_start() {
    const std::array<int, 2> general = general_ranks(weighed_.reports);
    for (const Who who : kWho) {
      const int rank = verdict_.solvers[index(who)].rank.rank;
      if (rank >= general[index(who)]) continue;
      verdict_.notes.push_back(
          fmt::format("{}: the start pose is singular: rank {} there, {} at a neighbouring pose; motion may branch",
                      solvers_[index(who)]->name(), rank, general[index(who)]));
    }
  }

  void judge_series(const Series& series, const std::vector<Measured>& measured, Rung rung) {
    std::vector<Finding> found = find_differences(layout_, series, measured, verdict_, rung, known_);
    std::move(found.begin(), found.end(), std::back_inserter(verdict_.findings));
  }

  /// Puts both runs side by side; false if one is missing.
  bool set_side_by_side(RunPair& pair, Rung rung) {
    if (!pair.is_complete()) return false;
    pair.series = align(layout_, view(pair.trajectories), pair.run.samples + 1);
    measure_pair(pair, weighed_run_.budget(), rung);
    return true;
  }

  void measure_pair(RunPair& pair, const Budget& budget, Rung rung) {
    pair.measured = measure(layout_, pair.series, budget);
    pair.motion = compare_motions(model_, view(pair.trajectories));
    record(layout_, pair.measured, rung, verdict_);
  }

  /// The horizon up to which runs that miss their needs can be compared, if both solvers see one and agree on it.
  std::optional<Horizon> seek_horizon(const RunPair& pair, Rung rung) {
    if (!verdict_.findings.empty()) return std::nullopt;
    const double need = rung == Rung::same_run ? verdict_.need.same_run : verdict_.need.refined;
    if (!sensitivity_.is_measured()) {
      report("sensitivity");
      sensitivity_.measure(pair, integrators(), need);
    }
    const std::optional<Horizon> horizon = sensitivity_.horizon(pair.run.rtol, need);
    if (!horizon) return std::nullopt;
    if (!horizon->agree) {
      verdict_.failures.push_back(disagreement_on(*horizon, rung));
      return std::nullopt;
    }
    verdict_.notes.push_back(note_on(*horizon, rung, pair.run, need));
    return horizon;
  }

  /// Runs at a looser tolerance, for what tolerance changes alone; nothing if a solver did not finish.
  std::optional<RunPair> run_looser(const RunOptions& run, Rung rung) {
    RunPair pair{run, {}, {}, {}, {}};
    pair.run.rtol = run.rtol * kTighter;
    pair.trajectories = integrate(pair.run, name_of(rung));
    if (!pair.is_complete()) return std::nullopt;
    pair.series = align(layout_, view(pair.trajectories), pair.run.samples + 1);
    return pair;
  }

  /// Judges runs on a rung. While they miss the needs although the same state agrees, both solvers run again at a
  /// tighter tolerance: the needs stay. What is left at the tightest is a difference, or an integration that does not
  /// converge. `before`: the runs of before, to see what tolerance changes. The number of samples that were judged;
  /// nothing if a solver did not finish.
  std::optional<int> climb_by_runs(RunPair& pair, const RunPair* before, Rung rung, double motion_need) {
    if (!set_side_by_side(pair, rung)) return std::nullopt;
    const double first = pair.run.rtol;
    std::optional<RunPair> looser;
    const auto reaches = [&] { return reaches_needs(verdict_, rung, pair, motion_need); };
    while (!reaches() && verdict_.findings.empty() && pair.run.rtol > kTightestRepeat) {
      RunPair tighter{pair.run, {}, {}, {}, {}};
      tighter.run.rtol = std::max(pair.run.rtol / kTighter, kTightestRepeat);
      tighter.trajectories = integrate(tighter.run, name_of(rung));
      looser = std::move(pair);
      pair = std::move(tighter);
      if (!set_side_by_side(pair, rung)) return std::nullopt;
    }
    if (looser) {
      verdict_.notes.push_back(fmt::format("{}: repeated at rtol {:g}: at {:g} the integration was not accurate enough",
                                           name_of(rung), pair.run.rtol, first));
    }
    const int samples = pair.run.samples + 1;
    if (reaches()) return samples;
    const RunPair* compared = looser ? &*looser : before;
    const std::optional<Horizon> horizon = seek_horizon(pair, rung);
    if (!horizon) return judge_misses(pair, compared, rung, motion_need) ? std::optional(samples) : std::nullopt;
    RunPair up_to = first_samples(layout_, pair, horizon->samples);
    measure_pair(up_to, weigh_run(weighed_, horizon->samples).budget(), rung);
    pair.motion = up_to.motion;
    summary_of(rung).horizon = up_to.series.times.back();
    if (!reaches_needs(verdict_, rung, up_to, motion_need) && !judge_misses(up_to, compared, rung, motion_need))
      return std::nullopt;
    return horizon->samples;
  }

  RungSummary& summary_of(Rung rung) { return rung == Rung::same_run ? verdict_.same_run : verdict_.refined; }

  /// Judges runs that miss their needs at the tightest tolerance: as a difference, or as integrations that have not
  /// converged, which `compared`, runs at a looser tolerance, tell apart. False if a solver did not finish those.
  bool judge_misses(const RunPair& pair, const RunPair* compared, Rung rung, double motion_need) {
    std::optional<RunPair> looser;
    // Integrators hold their steps no tighter than round-off: what tolerance changes is seen over a whole factor.
    const bool is_far = compared != nullptr && compared->run.rtol >= 0.5 * kTighter * pair.run.rtol;
    if (!is_far && verdict_.findings.empty()) {
      looser = run_looser(pair.run, rung);
      if (!looser) return false;
      compared = &*looser;
    }
    if (verdict_.findings.empty()) {
      const auto samples = static_cast<int>(pair.series.times.size());
      if (samples < compared->run.samples + 1) {
        looser = first_samples(layout_, *compared, samples);
        compared = &*looser;
      }
      if (auto why = find_unconverged(layout_, *compared, pair, rung, motion_need, verdict_)) {
        verdict_.failures.push_back(std::move(*why));
        return true;
      }
    }
    judge_series(pair.series, pair.measured, rung);
    judge_motion(pair.motion, rung, motion_need);
    return true;
  }

  void same_run(RunPair& pair) {
    if (pair.is_complete()) weighed_run_ = weigh_run(weighed_, pair.run.samples + 1);
    const std::optional<int> judged = climb_by_runs(pair, nullptr, Rung::same_run, verdict_.need.same_run);
    for (const Who who : kWho) {
      const auto& trajectory = pair.trajectories[index(who)];
      if (trajectory) verdict_.solvers[index(who)].statistics = trajectory->statistics;
    }
    verdict_.run = pair.run;
    if (!judged) return;
    verdict_.motion = pair.motion;
    verdict_.same_run.samples = *judged;
  }

  /// Motions that part, where no reaction differs.
  void judge_motion(const MotionAgreement& motion, Rung rung, double need) {
    if (motion.digits >= need || !verdict_.findings.empty()) return;
    verdict_.findings.push_back(
        {fmt::format("{}, t = {:.4g} s: {} digits (need {:g})", motion.worst, motion.t, format_digits(motion.digits),
                     need),
         fmt::format("{}: the motions part; look at integration, not at reactions", name_of(rung))});
  }

  void refine(const RunPair& of_same_run) {
    if (!verdict_.same_run.samples) return;
    RunPair pair{of_same_run.run, {}, {}, {}, {}};
    pair.run.rtol = refined_tolerance(pair.run.rtol);
    pair.trajectories = integrate(pair.run, name_of(Rung::refined));
    const double motion_need = std::min(verdict_.need.refined, verdict_.motion->digits + kRefinedRise);
    const std::optional<int> judged = climb_by_runs(pair, &of_same_run, Rung::refined, motion_need);
    if (!judged) return;
    verdict_.refined_motion = pair.motion;
    verdict_.refined.samples = *judged;
  }

  /// The third opinion on each solver alone: every sample of its own run and every state that was handed to it.
  void audit(const Trajectories& trajectories) {
    report("audit");
    for (const Who who : kWho) {
      SolverSummary& summary = verdict_.solvers[index(who)];
      if (const auto& trajectory = trajectories[index(who)]) {
        for (const Sample& sample : trajectory->samples) auditors_[index(who)].add(sample.state, sample.evaluation);
        judge_energy(summary, audit_energy(model_, *trajectory));
      }
      judge_audit(summary, auditors_[index(who)].report());
    }
    verdict_.audit.climbed = std::all_of(
        verdict_.solvers.begin(), verdict_.solvers.end(),
        [](const SolverSummary& solver) { return solver.audit_digits && *solver.audit_digits >= solver.audit_need; });
  }

  void judge_audit(SolverSummary& summary, const AuditReport& found) {
    if (found.states == 0) return;
    summary.audit_digits = found.digits();
    summary.audit_worst = found.worst.text();
    verdict_.audit.digits = std::min(verdict_.audit.digits.value_or(kMostDigits), found.digits());
    verdict_.audit.samples = static_cast<int>(found.states);
    summary.audit_need = need_of(found.worst.rule);
    if (found.holds()) return;
    verdict_.findings.push_back({fmt::format("{} {}: {} (need {:g})", summary.name, breach_of(found.worst.rule),
                                             summary.audit_worst, summary.audit_need),
                                 "audit: from motions, wrenches and mass points alone; look into this solver first"});
  }

  void judge_energy(SolverSummary& summary, const EnergyReport& found) {
    summary.energy_error = found.relative();
    const double allowed = kEnergyPerTolerance * asked_rtol_;
    if (found.relative() <= allowed) return;
    verdict_.findings.push_back(
        {fmt::format("{} does not keep its energy: relative error {:.2e} at t = {:.4g} s, allowed {:.1e}", summary.name,
                     found.relative(), found.t, allowed),
         fmt::format("same run: allowed is {:g} times the relative tolerance", kEnergyPerTolerance)});
  }

  /// Keeps the rows that were asked for.
  void tell_geometric_stiffness(const Trajectories& trajectories) {
    const auto& run = trajectories[trajectories[0] ? 0 : 1];
    if (!run) return;
    for (std::string& note : notes_on(geometric_stiffness(model_, *run))) verdict_.notes.push_back(std::move(note));
  }

  void keep(const Trajectories& trajectories) {
    const auto stride = static_cast<std::size_t>(verdict_.run.samples / asked_samples_);
    for (const Who who : kWho) {
      if (!trajectories[index(who)]) continue;
      Trajectory& kept = verdict_.trajectories[index(who)].emplace();
      kept.statistics = trajectories[index(who)]->statistics;
      const auto& samples = trajectories[index(who)]->samples;
      for (std::size_t k = 0; k < samples.size(); k += stride) kept.samples.push_back(samples[k]);
    }
    if (weighed_run_.mask.cols() == 0) return;
    Mask& unique = verdict_.unique.emplace(weighed_run_.mask.rows(), asked_samples_ + 1);
    for (int k = 0; k <= asked_samples_; ++k) unique.col(k) = weighed_run_.mask.col(k * static_cast<int>(stride));
  }

  /// A difference is told apart: whose it is, where, which term. Asks both solvers in more states, because families of
  /// terms can be told apart only where they differ.
  void attribute() {
    if (verdict_.findings.empty() || !options_.explains) return;
    report("attribution");
    try {
      find_who_is_to_blame();
    } catch (const std::exception& error) {  // the difference stands without its explanation
      verdict_.notes.push_back(fmt::format("who is to blame was not found: {}", error.what()));
    }
    if (verdict_.attribution) verdict_.notes.push_back("to blame: " + describe(*verdict_.attribution));
    if (verdict_.two_by_two) verdict_.notes.push_back("the difference of " + describe(*verdict_.two_by_two));
  }

  void find_who_is_to_blame() {
    verdict_.two_by_two = two_by_two(model_, solvers_, verdict_);
    std::vector<OwnedState> run;
    for (const SharedState& one : weighed_.states) {
      if (one.row >= 0) run.push_back({one.state, Who::cartesian, one.row});
    }
    std::vector<SharedState> drawn;
    if (!run.empty()) drawn = share_random(model_, solvers_, run, options_.seed + 1, kStatesOfTerms).states;
    const auto view_of = [](const std::vector<SharedState>& states) {
      std::vector<EvaluatedState> views;
      for (const SharedState& one : states) {
        views.push_back({&one.state, {&one.evaluations[0], &one.evaluations[1]}});
      }
      return views;
    };
    verdict_.attribution = find_cause({model_,
                                       {auditors_[0].report(), auditors_[1].report()},
                                       view_of(weighed_.states),
                                       view_of(drawn),
                                       ambiguous_joints(),
                                       {&starts_[0], &starts_[1]}});
  }

  /// Joints of whose reactions and totals some component is not unique in some state.
  std::vector<bool> ambiguous_joints() const {
    std::vector<bool> ambiguous(model_.joints.size(), false);
    for (std::size_t row = 0; row < layout_.quantities().size(); ++row) {
      const Quantity& quantity = layout_.quantities()[row];
      if (quantity.kind != Kind::reaction && quantity.kind != Kind::total) continue;
      const auto of_row = static_cast<Eigen::Index>(row);
      if (of_row < weighed_.mask.rows() && !weighed_.mask.row(of_row).all()) ambiguous[quantity.owner] = true;
    }
    return ambiguous;
  }

  void conclude() {
    judge(verdict_);
    if (!has_judged(verdict_)) {
      verdict_.failures.emplace_back("no component was judged");
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
    if (!verdict_.failures.empty()) {
      verdict_.outcome = Outcome::failed;
    } else {
      verdict_.outcome = verdict_.findings.empty() ? Outcome::agree : Outcome::differ;
    }
  }

  const Model& model_;
  QuantityLayout layout_;
  std::array<Solver*, 2> solvers_;
  const VerifyOptions& options_;
  std::mutex progress_guard_;
  std::array<double, 2> done_{};
  int asked_samples_ = 0;
  double asked_rtol_ = 0.0;
  std::array<State, 2> starts_;
  WeighedStates weighed_;  // of the same state rung: of the run, then perturbed ones
  WeighedRun weighed_run_;
  Sensitivity sensitivity_;
  std::vector<Quantity> known_;
  std::array<Auditor, 2> auditors_;
  Verdict verdict_;
};

}  // namespace

Verdict verify(const Model& model, Solver& cartesian, Solver& relative, const VerifyOptions& options) {
  return Verification(model, cartesian, relative, options).run();
}

}  // namespace concord::compare
