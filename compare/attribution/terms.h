#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/model.h"
#include "compare/attribution/cause.h"
#include "compare/audit/balance.h"

/// Which term of a body's equations of motion is wrong? What the body's forces leave over in many states is held
/// against each family of terms: the one whose terms, with constant factors, add up to it is to blame.
namespace concord::compare {

/// One state with what each solver says there.
struct EvaluatedState {
  const State* state = nullptr;
  std::array<const Evaluation*, 2> by{};
};

/// A term that explains what a body's forces leave over.
struct TermFit {
  Term term = Term::unknown;
  /// The force element or joint whose wrench it is; empty otherwise.
  std::string whose;
  /// Part of what is left over that the term does not explain, 0 to 1.
  double unexplained = 1.0;
};

/// Fits one solver's out-of-balance of a body (not ground) over all states.
TermFit fit_term(const Model& model, const Auditor& auditor, int body, const std::vector<EvaluatedState>& states,
                 int solver);

/// Of a joint whose bodies' accelerations it does not permit: Term::jacobian if the misfit goes with accelerations,
/// Term::bias if it goes with products of speeds, Term::unknown if a number is not finite. Without states
/// Term::jacobian: then neither solver accepts what the other one closed.
Term fit_joint_misfit(const Model& model, int joint, const std::vector<EvaluatedState>& states, int solver);

}  // namespace concord::compare
