#include <fmt/format.h>

#include "compare/analyses/judge_steps.h"
#include "compare/analyses/kinematics.h"
#include "compare/quantities/align.h"
#include "compare/report/force_table.h"

namespace concord::compare::analyses {

AnalysisVerdict judge_kinematics(const Model& asked, const SolverMakers& makers, const VerifyOptions& options) {
  Model model = asked;
  AnalysisVerdict result;
  result.analysis = "kinematics";
  const Solvers solvers = make_solvers(model, makers, result);
  const RunOptions run = run_options(model, options);
  result.wrenches.run = run;
  std::array<Trajectory, 2> found;
  for (const Who who : kBothSolvers) found[index(who)] = run_kinematics(model, *solvers[index(who)], run);
  judge_wrenches(model, solvers, found, Found::motion, result);
  result.text +=
      fmt::format("{:g} s in {} steps; peak reactions by cartesian:\n{}", run.until, run.samples,
                  format_peaks(model, found[0], result.wrenches.unique ? &*result.wrenches.unique : nullptr));
  conclude(result);
  return result;
}

}  // namespace concord::compare::analyses
