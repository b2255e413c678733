#include "compare/audit/audit_ledger.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "compare/audit/digits.h"

namespace concord::compare {

namespace {

constexpr double kLeastShare = 1e-6;  // of the machine's largest
/// Round-off of a sum in which the largest terms take part: no residual below it is a breach.
constexpr double kRoundOff = 100.0 * std::numeric_limits<double>::epsilon();

bool is_worse(const AuditFinding& one, const AuditFinding& other) {
  const double spare = one.digits - need_of(one.rule);
  const double other_spare = other.digits - need_of(other.rule);
  if (spare != other_spare) return spare < other_spare;
  return one.residual * other.scale > other.residual * one.scale;
}

}  // namespace

std::string_view name_of(AuditRule rule) {
  constexpr std::array<std::string_view, kAuditRules> names{"free body",   "workless",  "both sides", "two frames",
                                                            "drivers",     "force law", "kinematics", "driver law",
                                                            "derivatives", "modal data"};
  return names[static_cast<std::size_t>(rule)];
}

std::string_view breach_of(AuditRule rule) {
  switch (rule) {
    case AuditRule::kinematics:
    case AuditRule::driver_law:
      return "does not move as joints and laws say";
    case AuditRule::derivatives:
      return "is given a wrong derivative";
    case AuditRule::modal_data:
      return "is given wrong modes";
    default:
      return "is not in balance";
  }
}

double need_of(AuditRule rule) {
  switch (rule) {
    case AuditRule::kinematics:
    case AuditRule::driver_law:
    case AuditRule::derivatives:
      return kAuditByDifferences;
    default:
      return kAudit;
  }
}

std::string AuditFinding::text() const {
  if (row.empty()) return fmt::format("{}: nothing to audit", name_of(rule));
  return fmt::format("{}: {}, {}, t = {:.6g} s: residual {:.2e}, scale {:.3g}, {} digits", name_of(rule), where, row, t,
                     residual, scale, format_digits(digits));
}

void keep_worse(AuditFinding& kept, const AuditFinding& other) {
  if (other.row.empty()) return;
  if (kept.row.empty() || is_worse(other, kept)) kept = other;
}

void AuditRow::take(double new_residual, double new_scale, double at_t) {
  if (std::isnan(new_residual)) new_residual = std::numeric_limits<double>::infinity();
  if (new_residual > residual) {
    residual = new_residual;
    t = at_t;
  }
  scale = std::max(scale, new_scale);
}

void AuditEntity::take(const VecX& residuals, const AuditScales& scales, double at_t) {
  for (std::size_t r = 0; r < rows.size(); ++r) {
    rows[r].take(std::abs(residuals(static_cast<Eigen::Index>(r))), scales[index(rows[r].unit)], at_t);
  }
}

AuditFinding AuditEntity::worst(AuditRule rule, const AuditScales& largest, const AuditScales& terms) const {
  AuditFinding found;
  found.rule = rule;
  found.where = name;
  for (const AuditRow& row : rows) {
    if (row.rule != rule) continue;
    const double floor = (is_idle ? 1.0 : kLeastShare) * largest[index(row.unit)];
    const double scale = std::max(row.scale, floor);
    const double breach = std::max(0.0, row.residual - kRoundOff * terms[index(row.unit)]);
    keep_worse(found,
               {matching_digits(breach, scale), row.residual, scale, row.t, rule, name, row.name, row.scale < floor});
  }
  return found;
}

int AuditEntity::count(AuditRule rule) const {
  return static_cast<int>(
      std::count_if(rows.begin(), rows.end(), [rule](const AuditRow& row) { return row.rule == rule; }));
}

void AuditEntity::raise(AuditScales& largest) const {
  for (const AuditRow& row : rows) {
    if (row.unit == AuditUnit::own) continue;
    largest[index(row.unit)] = std::max(largest[index(row.unit)], row.scale);
  }
}

}  // namespace concord::compare
