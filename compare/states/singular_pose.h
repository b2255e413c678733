#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/solver.h"
#include "compare/states/states.h"

/// Whether a pose is singular: the comparator's one answer, from the ranks that both solvers report of their
/// constraints. The audit counts for itself (compare/audit/machine_rank), and whether a motion passes a singular pose
/// between two others is another question (compare/analyses/branch). Needed by locked triangles, which would differ
/// (tests/verification/contradicting_rows_test).
namespace concord::compare {

/// The reports of both solvers in the same states.
using RankReports = std::vector<std::array<RankReport, 2>>;

/// Asks both solvers in every state. States in which a solver finds a singular pose, or cannot say, are dropped from
/// `states`; their number is returned in `dropped`, the first one's words in `why`.
RankReports report_ranks(const std::array<Solver*, 2>& solvers, std::vector<SharedState>& states, int& dropped,
                         std::string& why);

inline constexpr double kBesideSingular = 1e-6;  // relative singular value

/// Whether a rank counts a row that may be independent by the root of round-off alone, as far as the state is closed:
/// the pose is singular, or next to one.
bool is_beside_singular(const RankReport& report);

/// How far closings from round-off may end from each other, relative to the sizes of a state: places are known to
/// round-off over the smallest singular value that counts, velocities to as much more. 1e-4 at most: what is farther
/// away is another state, however ill-conditioned the closing is. Zero without constraints.
double known_from_closing(const RankReport& report);

/// What is singular among the poses of a machine, by the rank that each solver finds in a general one.
class SingularPoses {
 public:
  SingularPoses() = default;
  SingularPoses(const Model& model, const std::vector<SharedState>& states, const RankReports& reports);

  /// The rank of a solver's constraints in a general pose: the largest in any state that is not beside a singular pose,
  /// if what joints hold redundantly has more than one such pose; the largest in any otherwise.
  [[nodiscard]] int general_rank(std::size_t who) const { return general_[who].rank; }
  [[nodiscard]] bool is_singular(const RankReport& report, std::size_t who) const {
    return report.rank < general_[who].rank;
  }
  /// Of each state why it is a singular pose, in the words of the first solver that says so; empty for all others.
  [[nodiscard]] std::vector<std::string> reasons(const std::array<Solver*, 2>& solvers,
                                                 const std::vector<SharedState>& states,
                                                 const RankReports& reports) const;
  /// Leaves out perturbed states beside a singular pose, if there are general ones. Returns their number. Without it a
  /// parallelogram 0.3 rad from flat is refused.
  int leave_out_beside(std::vector<SharedState>& states, RankReports& reports) const;

 private:
  struct General {
    int rank = 0;
    bool is_clear = false;  // there are poses apart from singular ones
  };
  std::array<General, 2> general_;
};

}  // namespace concord::compare
