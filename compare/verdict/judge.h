#pragma once

#include <vector>

#include "compare/audit/balance.h"
#include "compare/audit/kept_start.h"
#include "compare/audit/reported_coordinates.h"
#include "compare/quantities/agreement.h"
#include "compare/resolution/weighed_states.h"
#include "compare/verdict/refinement.h"
#include "compare/verdict/verdict.h"

/// From what both solvers found to a verdict: the judge of runs and of analyses. These choose which values are compared
/// and in which states; the judge holds them against their scale, what double precision resolves, where they are unique
/// and what is needed.
namespace concord::compare {

/// Fills in one verdict, check by check; who judges a check, or looks at its rows, finds those of the checks before.
class Judge {
 public:
  /// `checks`: those that the verdict needs, in their order. Layout and verdict must outlive the judge.
  Judge(const QuantityLayout& layout, std::vector<Check> checks, Verdict& verdict);

  /// Name and size of the machine, names of the solvers, and the needs.
  void describe(const std::array<Solver*, 2>& solvers);

  /// Every row's scale and digits, resolvable digits too, on a check: from the values of both solvers, where `budget`
  /// says that they are unique and how far double precision resolves them. Replaces what the check said before.
  std::vector<Measured> measure_check(const Series& series, const Budget& budget, Check check);

  /// Adds a finding for each joint, force element or body that misses a need on a check, and on none before.
  void find_differences_on(const Series& series, const std::vector<Measured>& measured, Check check);

  /// Adds a finding for each difference between both solvers' ranks and uniqueness, and a failure for states that were
  /// dropped because of them. The findings move into the verdict.
  void judge_uniqueness(WeighedStates& weighed);

  /// Adds a failure if some states are singular: the first one's reason; the others are counted.
  void note_singular_states(const WeighedStates& weighed);

  /// The audit of one solver: its digits, and a finding if they miss their need. Nothing if no state was audited.
  void judge_audit(Who who, const AuditReport& found);

  /// Where the run of one solver starts: a finding if the model says otherwise.
  void judge_start(Who who, const KeptStart& found);

  /// The joint coordinates and speeds that one solver reports of its run: a finding if its bodies have others.
  void judge_reported(Who who, const ReportedCoordinate& found);

  /// Judges every row by its checks, sums up checks and audit.
  void judge_rows();

 private:
  const QuantityLayout& layout_;
  std::vector<Check> checks_;
  Verdict& verdict_;
  std::vector<Quantity> known_;  // named by a finding already
};

/// The outcome: failed if there is a failure, else differ if there is a finding, else agree.
void conclude(Verdict& verdict);

/// Of a comparison that agrees: a check that is not passed though nothing was found to differ there is a fault of the
/// comparator, and there is no verdict. A check on which nothing was judged counts as passed.
void require_passed_checks(Verdict& verdict);

}  // namespace concord::compare
