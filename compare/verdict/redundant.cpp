#include "compare/verdict/redundant.h"

#include <fmt/format.h>

#include <algorithm>

#include "compare/audit/digits.h"

namespace concord::compare {

namespace {

void judge_pair_sums(const QuantityLayout& layout, const WeighedStates& weighed, const std::vector<Measured>& measured,
                     Verdict& verdict) {
  verdict.pair_sums = compare_pair_sums(layout, weighed.states, measured, weighed.budget());
  const double need = verdict.need.same_state;
  for (const PairSum& pair : verdict.pair_sums) {
    if (pair.holds(need) || !verdict.findings.empty()) continue;
    verdict.findings.push_back(
        {fmt::format("sum of {}: {} digits (need {:.1f})", pair.what, format_digits(pair.digits), need),
         "same state: the joints' total on the body differs"});
  }
}

void judge_partly_unique(const QuantityLayout& layout, const WeighedStates& weighed,
                         const std::vector<Measured>& measured, Verdict& verdict) {
  verdict.partly_unique = partly_unique(layout, weighed, measured);
  for (const PartlyUnique& part : verdict.partly_unique) {
    const double need = need_of(verdict, part);
    if (part.holds(need) || !verdict.findings.empty()) continue;
    verdict.findings.push_back(
        {fmt::format("{}: {} digits (need {:g})", describe(layout.model(), part), format_digits(part.digits), need),
         "same state: the part that redundant constraints do not leave open differs"});
  }
}

/// With the sign that makes its largest component positive.
std::string vector_text(const Vec3& direction) {
  constexpr double kNothing = 1e-12;
  Eigen::Index largest = 0;
  direction.cwiseAbs().maxCoeff(&largest);
  const double sign = direction(largest) < 0.0 ? -1.0 : 1.0;
  const Vec3 told = (direction.array().abs() < kNothing).select(0.0, sign * direction);
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", told(0), told(1), told(2));
}

}  // namespace

double need_of(const Verdict& verdict, const PartlyUnique& part) {
  double need = verdict.need.same_state;
  for (const QuantityRow& row : verdict.rows) {
    const Quantity& one = row.quantity;
    const bool is_in = one.kind == part.of.kind && one.owner == part.of.owner && one.side == part.of.side &&
                       one.component / 3 == part.of.component / 3;
    if (is_in) need = std::min(need, row.need.same_state);
  }
  return need;
}

std::string describe(const Model& model, const PartlyUnique& part) {
  const Attachment& side = model.joints[static_cast<std::size_t>(part.of.owner)].on(part.of.side);
  const bool is_line = part.left_out.cols() == 2;
  const Vec3 direction = is_line ? Vec3(part.left_out.col(0).cross(part.left_out.col(1))) : Vec3(part.left_out.col(0));
  return fmt::format("{}, {} {} {} of {}{}", describe_owner(model, part.of), part.of.component < 3 ? "F" : "T",
                     is_line ? "only along" : "but for its part along", vector_text(direction),
                     model.bodies[static_cast<std::size_t>(side.body)].name,
                     part.is_fixed ? "" : fmt::format(" at t = {:.4g} s", part.t));
}

void judge_redundant(const QuantityLayout& layout, const WeighedStates& weighed, const std::vector<Measured>& measured,
                     Verdict& verdict) {
  judge_pair_sums(layout, weighed, measured, verdict);
  judge_partly_unique(layout, weighed, measured, verdict);
  verdict.planar = planar_loops(layout.model(), weighed);
  for (std::size_t k = 0; k < weighed.states.size(); ++k) {
    if (!weighed.singular[k].empty()) continue;
    if (weighed.reports[k][0].rank == weighed.reports[k][0].constraints) continue;
    verdict.cures = find_cures(layout.model(), weighed.states[k].state);
    break;
  }
}

}  // namespace concord::compare
