#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/solver.h"
#include "compare/resolution/horizon.h"
#include "compare/resolution/orders.h"
#include "compare/resolution/weighed_states.h"
#include "compare/states/stiff_choice.h"
#include "compare/verdict/convergence.h"
#include "compare/verdict/judge.h"
#include "compare/verdict/progress.h"
#include "compare/verdict/runs_ahead.h"
#include "compare/verdict/turns.h"

/// The checks "same run" and "refined": each solver integrates alone.
namespace concord::compare {

/// Both trajectories; nullptr where a solver did not finish.
std::array<const Trajectory*, 2> view(const std::array<std::optional<Trajectory>, 2>& trajectories);

class RunChecks {
 public:
  /// `seed`: of the displaced starts. What is referred to must outlive this.
  RunChecks(const QuantityLayout& layout, const std::array<Solver*, 2>& solvers, std::uint64_t seed, Judge& judge,
            CheckProgress& progress, Verdict& verdict);

  /// Both solvers at once, each in its own thread and by the integrator that the verdict names; neither sees the other.
  /// Who does not finish is a failure. Nothing is judged. A solver whose first integrator takes too long in its first
  /// run, and that may switch, goes on by its second from then on; a note says so.
  RunPair integrate(const RunOptions& run, Check check);
  /// The runs of the same run. With `makers`, which must outlive this, those that the refined check needs at first are
  /// begun beside them, by solvers made anew; null: refine() makes them.
  RunPair integrate_beside_refined(const RunOptions& run, const SolverMakers* makers);
  /// Whose integrator was not asked for, by Who.
  void allow_switching(const std::array<bool, 2>& may_switch) { may_switch_ = may_switch; }

  /// Judges complete runs, whose states were weighed, or their repetition at tighter tolerances, which is left in
  /// `pair`.
  void judge_same_run(RunPair& pair, const WeighedStates& weighed);

  /// Judges runs at the refined tolerance, if the same run was judged: call it after judge_same_run().
  void refine(const RunPair& of_same_run, const WeighedStates& weighed);

  /// Tells how each solver's runs converge with the tolerance, if there are enough of them; `further`: runs at looser
  /// tolerances are made until there are.
  void study_orders(bool further);

  /// What holds in the samples of a run; empty if no run was judged.
  [[nodiscard]] const WeighedRun& weighed_run() const { return weighed_run_; }

  /// Whether a solver's runs were found not to converge because its integrator holds its steps no tighter.
  [[nodiscard]] bool stands(Who who) const { return stands_[index(who)]; }

  /// Runs at a looser tolerance that judge nothing; nothing, and no failure, if they are too loose to follow the
  /// motion.
  std::optional<RunPair> try_looser(const RunOptions& run, const char* what);

 private:
  /// Runs that are being made, by Who; of a solver that does not run there is none.
  struct Running {
    RunOptions run;
    std::array<MadeBy, 2> made_by;
    std::array<std::future<Trajectory>, 2> trajectories;
  };
  void start(Running& running, const char* what, const std::array<bool, 2>& may_switch,
             const std::array<bool, 2>& rests = {});
  RunPair finish(Running& running, const char* what, std::vector<std::string>& failures);
  RunPair run_both(const RunOptions& run, const char* what, std::vector<std::string>& failures,
                   const std::array<bool, 2>& may_switch);
  RunPair refined_at_first(const RunOptions& refined);
  void tighten_as_asked(const RunPair& of_same_run, RunPair& pair);
  [[nodiscard]] double motion_need(Check check) const;
  [[nodiscard]] const std::string& integrator_of(Who who) const;
  bool set_side_by_side(RunPair& pair, Check check);
  void measure_pair(RunPair& pair, const WeighedRun& weighed, Check check);
  void widen_pair(RunPair& pair, WeighedRun weighed, Check check);
  std::optional<int> judge_runs(RunPair& pair, const RunPair* before, Check check, const WeighedStates& weighed);
  bool repeat_tighter(RunPair& pair, std::optional<RunPair>& looser, Check check);
  std::optional<Horizon> seek_horizon(const RunPair& pair, Check check);
  std::optional<RunPair> run_looser(const RunOptions& run, Check check);
  RunPair aligned(RunPair pair);
  void tell_if_unresolved();
  bool judge_misses(const RunPair& pair, const RunPair* compared, Check check);
  void judge_motion(const MotionAgreement& motion, Check check, double need);

  const QuantityLayout& layout_;
  std::array<Solver*, 2> solvers_;
  Judge& judge_;
  CheckProgress& progress_;
  Verdict& verdict_;
  std::array<bool, 2> may_switch_{};
  std::array<std::string, 2> goes_on_by_;  // after a switch
  Sensitivity sensitivity_;
  WeighedRun weighed_run_;
  std::array<bool, 2> stands_{};
  std::vector<std::string> stopped_;  // why runs at a tighter tolerance did not finish
  OrderStudy orders_;
  Turns turns_{count_processors()};
  std::unique_ptr<RunsAhead> ahead_;  // of the refined check
};

}  // namespace concord::compare
