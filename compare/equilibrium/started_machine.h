#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compare/quantities/align.h"
#include "compare/states/branch.h"
#include "compare/states/near_frames.h"
#include "compare/states/start_report.h"

namespace concord::compare {

/// The model as it runs: as it is, or, if it says so, with its start in the equilibrium that both solvers find; `note`
/// then tells how far they agree on it. Throws SolverError if they do not.
Model as_it_starts(const Model& model, const SolverMakers& makers, std::string& note);

/// A machine with both solvers, as every command starts it: in frames near its bodies, from the equilibrium if the
/// model says so, and both solvers on one branch.
class StartedMachine {
 public:
  /// Throws as NearFrames, as_it_starts() and make_solvers_on_one_branch() do.
  StartedMachine(const Model& given, const SolverMakers& makers);
  StartedMachine(const StartedMachine&) = delete;  // solvers are bound to the model
  StartedMachine& operator=(const StartedMachine&) = delete;

  [[nodiscard]] const Model& model() const { return model_; }
  [[nodiscard]] Solver& solver(Who who) const { return *solvers_[index(who)]; }
  /// What was put right while reading, and notes on the frames, on the equilibrium and on the branch, where there is
  /// something to tell.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }
  /// Motions as those of the frames of the model as it was given: of a run, or of those of both solvers. Throws as
  /// NearFrames::back() does.
  template <class Runs>
  [[nodiscard]] Runs back(Runs runs) const {
    return near_.back(std::move(runs));
  }

 private:
  NearFrames near_;
  Model model_;
  Solvers solvers_;
  std::vector<std::string> notes_;
};

/// Of which machines other poses are sought in which they could be assembled: of those of few joints, where it costs
/// little beside a comparison, or of all.
enum class SeekPoses { of_few_joints, of_all };

/// Joints of the largest machine for which SeekPoses::of_few_joints seeks.
inline constexpr std::size_t kFewJoints = 40;

/// Where the machine starts, beside what the model as it was given says. Other poses are assembled by relative and
/// count where the residuals of cartesian accept them. Nothing where no solver finds a start.
std::optional<StartReport> start_of(const Model& given, const StartedMachine& machine, const SolverMakers& makers,
                                    SeekPoses seek);

}  // namespace concord::compare
