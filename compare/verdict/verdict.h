#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/results.h"
#include "common/run_options.h"
#include "compare/attribution/cause.h"
#include "compare/audit/audit_ledger.h"
#include "compare/audit/cures.h"
#include "compare/audit/energy.h"
#include "compare/audit/geometric_stiffness.h"
#include "compare/quantities/agreement.h"
#include "compare/quantities/motions.h"
#include "compare/quantities/needs.h"
#include "compare/quantities/quantity.h"
#include "compare/quantities/sums.h"
#include "compare/quantities/third_opinion.h"
#include "compare/resolution/orders.h"
#include "compare/resolution/partly_unique.h"
#include "compare/states/draws.h"
#include "compare/states/start_report.h"
#include "compare/verdict/two_by_two.h"

/// All that the comparator found about one model.
namespace concord::compare {

enum class Outcome { agree, differ, failed };
enum class Judgement { agree, differ, not_judged };

/// "agree", "differ", "failed"; "agree", "differ", "not judged".
std::string to_string(Outcome outcome);
std::string to_string(Judgement judgement);

/// 0 agree, 1 differ, 3 could not finish.
int exit_code(Outcome outcome);

/// What stands behind the digits of one row on one check.
struct CheckDetail {
  /// What its differences are held against there, in its unit: a run may reach less than the states of all checks.
  double scale = 0.0;
  /// Digits of what exceeds round-off: these are compared with the need.
  double unexplained = 16.0;
  /// Digits that double precision resolves, -log10(resolution / scale); missing where that is unknown.
  std::optional<double> resolvable;
  /// The largest ratio of a difference to its resolution.
  double ratio = 0.0;
  int samples = 0;     // in which the row is judged
  int not_unique = 0;  // in which it is not unique
  int too_coarse = 0;  // in which double precision resolves too little to judge
  bool unresolved = false;
  /// Differs by no more than what the integration of the solvers leaves, at the tightest tolerance: not judged.
  bool unconverged = false;
};

/// One quantity through all checks. Digits are missing where a check did not run or does not judge it.
struct QuantityRow {
  Quantity quantity;
  double scale = 0.0;
  ScaleSource source = ScaleSource::own_peak;
  /// Whether it is unique in any state that is judged.
  bool unique = true;
  std::array<CheckDetail, 3> detail;  // by check
  std::optional<double> same_state;
  std::optional<double> same_run;
  std::optional<double> refined;
  std::array<double, 3> worst_t{};  // time of the largest difference at the same state, in the same run, refined [s]
  Needs need;
  /// By how many digits the refined check has to exceed the same run where it does not reach its need.
  double required_rise = 2.0 * kRisePerDigit;
  Judgement judgement = Judgement::not_judged;
};

/// One check over all judged components of reactions and of force elements; of forces on joint speeds where there are
/// none of these. At the same state the joints' sums on pairs of bodies count where they are too few, or alone.
struct CheckSummary {
  std::optional<double> digits;  // worst, missing if the check did not run
  int samples = 0;
  bool carries = false;  // whether any force that is judged is not exactly zero
  bool passed = false;
  /// The last time that is judged, where the motion is too sensitive beyond it [s].
  std::optional<double> horizon;
};

struct SolverSummary {
  std::string name;
  std::string integrator;
  std::vector<std::string> cut_joints;
  RankReport rank;
  SolverStatistics statistics;
  std::optional<double> audit_digits;
  /// The audit's finding that is farthest below its need, or nearest to it, and that need.
  std::string audit_worst;
  double audit_need = kAudit;
  std::optional<double> energy_error;  // relative, of what exceeds round-off
  std::optional<EnergyReport> energy;  // with the drift itself; where there is an energy_error
};

/// What a component of a reference is found to be; what is off would be equal in another convention, or is one of
/// infinitely many values that fit the motion.
enum class ReferenceWord { equal, other_convention, one_of_many, wrong, not_judged };
/// "equal", "equal in another convention", "one of infinitely many", "wrong", "not judged".
std::string to_string(ReferenceWord word);

/// One component against a reference from outside.
struct ReferenceRow {
  std::string of;  // "joint D on slider"
  std::string component;
  std::string unit;
  double peak = 0.0;     // of the reference
  double allowed = 0.0;  // the error of its source, in the component's unit
  /// Largest differences of both solvers from it, and the time of the larger one.
  std::array<double, 2> differences{};
  double t = 0.0;
  double stated = 0.0;  // what the reference says there, in which line of its file
  int line = 0;
  ReferenceWord word = ReferenceWord::not_judged;  // so where no time of it is within reach
  std::string hint;                                // "it has the other sign": what would fit; empty: nothing
  /// For pictures: what it says at which times, of a component of a joint's reaction or of a force element's wrench in
  /// the frame of its side; else nothing.
  std::optional<Quantity> quantity = {};
  std::vector<double> times = {};   // s
  std::vector<double> values = {};  // in the component's unit
};

/// Whether a component is judged, and its numbers are not those that were expected.
bool is_off(const ReferenceRow& row);

struct Verdict {
  Outcome outcome = Outcome::failed;
  std::string name;
  int bodies = 0;
  int joints = 0;
  int loops = 0;
  int modes = 0;
  RunOptions run;
  bool integrates = true;  // without runs the states at the start, near it and a short step later are judged
  std::optional<double> refined_rtol;  // relative tolerance of the runs that the refined check judged
  std::uint64_t seed = kSeed;          // of the random states
  Needs need;
  std::array<SolverSummary, 2> solvers;
  double energy_allowed = 0.0;  // of their energy_error, by the tolerance that was asked for: a repeat may be tighter

