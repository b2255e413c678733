#pragma once

#include <optional>
#include <string>

/// What a verdict says of the cause of a difference.
namespace concord::compare {

/// What a fault sits in.
enum class Term {
  // of the dynamics of a body
  inertia,
  gyroscopic,  // and Coriolis
  modal_coupling,
  elastic,
  damping,
  applied,   // force elements, joint springs, gravity
  reaction,  // a joint's wrench in a body's balance
  // of kinematics
  jacobian,
  bias,
  driver,
  rank,  // which constraints are independent, and so what is unique
  // of what is reported
  side,
  point,
  frame,
  subtraction,
  // of the start, and of what is told to both solvers
  start,
  statement,
  unknown
};

/// "inertia", "gyroscopic and Coriolis", "Jacobian", ...
const char* name_of(Term term);

/// Who is to blame, where, and for which term.
struct Attribution {
  /// 0 cartesian, 1 relative, 2: both, so that what they share is wrong (a law, a joint's page, modal data).
  int solver = 0;
  Term term = Term::unknown;
  /// "body hub", "joint rod", "force element strut", "coupling mesh"
  std::string where;
  /// What speaks for it, in a sentence.
  std::string because;
  /// Where the guess could be tried: by how many digits the difference closed with the blamed place put right.
  std::optional<double> closed_digits = {};
};

/// "cartesian, at body hub, in the term "inertia": breaks the audit's rule "free body" by F_y (3.2 digits); ..."
std::string describe(const Attribution& blame);

}  // namespace concord::compare
