#include "compare/verdict/findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "compare/audit/digits.h"
#include "compare/quantities/align.h"
#include "compare/quantities/symptom.h"

namespace concord::compare {

namespace {

/// The fewest significant digits that show the difference.
std::string with_enough_digits(double value, double digits) {
  return fmt::format("{:+.{}g}", value, std::clamp(static_cast<int>(std::floor(digits)) + 3, 3, 17));
}

struct Shortfall {
  const QuantityRow* row;
  double missing;
};

enum class OwnerKind { joint, coupling, element, body };

OwnerKind owner_kind(const Quantity& quantity) {
  if (quantity.kind == Kind::acceleration || quantity.kind == Kind::body_sum) return OwnerKind::body;
  if (quantity.kind == Kind::coupling) return OwnerKind::coupling;
  return quantity.kind == Kind::element ? OwnerKind::element : OwnerKind::joint;
}

bool is_same_owner(const Quantity& a, const Quantity& b) {
  return owner_kind(a) == owner_kind(b) && a.owner == b.owner;
}

/// What is reported first: on the same state a force element, whose wrench follows from the state alone while
/// everything else follows from it; then reactions; then what follows from them.
int order_of(const Quantity& quantity, Check check) {
  if (check == Check::same_state && quantity.kind == Kind::element) return 0;
  return quantity.kind == Kind::reaction ? 1 : 2;
}

/// Every failing row of a check, causes first, then the largest shortfall first.
std::vector<Shortfall> shortfalls(const Verdict& verdict, Check check) {
  std::vector<Shortfall> found;
  for (const auto* rows : {&verdict.rows, &verdict.others}) {
    for (const QuantityRow& row : *rows) {
      const auto digits = digits_of(row, check);
      if (row.unique && digits && !meets_need(row, check)) {
        found.push_back({&row, need_of(row, check) - detail_of(row, check).unexplained});
      }
    }
  }
  std::stable_sort(found.begin(), found.end(), [check](const Shortfall& a, const Shortfall& b) {
    return std::pair(order_of(a.row->quantity, check), -a.missing) <
           std::pair(order_of(b.row->quantity, check), -b.missing);
  });
  return found;
}

}  // namespace

std::string describe(const Model& model, const Quantity& quantity, const Measured& measured, double need) {
  // Where resolution limits the digits, the reader must know how many there could have been.
  const double resolvable = matching_digits(measured.resolution, measured.scale);
  const std::string of = measured.resolution > 0.0 && resolvable < need + 2.0
                             ? fmt::format(" of {} resolvable", format_digits(resolvable))
                             : std::string();
  return fmt::format("{}, {}, t = {:.4g} s: cartesian {}, relative {} {}, {} digits{} (need {:g})",
                     describe_owner(model, quantity), describe_component(quantity), measured.t,
                     with_enough_digits(measured.values[0], measured.digits),
                     with_enough_digits(measured.values[1], measured.digits), unit_of(model, quantity),
                     measured.digits < 0.05 ? "0" : format_digits(measured.digits), of, need);
}

std::vector<Finding> find_differences(const QuantityLayout& layout, const Series& series,
                                      const std::vector<Measured>& measured, const Verdict& verdict, Check check,
                                      std::vector<Quantity>& known) {
  std::vector<Finding> findings;
  for (const Shortfall& shortfall : shortfalls(verdict, check)) {
    const Quantity& quantity = shortfall.row->quantity;
    if (std::any_of(known.begin(), known.end(), [&](const Quantity& one) { return is_same_owner(one, quantity); })) {
      continue;
    }
    if (quantity.kind == Kind::body_sum && !findings.empty()) continue;  // follows from the joints named already
    known.push_back(quantity);
    const int row = layout.row_of(quantity);
    const bool is_integration = check != Check::same_state && meets_need(*shortfall.row, Check::same_state);
    const std::string beyond =
        shortfall.missing <= 0.0 && is_beyond_round_off(*shortfall.row, check)
            ? fmt::format(", up to {:.2g} times what double precision resolves there", measured[row].ratio)
            : "";
    findings.push_back({describe(layout.model(), quantity, measured[row], need_of(*shortfall.row, check)) + beyond,
                        fmt::format("{}: {}{}", name_of(check), diagnose(layout, series, row),
                                    is_integration ? "; the same state agrees: the motions part" : "")});
  }
  return findings;
}

}  // namespace concord::compare
