#pragma once

#include <optional>
#include <string>
#include <vector>

#include "compare/attribution/terms.h"

/// Where two solvers move alike and report different wrenches: what about the report is wrong?
namespace concord::compare {

/// Whether both solvers give the same accelerations in all states, to what separates a wrong report from a wrong
/// motion.
bool move_alike(const std::vector<EvaluatedState>& states);

struct ReportFault {
  Term term = Term::reaction;
  int joint = 0;
  std::string because;
};

/// The joints that the solvers report differently, the most telling kinds of difference first: only after what drivers
/// and springs do was subtracted, only in the joint's axes, on the other side or on one side only, in torques alone, or
/// the wrench itself. `ambiguous`: joints that are left out, because their wrenches are not unique; empty: none.
std::vector<ReportFault> find_report_faults(const Model& model, const std::vector<EvaluatedState>& states,
                                            const std::vector<bool>& ambiguous);

}  // namespace concord::compare
