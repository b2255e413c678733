#include "compare/verdict/carried.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

namespace concord::compare {

namespace {

bool is_component(const QuantityRow& row) {
  return row.quantity.kind == Kind::reaction || row.quantity.kind == Kind::element;
}

bool is_on_speed(const QuantityRow& row) { return is_scalar_force(row.quantity.kind); }

/// The rows that give a check its digits: components, or forces on speeds where no component is judged.
std::vector<const QuantityRow*> rows_that_carry(const Verdict& verdict) {
  std::vector<const QuantityRow*> components;
  std::vector<const QuantityRow*> on_speeds;
  for (const auto* rows : {&verdict.rows, &verdict.others}) {
    for (const QuantityRow& row : *rows) {
      if (row.judgement != Judgement::agree) continue;
      if (is_component(row)) components.push_back(&row);
      if (is_on_speed(row)) on_speeds.push_back(&row);
    }
  }
  return components.empty() ? on_speeds : components;
}

/// Rows that pass one check in one way.
struct Fewer {
  std::string how;
  int rows = 0;
  double need = 0.0;  // the largest that they do not reach

  void add(double missed) {
    ++rows;
    need = std::max(need, missed);
  }
};

/// The ways to pass a check with fewer digits than are needed.
struct Ways {
  Fewer round_off{"within round-off"};
  Fewer rise{""};
  Fewer lowered{"the model lowers the need"};
  int without = 0;

  /// `standard`: what the comparator asks of a model that says nothing.
  void add(const QuantityRow& row, Check check, double standard) {
    const auto digits = digits_of(row, check);
    const double need = need_of(row, check);
    if (!digits) {
      ++without;
    } else if (is_judged_by_resolution(row, check) && detail_of(row, check).unexplained >= need) {
      round_off.add(need);
    } else if (*digits < need) {
      rise.how = fmt::format("risen by {:.3g} digits", row.required_rise);
      rise.add(need);
    } else if (*digits < standard && !row.need.because.empty()) {
      lowered.add(standard);
    }
  }

  void add(const PairSum& sum, double need) {
    if (sum.samples > 0 && sum.digits < need) round_off.add(need);
  }

  [[nodiscard]] std::vector<std::string> words(std::size_t all) const {
    std::vector<std::string> said;
    for (const Fewer& way : {round_off, rise, lowered}) {
      if (way.rows > 0) said.push_back(fmt::format("{} of {} below {:g} digits, {}", way.rows, all, way.need, way.how));
    }
    if (without > 0) said.push_back(fmt::format("{} of {} not judged there", without, all));
    return said;
  }
};

template <class Items, class Condition>
int number_of(const Items& items, const Condition& condition) {
  return static_cast<int>(std::count_if(items.begin(), items.end(), condition));
}

}  // namespace

std::string passed_with_less(const Verdict& verdict, Check check) {
  const CheckSummary& summary = summary_of(verdict, check);
  if (!summary.passed) return "";
  const std::vector<const QuantityRow*> rows = rows_that_carry(verdict);
  std::vector<std::string> said;
  Ways ways;
  for (const QuantityRow* row : rows) ways.add(*row, check, need_of(verdict.need, check));
  if (rows.empty() && check == Check::same_state) {
    for (const PairSum& sum : verdict.pair_sums) ways.add(sum, verdict.need.same_state);
    said = ways.words(verdict.pair_sums.size());
  } else {
    said = ways.words(rows.size());
  }
  if (rows.empty() && !summary.digits) said.emplace_back("by the sums on bodies alone");
  if (summary.horizon) said.push_back(fmt::format("up to t = {:.4g} s of {:g} s", *summary.horizon, verdict.run.until));
  return fmt::format("{}", fmt::join(said, "; "));
}

std::string judged_instead(const Verdict& verdict) {
  if (verdict.outcome == Outcome::failed || count_components(verdict).judged > 0) return "";
  std::vector<std::string> judged;
  const auto add = [&](int number, const char* one, const char* several) {
    if (number > 0) judged.push_back(fmt::format("{} {}", number, number == 1 ? one : several));
  };
  add(number_of(verdict.pair_sums, [](const PairSum& sum) { return sum.samples > 0; }),
      "total of joints that share what they carry", "totals of joints that share what they carry");
  add(number_of(verdict.others,
                [](const QuantityRow& row) { return is_on_speed(row) && row.judgement == Judgement::agree; }),
      "force on a joint speed", "forces on joint speeds");
  if (judged.empty()) return "";
  const auto is_unique = [](const QuantityRow& row) { return is_component(row) && row.unique; };
  const bool any = number_of(verdict.rows, is_unique) + number_of(verdict.others, is_unique) > 0;
  return fmt::format("no single component is {}; judged instead: {}", any ? "resolved" : "unique",
                     fmt::join(judged, " and "));
}

}  // namespace concord::compare