  std::vector<QuantityRow> rows;  // reaction components that the joints can carry
  std::vector<QuantityRow>
      others;  // forces on speeds, total wrenches, global components, elements, accelerations, sums
  /// Components of reactions that are unique and resolved in some state, of all: whether or not a check judged them,
  /// see count_reactions().
  int judged = 0;
  int total = 0;

  bool rank_agrees = false;
  /// States at singular poses, and perturbed states that mean different things to the solvers: left out and counted.
  int singular_states = 0;
  int drawn_anew = 0;
  CheckSummary same_state;
  CheckSummary same_run;
  CheckSummary refined;
  CheckSummary audit;
  std::optional<MotionAgreement> motion;
  std::optional<MotionAgreement> refined_motion;
  std::vector<PairSum> pair_sums;
  std::vector<PartlyUnique> partly_unique;
  std::optional<PlanarLoops> planar;  // where what is not unique lies across the plane of the machine's loops
  Cures cures;                        // of redundant constraints, in the first state that is judged
  std::string reference_file;         // empty: none
  std::vector<ReferenceRow> references;
  std::optional<ThirdReport> third;  // what another program says, if one was asked for

  /// Of a difference: who is to blame, where and for which term; and whether motions or equations differ.
  std::optional<Attribution> attribution;
  std::optional<TwoByTwo> two_by_two;
  /// How each solver's runs converge; where runs differ, or if it was asked for. Explains, and is never judged.
  std::optional<Orders> orders;

  std::optional<StartReport> start;  // missing where no solver finds one

  std::vector<Finding> findings;  // differences, worst of each joint first
  /// Of the first run that there is, over all its samples; nothing where there is none.
  std::optional<std::vector<GeometricStiffness>> geometric_stiffness;
  std::vector<std::string> notes;     // what the reader must know, no difference
  std::vector<std::string> failures;  // why there is no verdict

  /// The body in whose axes wrenches are told, 0: global axes; missing: each in the frame of its own side.
  std::optional<int> axes;

  /// What both solvers find unique in the samples of these trajectories; missing where the check did not run.
  std::optional<Mask> unique;
  /// Both trajectories of the same run; empty where a solver did not finish.
  std::array<std::optional<Trajectory>, 2> trajectories;
};

/// How many components have a judgement, of how many. Where a run stops on its way none has.
struct ComponentCount {
  int judged = 0;
  int total = 0;
};
ComponentCount count_reactions(const Verdict& verdict);
/// Of reactions and force elements.
ComponentCount count_components(const Verdict& verdict);

/// Leaves the first of equal lines, and drops lines with which an earlier one ends, as after "same run: ".
void leave_out_repeated(std::vector<std::string>& lines);

/// Whether both runs keep their energy as far as is asked.
bool keeps_energy(const Verdict& verdict);
bool keeps_energy(const Verdict& verdict, const SolverSummary& solver);  // one of them

}  // namespace concord::compare
