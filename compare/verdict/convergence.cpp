#include "compare/verdict/convergence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/audit/digits.h"
#include "compare/verdict/refinement.h"

namespace concord::compare {

namespace {

/// A change from one tolerance to the next is one draw of an error, whose size may be so many times larger.
constexpr double kOfOneDraw = 10.0;

/// Where one solver's run moves by so many times more than the other's, it is not the motion that is sensitive.
constexpr double kOneAlone = 1e4;

/// Rows that are judged on a check and miss their need, those with the fewest digits first.
std::vector<QuantityRow*> rows_that_miss(Verdict& verdict, Check check) {
  std::vector<QuantityRow*> missing;
  for (auto* rows : {&verdict.rows, &verdict.others}) {
    for (QuantityRow& row : *rows) {
      if (row.unique && digits_of(row, check) && !meets_need(row, check)) missing.push_back(&row);
    }
  }
  std::stable_sort(missing.begin(), missing.end(), [check](const QuantityRow* a, const QuantityRow* b) {
    return detail_of(*a, check).unexplained < detail_of(*b, check).unexplained;
  });
  return missing;
}

/// The largest change of a quantity from one tolerance to the other, of each solver [the quantity's unit].
std::array<double, 2> own_changes(const RunPair& looser, const RunPair& tighter, int row) {
  std::array<double, 2> changes{};
  for (std::size_t who = 0; who < 2; ++who) {
    changes[who] = (looser.series.values[who].row(row) - tighter.series.values[who].row(row)).cwiseAbs().maxCoeff();
  }
  return changes;
}

std::string tell(std::string_view what, double digits, const std::array<double, 2>& own, const RunPair& looser,
                 const RunPair& tighter, Check check) {
  return fmt::format(
      "{}: the runs do not converge as far as the verdict needs: {}: the solvers agree to {} digits at rtol {:g}, and "
      "from rtol {:g} on the cartesian run itself holds {} digits, the relative {}; the difference between the solvers "
      "is of that size: end the run earlier (--until), or lower the need with a reason",
      name_of(check), what, format_digits(digits), tighter.run.rtol, looser.run.rtol, format_digits(own[0]),
      format_digits(own[1]));
}

}  // namespace

bool reaches_needs(const Verdict& verdict, Check check, const RunPair& pair, double motion_need) {
  if (pair.motion.digits < motion_need) return false;
  const auto misses = [check](const QuantityRow& row) {
    return row.unique && digits_of(row, check) && !meets_need(row, check);
  };
  return std::none_of(verdict.rows.begin(), verdict.rows.end(), misses) &&
         std::none_of(verdict.others.begin(), verdict.others.end(), misses);
}

bool reaches_refined_needs(const Verdict& verdict, const RunPair& pair) {
  if (pair.motion.digits < verdict.need.refined) return false;
  const auto misses = [](const QuantityRow& row) {
    return row.unique && row.refined && detail_of(row, Check::refined).unexplained < row.need.refined;
  };
  return std::none_of(verdict.rows.begin(), verdict.rows.end(), misses) &&
         std::none_of(verdict.others.begin(), verdict.others.end(), misses);
}

std::array<bool, 2> have_converged(const QuantityLayout& layout, const RunPair& looser, const RunPair& tighter,
                                   const Verdict& verdict) {
  constexpr double kSpare = 1.0;  // digits
  const std::array<double, 2> of_motions = own_motion_digits(layout.model(), looser, tighter);
  std::array<bool, 2> converged{};
  for (std::size_t who = 0; who < 2; ++who) converged[who] = of_motions[who] >= verdict.need.refined + kSpare;
  for (const auto* rows : {&verdict.rows, &verdict.others}) {
    for (const QuantityRow& row : *rows) {
      if (!row.unique || !row.refined) continue;
      const int place = layout.row_of(row.quantity);
      const std::array<double, 2> own = own_changes(looser, tighter, place);
      const double scale = tighter.measured[static_cast<std::size_t>(place)].scale;
      for (std::size_t who = 0; who < 2; ++who) {
        converged[who] = converged[who] && matching_digits(own[who], scale) >= row.need.refined + kSpare;
      }
    }
  }
  return converged;
}

std::optional<std::string> find_unconverged(const QuantityLayout& layout, const RunPair& looser, const RunPair& tighter,
                                            Check check, double motion_need, std::optional<std::size_t> standing,
                                            Verdict& verdict) {
  const std::vector<QuantityRow*> missing = rows_that_miss(verdict, check);
  // The same state agrees, so that it is the motions that part: in all rows together, each relative to its scale.
  double apart = 0.0;
  std::array<double, 2> moved{};
  for (const QuantityRow* row : missing) {
    const int place = layout.row_of(row->quantity);
    const Measured& measured = tighter.measured[static_cast<std::size_t>(place)];
    const std::array<double, 2> own = own_changes(looser, tighter, place);
    apart = std::max(apart, measured.unexplained / measured.scale);
    for (std::size_t who = 0; who < 2; ++who) moved[who] = std::max(moved[who], own[who] / measured.scale);
  }
  if (apart > kOfOneDraw * (moved[0] + moved[1])) return std::nullopt;
  const auto may_move_alone = [standing](std::size_t who) { return standing == who; };
  const std::size_t more = moved[0] > moved[1] ? 0 : 1;
  if (moved[more] > kOneAlone * moved[1 - more] && !may_move_alone(more)) return std::nullopt;
  const std::array<double, 2> of_motions = own_motion_digits(layout.model(), looser, tighter);
  if (tighter.motion.digits < motion_need &&
      tighter.motion.digits < std::min(of_motions[0], of_motions[1]) - std::log10(kOfOneDraw)) {
    return std::nullopt;
  }
  const std::size_t farther = of_motions[0] < of_motions[1] ? 0 : 1;
  if (of_motions[1 - farther] - of_motions[farther] > std::log10(kOneAlone) && !may_move_alone(farther)) {
    return std::nullopt;
  }
  for (QuantityRow* row : missing) row->detail[static_cast<std::size_t>(check)].unconverged = true;
  if (missing.empty()) {
    return tell(tighter.motion.worst, tighter.motion.digits, of_motions, looser, tighter, check);
  }
  const Quantity& quantity = missing.front()->quantity;
  const int place = layout.row_of(quantity);
  const Measured& measured = tighter.measured[static_cast<std::size_t>(place)];
  std::array<double, 2> digits = own_changes(looser, tighter, place);
  for (double& one : digits) one = matching_digits(one, measured.scale);
  return tell(fmt::format("{}, {}, t = {:.4g} s", describe_owner(layout.model(), quantity),
                          describe_component(quantity), measured.t),
              measured.unexplained_digits, digits, looser, tighter, check);
}

}  // namespace concord::compare
