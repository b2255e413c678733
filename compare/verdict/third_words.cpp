#include "compare/verdict/third_words.h"

#include <fmt/format.h>

#include <map>
#include <tuple>

#include "compare/audit/digits.h"
#include "compare/quantities/observe.h"

namespace concord::compare {

namespace {

/// A joint's side, a coupling or a body.
using Owner = std::tuple<Kind, int, int>;

/// All wrenches of a joint's side, and the forces on its speeds, count as its reactions.
Owner owner_of(const Quantity& quantity) {
  const bool of_joint = quantity.kind == Kind::reaction_global || quantity.kind == Kind::total;
  return {of_joint ? Kind::reaction : quantity.kind, quantity.owner, index(quantity.side)};
}

/// The digits by which a row is the worse, the fewer: of the worst pair.
double worst_of(const ThirdRow& row) { return std::min(row.digits(), row.between.digits); }

std::string who_is_off(const ThirdRow& row, Blame blame, const std::string& third) {
  const auto agree = [](std::string_view one, std::string_view other, const Accord& accord) {
    return fmt::format("{} and {} agree to {} digits", one, other, third_digits_text(accord.digits));
  };
  switch (blame) {
    case Blame::nobody:
      return "all agree";
    case Blame::cartesian:
      return fmt::format("{}, cartesian is off", agree("relative", third, row.shared[1]));
    case Blame::relative:
      return fmt::format("{}, relative is off", agree("cartesian", third, row.shared[0]));
    case Blame::third:
      return fmt::format("{}, {} is off", agree("cartesian", "relative", row.between), third);
    case Blame::unclear:
      return fmt::format("cartesian, relative and {} differ from each other", third);
  }
  return "";
}

std::string sentence(const Model& model, const ThirdRow& row, Blame blame, const std::string& third) {
  return fmt::format("{}: {}, {}, t = {:.4g} s: cartesian {:.10g}, relative {:.10g}, {} {:.10g} {}",
                     who_is_off(row, blame, third), describe_owner(model, row.quantity),
                     describe_component(row.quantity), row.t, row.values[0], row.values[1], third, row.values[2],
                     unit_of(model, row.quantity));
}

}  // namespace

std::string name_of(Blame blame, const std::string& third) {
  switch (blame) {
    case Blame::nobody:
      return "nobody";
    case Blame::cartesian:
      return "cartesian";
    case Blame::relative:
      return "relative";
    case Blame::third:
      return third;
    case Blame::unclear:
      return "unclear";
  }
  return "";
}

std::string word_of(Kind kind) {
  switch (kind) {
    case Kind::reaction_global:
      return "reaction, global";
    case Kind::total:
      return "total";
    case Kind::body_sum:
      return "sum";
    case Kind::acceleration:
      return "acceleration";
    case Kind::tau:
    case Kind::share:
    case Kind::coupling:
      return "force";
    default:
      return "reaction";
  }
}

std::vector<const ThirdRow*> worst_third_rows(const std::vector<ThirdRow>& rows,
                                              const std::function<bool(const ThirdRow&)>& chosen) {
  std::map<Owner, std::size_t> place;
  std::vector<const ThirdRow*> found;
  for (const ThirdRow& row : rows) {
    if (!chosen(row)) continue;
    const auto [known, is_new] = place.try_emplace(owner_of(row.quantity), found.size());
    if (is_new) {
      found.push_back(&row);
    } else if (worst_of(row) < worst_of(*found[known->second])) {
      found[known->second] = &row;
    }
  }
  return found;
}

std::string third_digits_text(double digits) { return digits < 0.05 ? "0" : format_digits(digits); }

void judge_third(const Model& model, Verdict& verdict) {
  if (!verdict.third) return;
  const ThirdReport& third = *verdict.third;
  const auto is_off = [](const ThirdRow& row) { return blame_in(row) != Blame::nobody; };
  for (const ThirdRow* row : worst_third_rows(third.rows, is_off)) {
    const Blame blame = blame_in(*row);
    std::string said = sentence(model, *row, blame, third.name);
    if (blame != Blame::third) {
      verdict.notes.push_back(std::move(said));
      continue;
    }
    verdict.findings.push_back(
        {fmt::format("{}, {} digits (need {:g})", said, third_digits_text(row->digits()), row->need),
         fmt::format("{}: both solvers say the same, and a program that shares nothing with them does not",
                     third.name)});
  }
  if (third.failed == 0) return;
  const std::string said = fmt::format("{} failed in {} of {} states: {}", third.name, third.failed,
                                       third.states + third.failed, third.first_failure);
  (third.states == 0 ? verdict.failures : verdict.notes).push_back(said);
}

}  // namespace concord::compare
