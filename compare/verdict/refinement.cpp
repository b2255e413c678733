#include "compare/verdict/refinement.h"

#include <algorithm>
#include <cmath>

#include "compare/audit/carried_components.h"
#include "compare/audit/digits.h"
#include "compare/quantities/observe.h"

namespace concord::compare {

double refined_tolerance(double rtol, double times) {
  return std::min(rtol, std::max(rtol / times, kTightestTolerance));
}

double required_rise(double rtol, double refined) {
  return kRisePerDigit * std::log10(std::clamp(rtol / refined, kTighterAtFirst, kTighter));
}

double required_rise(const Verdict& verdict) {
  return required_rise(verdict.run.rtol, verdict.refined_rtol.value_or(refined_tolerance(verdict.run.rtol)));
}

void set_refined_tolerance(Verdict& verdict, double refined) {
  verdict.refined_rtol = refined;
  for (auto* rows : {&verdict.rows, &verdict.others}) {
    for (QuantityRow& row : *rows) row.required_rise = required_rise(verdict);
  }
}

namespace {

constexpr std::optional<double> QuantityRow::*digits_at(Check check) {
  switch (check) {
    case Check::same_state:
      return &QuantityRow::same_state;
    case Check::same_run:
      return &QuantityRow::same_run;
    default:
      return &QuantityRow::refined;
  }
}

constexpr CheckSummary Verdict::*summary_at(Check check) {
  switch (check) {
    case Check::same_state:
      return &Verdict::same_state;
    case Check::same_run:
      return &Verdict::same_run;
    default:
      return &Verdict::refined;
  }
}

/// The kinds whose worst digits stand for a check.
bool gives_digits(Kind kind) { return kind == Kind::reaction || kind == Kind::element; }

/// Those, and forces on joint speeds: all that there is to judge where no joint constrains anything.
bool is_force(Kind kind) { return gives_digits(kind) || is_scalar_force(kind); }

}  // namespace

std::optional<double> digits_of(const QuantityRow& row, Check check) { return row.*digits_at(check); }

double need_of(const QuantityRow& row, Check check) { return need_of(row.need, check); }

const CheckSummary& summary_of(const Verdict& verdict, Check check) { return verdict.*summary_at(check); }

bool is_beyond_round_off(const QuantityRow& row, Check check) {
  return check == Check::same_state && !row.need.same_state_lowered && detail_of(row, check).ratio > kBeyondRoundOff;
}

bool meets_need(const QuantityRow& row, Check check) {
  const std::optional<double> digits = digits_of(row, check);
  if (!digits || is_beyond_round_off(row, check)) return false;
  if (detail_of(row, check).unexplained >= need_of(row, check)) return true;
  return check == Check::refined && row.same_run && *digits >= *row.same_run + row.required_rise;
}

double margin(const QuantityRow& row, Check check) {
  const std::optional<double> digits = digits_of(row, check);
  if (!digits) return kMostDigits;
  const double above = detail_of(row, check).unexplained - need_of(row, check);
  if (is_beyond_round_off(row, check))
    return std::min(above, std::log10(kBeyondRoundOff / detail_of(row, check).ratio));
  const bool may_rise = check == Check::refined && row.same_run.has_value();
  return may_rise ? std::max(above, *digits - (*row.same_run + row.required_rise)) : above;
}

const CheckDetail& detail_of(const QuantityRow& row, Check check) {
  return row.detail[static_cast<std::size_t>(check)];
}

double tightening_asked(const Verdict& verdict) {
  double missing = verdict.motion ? verdict.need.refined - verdict.motion->digits : 0.0;
  for (const auto* rows : {&verdict.rows, &verdict.others}) {
    for (const QuantityRow& row : *rows) {
      if (!row.unique || !row.same_run) continue;
      missing = std::max(missing, row.need.refined - detail_of(row, Check::same_run).unexplained);
    }
  }
  if (missing <= std::log10(kTighterAtFirst)) return kTighterAtFirst;
  return std::min(std::pow(10.0, missing / kRisePerDigit), kTighter);
}

bool is_judged_by_resolution(const QuantityRow& row, Check check) {
  const std::optional<double> digits = digits_of(row, check);
  return digits && *digits < need_of(row, check) && detail_of(row, check).unexplained > *digits;
}

bool is_judged_by_resolution(const QuantityRow& row) {
  return std::any_of(kChecks.begin(), kChecks.end(), [&](Check check) { return is_judged_by_resolution(row, check); });
}

bool judges(Check check, Kind kind) { return check == Check::same_state || kind != Kind::acceleration; }

void make_rows(const QuantityLayout& layout, Verdict& verdict) {
  const Model& model = layout.model();
  for (const Quantity& quantity : layout.quantities()) {
    QuantityRow row;
    row.quantity = quantity;
    row.need = needs_of(model, quantity);
    if (quantity.kind != Kind::reaction) {
      verdict.others.push_back(row);
      continue;
    }
    const Joint& joint = model.joints[quantity.owner];
    if (!carries(*joint.type, quantity.side, quantity.component)) continue;
    verdict.rows.push_back(row);
  }
}

namespace {

/// Whether the check ran for the row, and double precision or redundancy kept it from being judged there.
bool is_left_out(const QuantityRow& row, Check check) {
  const CheckDetail& detail = detail_of(row, check);
  return detail.samples == 0 && detail.not_unique + detail.too_coarse > 0;
}

CheckDetail detail_from(const Measured& found) {
  CheckDetail detail;
  detail.scale = found.scale;
  detail.unexplained = found.unexplained_digits;
  if (found.resolution > 0.0) detail.resolvable = matching_digits(found.resolution, found.scale);
  detail.ratio = found.ratio;
  detail.samples = found.samples;
  detail.not_unique = found.not_unique;
  detail.too_coarse = found.too_coarse;
  detail.unresolved = found.unresolved;
  return detail;
}

}  // namespace

void record(const QuantityLayout& layout, const std::vector<Measured>& measured, Check check, Verdict& verdict) {
  const auto& quantities = layout.quantities();
  std::size_t place = 0;
  const auto fill = [&](QuantityRow& row) {
    while (quantities[place] != row.quantity) ++place;  // rows keep the layout's order
    const Measured& found = measured[place];
    if (row.scale == 0.0) {
      row.scale = found.scale;
      row.source = found.source;
    }
    // The first check that runs says where a row is unique.
    if (check == Check::same_state) row.unique = found.samples + found.too_coarse > 0;
    CheckSummary& summary = verdict.*summary_at(check);
    summary.carries = summary.carries || (row.unique && found.scale > 0.0 && is_force(row.quantity.kind));
    if (!judges(check, row.quantity.kind)) return;
    (row.*digits_at(check)).reset();
    row.detail[static_cast<std::size_t>(check)] = detail_from(found);
    if (found.samples == 0) return;
    row.*digits_at(check) = found.digits;
    row.worst_t[static_cast<std::size_t>(check)] = found.t;
  };
  for (QuantityRow& row : verdict.rows) fill(row);
  place = 0;
  for (QuantityRow& row : verdict.others) fill(row);
}

bool is_judged(const QuantityRow& row) { return row.unique && !is_left_out(row, Check::same_state); }

bool has_judged_sums(const Verdict& verdict) {
  return std::any_of(verdict.pair_sums.begin(), verdict.pair_sums.end(),
                     [](const PairSum& sum) { return sum.samples > 0; });
}

bool has_judged(const Verdict& verdict) {
  const auto is_judged_force = [](const QuantityRow& row) { return is_force(row.quantity.kind) && is_judged(row); };
  const auto is_unresolved = [](const QuantityRow& row) { return row.unique && !is_judged(row); };
  if (verdict.judged > 0 || has_judged_sums(verdict)) return true;
  return std::none_of(verdict.rows.begin(), verdict.rows.end(), is_unresolved) &&
         std::any_of(verdict.others.begin(), verdict.others.end(), is_judged_force);
}

bool carries_something(const Verdict& verdict) {
  const auto carries = [](const QuantityRow& row) {
    return row.unique && row.scale > 0.0 && is_force(row.quantity.kind);
  };
  const auto sum_carries = [](const PairSum& sum) {
    const Wrench& wrench = sum.at_start[0];
    return sum.samples > 0 && (wrench.force.norm() > 0.0 || wrench.torque.norm() > 0.0);
  };
  return std::any_of(verdict.rows.begin(), verdict.rows.end(), carries) ||
         std::any_of(verdict.others.begin(), verdict.others.end(), carries) ||
         std::any_of(verdict.pair_sums.begin(), verdict.pair_sums.end(), sum_carries);
}

namespace {

/// What joints between the same bodies carry together is judged as well; its digits are shown where they are too few,
/// or where no row has any.
void take_sums(const Verdict& verdict, CheckSummary& summary) {
  const bool has_rows = summary.digits.has_value();
  for (const PairSum& sum : verdict.pair_sums) {
    if (sum.samples == 0) continue;
    const bool holds = sum.holds(verdict.need.same_state);
    summary.passed = summary.passed && holds;
    if (!holds || !has_rows) summary.digits = std::min(summary.digits.value_or(kMostDigits), sum.digits);
  }
}

void sum_up(Check check, Verdict& verdict) {
  CheckSummary& summary = verdict.*summary_at(check);
  summary.passed = has_judged(verdict);
  std::optional<double> on_speeds;
  std::optional<double> of_sums;
  const auto take = [&](const QuantityRow& row) {
    if (!row.unique || !judges(check, row.quantity.kind) || is_left_out(row, check)) return;
    summary.passed = summary.passed && meets_need(row, check);
    const auto digits = digits_of(row, check);
    if (digits && row.quantity.kind == Kind::body_sum) of_sums = std::min(of_sums.value_or(kMostDigits), *digits);
    if (!digits || !is_force(row.quantity.kind)) return;
    std::optional<double>& worst = gives_digits(row.quantity.kind) ? summary.digits : on_speeds;
    worst = std::min(worst.value_or(kMostDigits), *digits);
  };
  for (const QuantityRow& row : verdict.rows) take(row);
  for (const QuantityRow& row : verdict.others) take(row);
  if (!summary.digits) summary.digits = on_speeds;
  if (check == Check::same_state) take_sums(verdict, summary);
  // A check on which nothing was judged has not been passed.
  summary.passed = summary.passed && (summary.digits || (has_judged_sums(verdict) && of_sums));
}

}  // namespace

void judge(Verdict& verdict, std::span<const Check> checks) {
  const auto judge_row = [checks](QuantityRow& row) {
    if (!is_judged(row)) return;
    row.judgement = Judgement::agree;
    for (const Check check : checks) {
      if (!judges(check, row.quantity.kind) || is_left_out(row, check) || meets_need(row, check)) continue;
      if (digits_of(row, check) && !detail_of(row, check).unconverged) row.judgement = Judgement::differ;
      // A check that did not run, or did not converge, decides about no solver.
      if (row.judgement == Judgement::agree) row.judgement = Judgement::not_judged;
    }
  };
  for (QuantityRow& row : verdict.rows) judge_row(row);
  for (QuantityRow& row : verdict.others) judge_row(row);
  verdict.total = static_cast<int>(verdict.rows.size());
  verdict.judged = static_cast<int>(
      std::count_if(verdict.rows.begin(), verdict.rows.end(), [](const QuantityRow& row) { return is_judged(row); }));
  for (const Check check : checks) sum_up(check, verdict);
}

}  // namespace concord::compare
