#include "compare/resolution/run_check.h"

#include <fmt/format.h>

#include <map>
#include <numeric>

#include "common/error.h"
#include "compare/audit/carried_components.h"
#include "compare/audit/kept_start.h"
#include "compare/audit/reported_coordinates.h"
#include "compare/quantities/needs.h"
#include "compare/resolution/resolution.h"
#include "compare/resolution/uniqueness.h"
#include "compare/states/states.h"

namespace concord::compare {

namespace {

/// Refusals of the same kind are reported once, with their number and the first one's words.
class Refusals {
 public:
  void take(const std::string& words) {
    if (count_++ == 0) first_ = words;
  }

  void tell(std::size_t samples, const char* what, std::vector<std::string>& failures) const {
    if (count_ == 0) return;
    failures.push_back(fmt::format("{} in {} of {} samples: {}", what, count_, samples, first_));
  }

 private:
  int count_ = 0;
  std::string first_;
};

void check_samples(const QuantityLayout& layout, Solver& solver, const Trajectory& trajectory, RunCheck& check) {
  const auto columns = static_cast<Eigen::Index>(trajectory.samples.size());
  check.unique = Mask::Constant(static_cast<Eigen::Index>(layout.quantities().size()), columns, false);
  Mask open_in = check.unique;
  Refusals open;
  Refusals singular;
  for (Eigen::Index column = 0; column < columns; ++column) {
    const State& state = trajectory.samples[static_cast<std::size_t>(column)].state;
    try {
      solver.evaluate(state);
      const RankReport report = solver.rank(state);
      check.unique.col(column) = unique_rows(layout, report);
      open_in.col(column) = open_rows(layout, report);
    } catch (const SingularPose& error) {
      singular.take(error.what());
    } catch (const SolverError& error) {
      open.take(error.what());
    }
  }
  std::vector<Eigen::Index> all(trajectory.samples.size());
  std::iota(all.begin(), all.end(), 0);
  leave_out_isolated(check.unique, open_in, all);
  open.tell(trajectory.samples.size(), "the solver does not accept its own states", check.failures);
  singular.tell(trajectory.samples.size(), "singular pose", check.failures);
}

}  // namespace

RunCheck check_run(const QuantityLayout& layout, Solver& solver, const Trajectory& trajectory,
                   const RunOptions& options) {
  RunCheck check;
  Auditor auditor(layout.model());
  const Redraw redraw = answers_within_roundoff(layout.model(), solver, kSeed);
  for (const Sample& sample : trajectory.samples) {
    static_cast<void>(layout.observe_to_judge(sample.state, sample.evaluation, solver.name()));  // throws if it cannot
    auditor.add(sample.state, sample.evaluation, redraw);
  }
  check_samples(layout, solver, trajectory, check);
  check.audit = auditor.report();
  check.energy = audit_energy(layout.model(), trajectory);
  check.energy_allowed = kEnergyPerTolerance * options.rtol;
  if (!check.audit.holds()) {
    check.failures.push_back(fmt::format("{} {}: {} (need {:g})", solver.name(), breach_of(check.audit.worst.rule),
                                         check.audit.worst.text(), need_of(check.audit.worst.rule)));
  }
  const KeptStart start = audit_kept_start(layout.model(), trajectory);
  if (!start.holds()) check.failures.push_back(fmt::format("{} {}", solver.name(), start.text()));
  const ReportedCoordinate reported = audit_reported_coordinates(layout.model(), trajectory);
  if (!reported.holds()) check.failures.push_back(fmt::format("{} {}", solver.name(), reported.text()));
  if (!(check.energy.relative() <= check.energy_allowed)) {
    check.failures.push_back(fmt::format("energy is not kept: relative error {:.2e} at t = {:.4g} s, allowed {:.1e}",
                                         check.energy.relative(), check.energy.t, check.energy_allowed));
  }
  return check;
}

std::string format_run_check(const QuantityLayout& layout, std::string_view solver, const RunCheck& check) {
  const Model& model = layout.model();
  std::map<std::pair<std::string, Eigen::Index>, std::string> components;  // by owner and number of samples
  for (std::size_t row = 0; row < layout.quantities().size(); ++row) {
    const Quantity& quantity = layout.quantities()[row];
    const bool is_reaction = quantity.kind == Kind::reaction;
    if (!is_reaction && !is_scalar_force(quantity.kind)) continue;
    if (is_reaction && !carries(*model.joints[quantity.owner].type, quantity.side, quantity.component)) continue;
    const Eigen::Index not_unique = (!check.unique.row(static_cast<Eigen::Index>(row))).count();
    if (not_unique == 0) continue;
    components[{describe_owner(model, quantity), not_unique}] += " " + describe_component(quantity);
  }
  std::string text;
  for (const auto& [where, names] : components) {
    text +=
        fmt::format("not unique in {} of {} samples: {}:{}\n", where.second, check.unique.cols(), where.first, names);
  }
  text += fmt::format("audit of {}: {}\nenergy drift: {}\n", solver, check.audit.worst.text(),
                      drift_text(check.energy, check.energy_allowed));
  for (const std::string& failure : check.failures) text += fmt::format("STOP {}: {}\n", model.name, failure);
  return text;
}

}  // namespace concord::compare
