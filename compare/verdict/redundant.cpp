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

std::string vectors_text(const Mat3X& vectors) {
  std::string text;
  for (Eigen::Index c = 0; c < vectors.cols(); ++c) {
    Vec3 v = vectors.col(c);
    Eigen::Index largest = 0;
    v.cwiseAbs().maxCoeff(&largest);
    if (v(largest) < 0.0) v = -v;
    v = (v.array().abs() < 1e-12).select(0.0, v);
    text += fmt::format("{}({:.6g}, {:.6g}, {:.6g})", text.empty() ? "" : " and ", v(0), v(1), v(2));
  }
  return text;
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
  return fmt::format("{}, {} but for its part along {} of {}{}", describe_owner(model, part.of),
                     part.of.component < 3 ? "F" : "T", vectors_text(part.left_out),
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
