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

/// The joint that the solvers report differently, the most telling kind of difference first: only after what drivers
/// and springs do was subtracted, only in the joint's axes, on one side only, in torques by a lever times the force, or
/// the wrench itself. Nothing if all joints agree.
std::optional<ReportFault> find_report_fault(const Model& model, const std::vector<EvaluatedState>& states);

}  // namespace concord::compare
