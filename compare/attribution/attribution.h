#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/model.h"
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
  /// Generic states that both solvers evaluated: the more, the more terms can be told apart.
  std::vector<EvaluatedState> states;
  /// Where each solver starts.
  std::array<const State*, 2> starts{};
};

struct Attribution {
  /// 0 cartesian, 1 relative, 2: both alike, so that what they share is wrong (a law, a joint's page, modal data).
  int solver = 0;
  Term term = Term::unknown;
  /// "body hub", "joint rod", "force element strut", "coupling mesh"
  std::string where;
  /// What speaks for it, in a sentence.
  std::string because;
};

/// Nothing if neither solver breaks a rule more than the other one does.
std::optional<Attribution> find_cause(const Evidence& evidence);

/// "cartesian: body hub, gyroscopic and Coriolis: ..."
std::string describe(const Attribution& blame);

}  // namespace concord::compare
