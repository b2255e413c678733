#pragma once

#include <array>
#include <atomic>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "common/solver.h"
#include "compare/resolution/run_pairs.h"
#include "compare/states/branch.h"
#include "compare/verdict/progress.h"
#include "compare/verdict/turns.h"

/// Runs that are made before it is known whether they are needed, beside others.
namespace concord::compare {

/// Both solvers' runs at one tolerance, each in a thread of its own, by solvers that are made for them: what they find
/// does not depend on what else is done meanwhile.
class RunsAhead {
 public:
  /// `integrators`: by Who. What is referred to must outlive this.
  RunsAhead(const Model& model, const SolverMakers& makers, const RunOptions& run,
            const std::array<std::string, 2>& integrators, const char* what, Turns& turns, CheckProgress& progress);
  /// Waits until both have seen that nobody wants them, at the end of their steps.
  ~RunsAhead();
  RunsAhead(const RunsAhead&) = delete;
  RunsAhead& operator=(const RunsAhead&) = delete;

  [[nodiscard]] const RunOptions& options() const { return run_; }
  [[nodiscard]] const std::array<std::string, 2>& integrators() const { return integrators_; }

  /// Waits for the runs. Who does not finish is told in `failures`. Nothing if one of them takes more evaluations than
  /// are spent on what may not be needed.
  std::optional<RunPair> fetch(std::vector<std::string>& failures);

 private:
  Trajectory make(Who who, const Model& model, const SolverMakers& makers, int place);

  RunOptions run_;
  std::array<std::string, 2> integrators_;
  const char* what_;
  Turns& turns_;
  CheckProgress& progress_;
  std::atomic<bool> abandoned_ = false;
  std::array<std::future<Trajectory>, 2> running_;
};

}  // namespace concord::compare
