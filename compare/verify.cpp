#include "compare/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <future>
#include <mutex>

#include "compare/agreement.h"
#include "compare/balance.h"
#include "compare/digits.h"
#include "compare/findings.h"
#include "compare/geometric_stiffness.h"
#include "compare/refinement.h"
#include "compare/states.h"
#include "compare/sums.h"

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

/// Rows of the run so that at least kTrajectoryStates of them exist and the rows asked for are among them.
int run_rows(int samples) {
  const int parts = (kTrajectoryStates - 1 + samples - 1) / samples;
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

bool is_complete(const Trajectories& trajectories) { return trajectories[0] && trajectories[1]; }

/// One model on its way through the rungs.
class Climb {
 public:
  Climb(const Model& model, Solver& cartesian, Solver& relative, const VerifyOptions& options)
      : model_(model),
        layout_(model),
        solvers_{&cartesian, &relative},
        options_(options),
        auditors_{Auditor(model), Auditor(model)} {}

  Verdict run() {
    check_needs(model_);
    describe_case();
    try {
      if (!assemble()) return std::move(verdict_);
      compare_rank();
      make_rows(layout_, verdict_);
      const Trajectories trajectories = integrate(verdict_.run, "same run");
      same_state(trajectories);
      same_run(trajectories);
      refine();
      audit(trajectories);
      tell_geometric_stiffness(trajectories);
      keep(trajectories);
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
    asked_samples_ = verdict_.run.samples;
    verdict_.run.samples = run_rows(asked_samples_);
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

  void compare_rank() {
    for (const SolverSummary& solver : verdict_.solvers) {
      if (solver.rank.joints.size() != model_.joints.size()) {
        throw IncompleteResult(fmt::format("{}: the rank report has {} joints, the model {}", solver.name,
                                           solver.rank.joints.size(), model_.joints.size()));
      }
      if (!solver.rank.undecided) continue;
      verdict_.failures.push_back(fmt::format(
          "{}: the rank of the constraints is undecided at the start: relative singular values {:.1e} kept, {:.1e} "
          "dropped; state the machine away from this pose, or with a joint that forbids clearly more or less",
          solver.name, solver.rank.smallest_kept, solver.rank.largest_dropped));
    }
    verdict_.findings = compare_ranks(model_, verdict_.solvers[0].rank, verdict_.solvers[1].rank);
    verdict_.rank_agrees = verdict_.findings.empty();
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
    std::vector<OwnedState> run = run_states(view(trajectories));
    if (run.empty()) {
      for (const Who who : kWho) run.push_back({starts_[index(who)], who});
    }
    SharedStates shared = share(solvers_, run);
    SharedStates random = share_random(model_, solvers_, run, kSeed);
    check_enough(shared, random);
    for (SharedStates* part : {&shared, &random}) note_refusals(*part);
    compare_generic_rank(random);
    std::move(random.states.begin(), random.states.end(), std::back_inserter(shared.states));
    verdict_.same_state.samples = static_cast<int>(shared.states.size());
    if (shared.states.empty()) return;
    judge_series(align(layout_, shared.states), Rung::same_state);
    for (const SharedState& one : shared.states) {
      for (const Who who : kWho) auditors_[index(who)].add(one.state, one.evaluations[index(who)]);
    }
    verdict_.pair_sums = compare_pair_sums(model_, shared.states);
  }

  void check_enough(const SharedStates& shared, const SharedStates& random) {
    if (!shared.refusals.empty() || !random.refusals.empty()) return;  // a difference already
    const auto require = [&](std::size_t found, int needed, const char* what) {
      if (found >= static_cast<std::size_t>(needed)) return;
      verdict_.failures.push_back(fmt::format("same state: {} {} states, need {}", found, what, needed));
    };
    require(shared.states.size(), kTrajectoryStates, "trajectory");
    require(random.states.size(), kRandomStates, "random");
  }

  void note_refusals(const SharedStates& shared) {
    if (!shared.failures.empty()) verdict_.failures.push_back(shared.failures.front());
    if (shared.refusals.empty()) return;
    verdict_.findings.push_back(
        {shared.refusals.front(),
         fmt::format("same state: {} such states: the closures differ; hold what the joint forbids against what it "
                     "permits",
                     shared.refusals.size())});
  }

  /// A rank at the start that is lower than at generic states is a singular pose.
  void compare_generic_rank(const SharedStates& random) {
    for (const Who who : kWho) {
      const RankReport& start = verdict_.solvers[index(who)].rank;
      for (std::size_t k = 0; k < random.states.size(); k += 17) {
        const int generic = solvers_[index(who)]->rank(random.states[k].state).rank;
        if (generic <= start.rank) continue;
        verdict_.notes.push_back(
            fmt::format("{}: the start pose is singular: rank {} there, {} at a neighbouring pose; motion may branch",
                        solvers_[index(who)]->name(), start.rank, generic));
        break;
      }
    }
  }

  void judge_series(const Series& series, Rung rung) {
    const std::vector<Measured> measured = measure(layout_, series);
    record(layout_, measured, rung, verdict_);
    std::vector<Finding> found = find_differences(layout_, series, measured, verdict_, rung, known_);
    std::move(found.begin(), found.end(), std::back_inserter(verdict_.findings));
  }

  void same_run(const Trajectories& trajectories) {
    for (const Who who : kWho) {
      if (trajectories[index(who)]) verdict_.solvers[index(who)].statistics = trajectories[index(who)]->statistics;
    }
    if (!is_complete(trajectories)) return;
    const int rows = verdict_.run.samples + 1;
    verdict_.motion = compare_motions(model_, view(trajectories));
    judge_series(align(layout_, view(trajectories), rows), Rung::same_run);
    verdict_.same_run.samples = rows;
  }

  void refine() {
    if (!verdict_.same_run.samples) return;
    RunOptions run = verdict_.run;
    run.rtol = refined_tolerance(run.rtol);
    const Trajectories trajectories = integrate(run, "refined");
    if (!is_complete(trajectories)) return;
    verdict_.refined_motion = compare_motions(model_, view(trajectories));
    judge_series(align(layout_, view(trajectories), run.samples + 1), Rung::refined);
    verdict_.refined.samples = run.samples + 1;
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
    verdict_.audit.climbed = verdict_.audit.digits.value_or(0.0) >= kAudit;
  }

  void judge_audit(SolverSummary& summary, const AuditReport& found) {
    if (found.states == 0) return;
    summary.audit_digits = found.digits();
    summary.audit_worst = found.worst.text();
    verdict_.audit.digits = std::min(verdict_.audit.digits.value_or(kMostDigits), found.digits());
    verdict_.audit.samples = static_cast<int>(found.states);
    if (found.digits() >= kAudit) return;
    verdict_.findings.push_back(
        {fmt::format("{} is not in balance: {} (need {:g})", summary.name, summary.audit_worst, kAudit),
         "audit: from motions, wrenches and mass points alone; look into this solver first"});
  }

  void judge_energy(SolverSummary& summary, const EnergyReport& found) {
    summary.energy_error = found.relative();
    const double allowed = kEnergyPerTolerance * verdict_.run.rtol;
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
    }
    if (!verdict_.failures.empty()) {
      verdict_.outcome = Outcome::failed;
    } else {
      verdict_.outcome = verdict_.findings.empty() ? Outcome::agree : Outcome::differ;
    }
  }

  const Model& model_;
  Layout layout_;
  std::array<Solver*, 2> solvers_;
  const VerifyOptions& options_;
  std::mutex progress_guard_;
  std::array<double, 2> done_{};
  int asked_samples_ = 0;
  std::array<State, 2> starts_;
  std::vector<Quantity> known_;
  std::array<Auditor, 2> auditors_;
  Verdict verdict_;
};

}  // namespace

Verdict verify(const Model& model, Solver& cartesian, Solver& relative, const VerifyOptions& options) {
  return Climb(model, cartesian, relative, options).run();
}

}  // namespace concord::compare
