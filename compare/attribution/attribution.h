#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/model.h"
#include "compare/attribution/cause.h"
#include "compare/attribution/ranks.h"
#include "compare/attribution/terms.h"
#include "compare/audit/balance.h"

/// Who is to blame for a difference, where, and for which term: found from what the third opinion says of each solver,
/// never from what a solver is made of.
namespace concord::compare {

/// What is known when the verdict is not "agree".
struct Evidence {
  const Model& model;
  /// What the audit found in each solver's answers in the same states and along its own run.
  std::array<AuditReport, 2> audits;
  /// States that both solvers evaluated and in which they were compared.
  std::vector<EvaluatedState> states;
  /// More states, drawn at random: terms can be told apart where they differ.
  std::vector<EvaluatedState> drawn = {};
  /// Joints whose wrenches are not unique in all states: two right solvers may differ there. Empty: all are unique.
  std::vector<bool> ambiguous = {};
  /// Where each solver starts.
  std::array<const State*, 2> starts{};
  /// Whether answers in the same states differ: else a rule that both solvers obey tells nothing.
  bool answers_differ = true;
  /// What the solvers say of their constraints in some states, where they contradict each other in that.
  std::vector<AskedState> constraints = {};
};

/// All guesses, the best one first, each solver, term and place once; nothing if neither solver breaks a rule more than
/// the other one does.
std::vector<Attribution> find_causes(const Evidence& evidence);

/// The best guess.
std::optional<Attribution> find_cause(const Evidence& evidence);

/// The same where a solver stops, and no answers can be compared: who sees the constraints wrongly, or is stopped by
/// its own check.
std::optional<Attribution> find_cause_of_stop(const Model& model, const std::vector<AskedState>& asked);

/// The bodies that a solver leaves out of balance, and the force elements that do not follow their laws, the worst
/// first.
std::vector<int> bodies_out_of_balance(const Evidence& evidence, int solver);
std::vector<int> elements_against_law(const Evidence& evidence, int solver);

}  // namespace concord::compare
