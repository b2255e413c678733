#pragma once

#include <span>
#include <vector>

#include "compare/quantities/agreement.h"
#include "compare/verdict/verdict.h"

/// From measured digits to judgements, check by check.
namespace concord::compare {

/// Tolerances are divided by this where runs miss their needs, and at most on the refined check.
inline constexpr double kTighter = 100.0;
/// And by this at first on the refined check: enough to see an integration error fall, little enough to stay away from
/// round-off.
inline constexpr double kTighterAtFirst = 10.0;

/// Relative tolerance of the refined run, so many times tighter, but not below kTightestTolerance.
double refined_tolerance(double rtol, double times = kTighterAtFirst);

/// How many times tighter than the same run the refined check has to be, from the digits that the same run reached:
/// kTighterAtFirst, if digits that rise as the tolerance falls lead every row, and the motions, to their need on the
/// refined check; else as many that the rise which is required then leads them there, at most kTighter.
double tightening_asked(const Verdict& verdict);

/// Digits by which a row has to rise from the same run to a refined one of relative tolerance `refined`, if it does not
/// reach its need: kRisePerDigit of the digits between their tolerances, which count from kTighterAtFirst to kTighter.
double required_rise(double rtol, double refined);
/// The same for the refined runs of a verdict, or those that it would make.
double required_rise(const Verdict& verdict);

/// What the rows have to rise by if the refined runs have this relative tolerance.
void set_refined_tolerance(Verdict& verdict, double refined);

std::optional<double> digits_of(const QuantityRow& row, Check check);
double need_of(const QuantityRow& row, Check check);
const CheckSummary& summary_of(const Verdict& verdict, Check check);
const CheckDetail& detail_of(const QuantityRow& row, Check check);

/// Whether a row misses its need by what double precision cannot resolve there: round-off is no difference.
bool is_judged_by_resolution(const QuantityRow& row, Check check);
/// On any of them.
bool is_judged_by_resolution(const QuantityRow& row);

/// Whether a row differs in some state by so many resolutions that it is no round-off, however small the difference is;
/// never where the model lowered the need, and in the same state only: runs differ by integration errors.
bool is_beyond_round_off(const QuantityRow& row, Check check);

/// Whether what a row differs by beyond round-off stays within its need on a check, and is not beyond all round-off;
/// refined: its need, or the required rise above its same run. False if the check did not run or did not judge the row.
bool meets_need(const QuantityRow& row, Check check);

/// How many digits a row stands above its need on a check; negative where meets_need() is false, however small the
/// difference is. kMostDigits where the check says nothing of the row.
double margin(const QuantityRow& row, Check check);

/// Checks that judge a quantity: all three, but accelerations at the same state only.
bool judges(Check check, Kind kind);

/// Rows of all quantities: reactions that the joints can carry in `rows`, the rest in `others`.
void make_rows(const QuantityLayout& layout, Verdict& verdict);

/// Fills the digits of one check into all rows, and the scale where it is still missing.
void record(const QuantityLayout& layout, const std::vector<Measured>& measured, Check check, Verdict& verdict);

/// Whether a row is judged at all: it is unique in some state, and double precision resolves enough of it.
bool is_judged(const QuantityRow& row);

/// Whether the total of joints that share what they carry was judged.
bool has_judged_sums(const Verdict& verdict);

/// Whether anything was judged: a reaction component, a force element, a force on a joint speed (driver, spring,
/// actuator, coupling) where no reaction is unique, or the total of joints that share what they carry.
bool has_judged(const Verdict& verdict);

/// Whether any of those that is judged carries more than nothing.
bool carries_something(const Verdict& verdict);

/// Judges every row by the checks that the verdict needs, in their order, and sums these up: `judged`, `total`, worst
/// digits over the judged rows, whether they hold.
void judge(Verdict& verdict, std::span<const Check> checks = kChecks);

}  // namespace concord::compare
