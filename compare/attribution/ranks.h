#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/solver.h"
#include "compare/attribution/terms.h"
#include "compare/audit/machine_rank.h"

/// Who sees the constraints wrongly? What solvers say of them in some states, without solving for anything, held
/// against the third opinion's own count: also where a solver stops, and no answers can be compared.
namespace concord::compare {

/// What one solver says of its constraints in a state.
struct StatedConstraints {
  enum class Answer { given, singular, open, none };

  /// Missing where it stops.
  std::optional<RankReport> rank;
  /// Solver::tangent(); no rows where it stops.
  MatX tangent;
  /// What it makes of the state when it is to close it.
  std::optional<State> closed;
  /// What Solver::evaluate() comes to, in its words where it stops.
  Answer answer = Answer::none;
  std::string words;
  std::string place;  // where the state is open by its own constraints
};

/// A state that a solver closed, and what both say there.
struct AskedState {
  State state;
  int owner = 0;
  std::array<StatedConstraints, 2> by;
};

/// A solver that sees the constraints wrongly.
struct ConstraintFault {
  int solver = 0;
  Term term = Term::rank;
  std::string where;
  std::string because;
};

/// Asks the third opinion about every state once, when that is needed. Model and states must outlive it.
class ConstraintOpinion {
 public:
  ConstraintOpinion(const Model& model, const std::vector<AskedState>& asked);

  /// Who counts another rank, or other degrees of freedom, than the joints themselves give, if the other one does not:
  /// for want of a right Jacobian, or of a right count.
  [[nodiscard]] std::optional<ConstraintFault> wrong_count();
  /// Who permits other velocities, neither more nor fewer, than the joints do.
  [[nodiscard]] std::optional<ConstraintFault> wrong_velocities();
  /// Who closes a state so that a joint or a coupling is left open.
  [[nodiscard]] std::optional<ConstraintFault> wrongly_closed();
  /// Who calls states open that are closed, and that the other one answers.
  [[nodiscard]] std::optional<ConstraintFault> refuses_closed() const;
  /// Who calls poses singular that are clearly not, and that the other one answers.
  [[nodiscard]] std::optional<ConstraintFault> wrongly_singular();
  /// Who calls components unique that a self-stress moves, or the other way round, where the solvers contradict each
  /// other.
  [[nodiscard]] std::optional<ConstraintFault> wrong_uniqueness();

 private:
  [[nodiscard]] const MachineConstraints& at(std::size_t state);
  /// Whether the third opinion has one there: the state is closed, and its rank is clear.
  [[nodiscard]] bool is_sure(std::size_t state);
  [[nodiscard]] bool is_wrong(std::size_t state, int solver);
  [[nodiscard]] std::optional<ConstraintFault> wrong_count_of(int solver);
  [[nodiscard]] bool is_clearly_regular(std::size_t state);
  [[nodiscard]] int general_rank();

  const Model& model_;
  const std::vector<AskedState>& asked_;
  std::vector<std::optional<MachineConstraints>> constraints_;
  std::vector<std::string> left_open_;  // in each state; empty if it is closed
};

}  // namespace concord::compare
