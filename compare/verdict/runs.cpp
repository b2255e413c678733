#include "compare/verdict/runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "common/error.h"
#include "compare/audit/digits.h"
#include "compare/quantities/align.h"
#include "compare/quantities/motions.h"
#include "compare/quantities/needs.h"
#include "compare/resolution/jumps.h"
#include "compare/verdict/refinement.h"

namespace concord::compare {

namespace {

CheckSummary& summary_of_runs(Verdict& verdict, Check check) {
  return check == Check::same_run ? verdict.same_run : verdict.refined;
}

/// More evaluations than tolerance alone asks for, from the loosest to the tightest: beyond, steps are made against
/// round-off.
long most_evaluations_beside(const RunPair& pair) {
  constexpr long kTimes = 30;
  constexpr long kAlways = 1'000'000;
  long most = 0;
  for (const auto& trajectory : pair.trajectories) most = std::max(most, trajectory->statistics.evaluations);
  return std::max(kAlways, kTimes * most);
}

RunOptions looser_than(RunOptions run) {
  run.rtol *= kTighter;
  return run;
}

}  // namespace

std::array<const Trajectory*, 2> view(const std::array<std::optional<Trajectory>, 2>& trajectories) {
  std::array<const Trajectory*, 2> both{};
  for (const Who who : kBothSolvers) {
    if (trajectories[index(who)]) both[index(who)] = &*trajectories[index(who)];
  }
  return both;
}

RunChecks::RunChecks(const QuantityLayout& layout, const std::array<Solver*, 2>& solvers, std::uint64_t seed,
                     Judge& judge, CheckProgress& progress, Verdict& verdict)
    : layout_(layout),
      solvers_(solvers),
      judge_(judge),
      progress_(progress),
      verdict_(verdict),
      sensitivity_(layout.model(), solvers, seed),
      orders_(layout) {}

/// False if one of the runs is missing.
bool RunChecks::set_side_by_side(RunPair& pair, Check check) {
  if (!pair.is_complete()) return false;
  if (check == Check::refined) set_refined_tolerance(verdict_, pair.run.rtol);
  pair.series = align(layout_, view(pair.trajectories), pair.run.samples + 1);
  measure_pair(pair, weighed_run_, check);
  orders_.add(pair);
  return true;
}

void RunChecks::measure_pair(RunPair& pair, const WeighedRun& weighed, Check check) {
  pair.measured = judge_.measure_check(pair.series, weighed.budget(), check);
  pair.motion = compare_motions(layout_.model(), view(pair.trajectories),
                                noise_of_speeds(layout_, weighed.resolution, *pair.trajectories[0]));
  widen_pair(pair, weighed, check);
}

/// Measures again where samples fall on a jump of a force.
void RunChecks::widen_pair(RunPair& pair, WeighedRun weighed, Check check) {
  const double need = check == Check::same_run ? verdict_.need.same_run : verdict_.need.refined;
  const auto sample_of = [&](std::size_t k) { return pair.trajectories[0]->samples[k]; };
  const auto jumps = widen_at_jumps(layout_, solvers_, pair.series, pair.measured, sample_of, need, weighed.resolution);
  if (jumps.empty()) return;
  pair.measured = judge_.measure_check(pair.series, weighed.budget(), check);
  std::string note = note_on_jumps(jumps, check);
  const auto& notes = verdict_.notes;  // runs at several tolerances meet the same jumps
  if (std::find(notes.begin(), notes.end(), note) == notes.end()) verdict_.notes.push_back(std::move(note));
}

/// The horizon up to which runs that miss their needs can be compared, if both solvers see one and agree on it.
std::optional<Horizon> RunChecks::seek_horizon(const RunPair& pair, Check check) {
  if (!verdict_.findings.empty()) return std::nullopt;
  const double need = check == Check::same_run ? verdict_.need.same_run : verdict_.need.refined;
  // Runs that could not be repeated at a tight tolerance part early, without being sensitive.
  constexpr double kClearlySensitive = 100.0;
  if (!stopped_.empty() && allowed_growth(pair.run.rtol, need) < kClearlySensitive) return std::nullopt;
  if (!sensitivity_.is_measured()) {
    progress_.begin("sensitivity");
    sensitivity_.measure(pair, pair.integrators, need);
  }
  const std::optional<Horizon> horizon = sensitivity_.horizon(pair.run.rtol, need);
  if (!horizon) return std::nullopt;
  if (!horizon->agree) {
    verdict_.failures.push_back(disagreement_on(*horizon, check));
    return std::nullopt;
  }
  verdict_.notes.push_back(note_on(*horizon, check, pair.run, need));
  return horizon;
}

/// Runs at a looser tolerance, for what tolerance changes alone; nothing if a solver did not finish, which is a
/// failure.
std::optional<RunPair> RunChecks::run_looser(const RunOptions& run, Check check) {
  RunPair pair = integrate(looser_than(run), check);
  return pair.is_complete() ? std::optional(aligned(std::move(pair))) : std::nullopt;
}

std::optional<RunPair> RunChecks::try_looser(const RunOptions& run, const char* what) {
  std::vector<std::string> stopped;
  RunPair pair = run_both(looser_than(run), what, stopped, {false, false});
  return pair.is_complete() ? std::optional(aligned(std::move(pair))) : std::nullopt;
}

/// Complete runs side by side, which tell of the observed order, too.
RunPair RunChecks::aligned(RunPair pair) {
  pair.series = align(layout_, view(pair.trajectories), pair.run.samples + 1);
  orders_.add(pair);
  return pair;
}

/// While runs miss the needs although the same state agrees, both solvers run again at a tighter tolerance: the needs
/// stay. Ends where a solver does not finish, which `stopped_` tells. `looser`: the runs before the last ones, if there
/// were any. False if a solver did not finish the first ones.
bool RunChecks::repeat_tighter(RunPair& pair, std::optional<RunPair>& looser, Check check) {
  stopped_.clear();
  const double first = pair.run.rtol;
  const long most_evaluations = most_evaluations_beside(pair);
  while (!reaches_needs(verdict_, check, pair, motion_need(check)) && verdict_.findings.empty() &&
         0.5 * pair.run.rtol > kTightestRepeat) {
    ahead_.reset();
    RunOptions tight = pair.run;
    tight.rtol = std::max(pair.run.rtol / kTighter, kTightestRepeat);
    tight.most_evaluations = most_evaluations;
    RunPair tighter = run_both(tight, name_of(check), stopped_, may_switch_);
    if (!tighter.is_complete()) break;
    tighter.run.most_evaluations.reset();
    looser = std::move(pair);
    pair = std::move(tighter);
    if (!set_side_by_side(pair, check)) return false;
  }
  if (looser) {
    verdict_.notes.push_back(fmt::format("{}: repeated at rtol {:g}: at {:g} the integration was not accurate enough",
                                         name_of(check), pair.run.rtol, first));
  }
  return true;
}

/// Judges runs on a check, or their repetition at tighter tolerances. What is left at the tightest is a difference, or
/// an integration that does not converge. `before`: the runs of before, to see what tolerance changes. The number of
/// samples that were judged; nothing if a solver did not finish.
std::optional<int> RunChecks::judge_runs(RunPair& pair, const RunPair* before, Check check,
                                         const WeighedStates& weighed) {
  std::optional<RunPair> looser;
  if (!repeat_tighter(pair, looser, check)) return std::nullopt;
  const int samples = pair.run.samples + 1;
  if (reaches_needs(verdict_, check, pair, motion_need(check))) return samples;
  const RunPair* compared = looser ? &*looser : before;
  const std::optional<Horizon> horizon = seek_horizon(pair, check);
  if (!horizon) return judge_misses(pair, compared, check) ? std::optional(samples) : std::nullopt;
  RunPair up_to = first_samples(layout_, pair, horizon->samples);
  measure_pair(up_to, weigh_run(weighed, horizon->samples), check);
  pair.motion = up_to.motion;
  summary_of_runs(verdict_, check).horizon = up_to.series.times.back();
  if (!reaches_needs(verdict_, check, up_to, motion_need(check)) && !judge_misses(up_to, compared, check))
    return std::nullopt;
  return horizon->samples;
}

/// Judges runs that miss their needs at the tightest tolerance: as a difference, or as integrations that have not
/// converged, which `compared`, runs at a looser tolerance, tell apart. False if a solver did not finish those.
bool RunChecks::judge_misses(const RunPair& pair, const RunPair* compared, Check check) {
  std::optional<RunPair> looser;
  std::optional<std::size_t> standing;
  if (verdict_.findings.empty()) {
    // Integrators hold their steps no tighter than round-off: what tolerance changes is seen over a whole factor, and
    // where neither run stands.
    const bool is_far = compared != nullptr && compared->run.rtol >= 0.5 * kTighter * pair.run.rtol;
    if (!is_far) {
      looser = run_looser(pair.run, check);
      if (!looser) return false;
      compared = &*looser;
    }
    standing = run_that_stands(layout_.model(), *compared, pair);
    if (standing) {
      looser = run_looser(compared->run, check);
      if (!looser) return false;
      compared = &*looser;
    }
    const auto samples = static_cast<int>(pair.series.times.size());
    if (samples < compared->run.samples + 1) {
      looser = first_samples(layout_, *compared, samples);
      compared = &*looser;
    }
    if (auto why = find_unconverged(layout_, *compared, pair, check, motion_need(check), standing, verdict_)) {
      if (standing) {
        *why += advice_on_standing(pair, *standing);
        stands_[*standing] = true;
      }
      if (!stopped_.empty())
        *why += fmt::format("; at a tighter tolerance a solver does not finish: {}", fmt::join(stopped_, "; "));
      verdict_.failures.push_back(std::move(*why));
      return true;
    }
  }
  if (!stopped_.empty()) {  // a tighter run would tell what the difference is
    verdict_.failures.insert(verdict_.failures.end(), stopped_.begin(), stopped_.end());
    return false;
  }
  judge_.find_differences_on(pair.series, pair.measured, check);
  judge_motion(pair.motion, check, motion_need(check));
  return true;
}

/// Motions that part, where no reaction differs.
void RunChecks::judge_motion(const MotionAgreement& motion, Check check, double need) {
  if (motion.digits >= need || !verdict_.findings.empty()) return;
  verdict_.findings.push_back(
      {fmt::format("{}, t = {:.4g} s: {} digits (need {:g})", motion.worst, motion.t, format_digits(motion.digits),
                   need),
       fmt::format("{}: the motions part; look at integration, not at reactions", name_of(check))});
}

void RunChecks::judge_same_run(RunPair& pair, const WeighedStates& weighed) {
  if (pair.is_complete()) weighed_run_ = weigh_run(weighed, pair.run.samples + 1);
  std::optional<int> judged;
  if (set_side_by_side(pair, Check::same_run)) judged = judge_runs(pair, nullptr, Check::same_run, weighed);
  for (const Who who : kBothSolvers) {
    const auto& trajectory = pair.trajectories[index(who)];
    if (!trajectory) continue;
    verdict_.solvers[index(who)].statistics = trajectory->statistics;
    if (!pair.integrators[index(who)].empty()) verdict_.solvers[index(who)].integrator = pair.integrators[index(who)];
  }
  verdict_.run = pair.run;
  if (!judged) return;
  verdict_.motion = pair.motion;
  verdict_.same_run.samples = *judged;
  tell_if_unresolved();
}

/// Digits that the motions need.
double RunChecks::motion_need(Check check) const {
  if (check == Check::same_run) return verdict_.need.same_run;
  return std::min(verdict_.need.refined, verdict_.motion->digits + required_rise(verdict_));
}

void RunChecks::refine(const RunPair& of_same_run, const WeighedStates& weighed) {
  if (!verdict_.same_run.samples) {
    ahead_.reset();
    return;
  }
  RunOptions refined = of_same_run.run;
  refined.rtol = refined_tolerance(refined.rtol);
  RunPair pair = refined_at_first(refined);
  if (!set_side_by_side(pair, Check::refined)) return;
  tighten_as_asked(of_same_run, pair);
  if (!pair.is_complete()) return;
  const std::optional<int> judged = judge_runs(pair, &of_same_run, Check::refined, weighed);
  if (!judged) return;
  verdict_.refined_motion = pair.motion;
  verdict_.refined.samples = *judged;
}

/// A run of which nothing was judged has not passed its check, and the reader wants to know why.
void RunChecks::tell_if_unresolved() {
  const bool has_reactions = !verdict_.rows.empty();
  const std::vector<QuantityRow>& rows = has_reactions ? verdict_.rows : verdict_.others;
  const auto is_unique = [has_reactions](const QuantityRow& row) {
    return row.unique && (has_reactions || row.quantity.kind == Kind::element);
  };
  const auto is_open = [&](const QuantityRow& row) {
    const CheckDetail& detail = detail_of(row, Check::same_run);
    return !is_unique(row) || (detail.samples == 0 && detail.too_coarse > 0);
  };
  if (!std::all_of(rows.begin(), rows.end(), is_open) || std::none_of(rows.begin(), rows.end(), is_unique)) return;
  verdict_.notes.push_back(
      fmt::format("no {} of the runs is judged: what they leave open of places makes forces of more than {:g} of "
                  "those in this motion, as where a loop holds stiff bodies; the states are judged",
                  has_reactions ? "reaction" : "force element", kCoarsest));
}

void RunChecks::study_orders(bool further) {
  constexpr std::size_t kEnough = 4;
  constexpr double kLoosest = 1e-3;
  while (further && orders_.size() > 0 && orders_.size() < kEnough && orders_.loosest() * kTighter <= kLoosest) {
    RunOptions loosest = verdict_.run;
    loosest.rtol = orders_.loosest();
    if (!try_looser(loosest, "observed order")) break;
  }
  verdict_.orders = orders_.orders(weighed_run_.mask);
  if (!verdict_.orders) {
    if (further)
      verdict_.notes.push_back(fmt::format("observed order: not told, runs at only {} tolerances", orders_.size()));
    return;
  }
  for (std::string& sentence : describe(*verdict_.orders)) verdict_.notes.push_back(std::move(sentence));
}

}  // namespace concord::compare
