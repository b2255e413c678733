#include "cartesian/rank/uniqueness.h"

#include <algorithm>
#include <cmath>

#include "cartesian/dynamics/reactions.h"
#include "cartesian/rank/constraint_rank.h"
#include "common/products.h"

namespace concord::cartesian {

namespace {

constexpr double kUndecidedBelow = 1e-8;
constexpr double kUndecidedAbove = 1e-12;

/// How far multipliers of the null space move what a joint reports: rows are the reactions of both sides (12), totals
/// of both sides (12), coordinate forces, those of drivers alone (C51).
class NullSpaceEffect {
 public:
  NullSpaceEffect(const Equations& equations, JointIndex k, const ScaledJacobian& scaled, const MatX& null_space)
      : n_u_(pick(equations.model().joints, k).type->n_u()) {
    const Joint& stated = pick(equations.model().joints, k);
    const JointEquations& joint = equations.moving_constraints().joint(k);
    const auto n_own = static_cast<Eigen::Index>(joint.rows.size());
    MatX of_rows(24 + 2 * n_u_, n_own);
    for (Eigen::Index row = 0; row < n_own; ++row) {
      const JointWrenches wrenches = compute_wrenches(stated, joint, VecX::Unit(n_own, row), nullptr);
      of_rows.col(row) << wrenches.reaction[0].in_C.vector(), wrenches.reaction[1].in_C.vector(),
          wrenches.total[0].in_C.vector(), wrenches.total[1].in_C.vector(), wrenches.tau,
          wrenches.share_of(Actor::driver);
    }
    MatX own(n_own, null_space.cols());
    for (Eigen::Index z = 0; z < null_space.cols(); ++z) {
      own.col(z) = joint_multipliers(joint, scaled.row_scale.cwiseProduct(null_space.col(z)));
    }
    moved_ = product(of_rows, own);
    VecX units = VecX::Zero(24 + 2 * n_u_);  // largest that a unit multiplier of the scaled rows moves
    for (int row = 0; row < joint.n_rows; ++row) {
      units = units.cwiseMax(of_rows.col(row).cwiseAbs() * scaled.row_scale(joint.row(row).value));
    }
    for (const CoupledShare& share : joint.shares) {
      units = units.cwiseMax(of_rows.col(share.row).cwiseAbs() *
                             std::abs(share.factor * scaled.row_scale(share.coupling_row.value)));
    }
    choose_scales(units, equations.model().length_scale());
  }

  [[nodiscard]] int n_u() const { return n_u_; }
  /// What each column of the null space moves component c by, relative to what unit multipliers do to the joint.
  [[nodiscard]] VecX of(int c) const {
    if (!(scales_(c) > 0.0)) return VecX::Zero(moved_.cols());
    return moved_.row(c).transpose() / scales_(c);
  }

 private:
  /// Forces and torques of a side by the largest of both, a torque being a force on the machine's length: round-off of
  /// a torque that the joint never passes is small beside its forces.
  void choose_scales(const VecX& units, double length) {
    scales_ = units;
    for (int side = 0; side < 4; ++side) {
      const double force =
          std::max(units.segment<3>(6 * side).maxCoeff(), units.segment<3>(6 * side + 3).maxCoeff() / length);
      scales_.segment<3>(6 * side).setConstant(force);
      scales_.segment<3>(6 * side + 3).setConstant(force * length);
    }
  }

  int n_u_;
  MatX moved_;
  VecX scales_;
};

/// Sizes of the null space at the threshold and at the thresholds moved to either side.
struct NullSpaceSizes {
  Eigen::Index surely;
  Eigen::Index decided;
  Eigen::Index perhaps;
};

struct UniquenessAnswer {
  bool is_unique;
  bool stays;
};

/// (C51) Of a component that each column of the near null space moves by as much as `moves` says, and with which
/// singular values.
UniquenessAnswer decide_unique(const NullSpaceSizes& sizes, const VecX& moves, const VecX& values) {
  constexpr double kZero = 1e-9;
  // Rows that are nearly dependent by s leave about that much of themselves along rows that they do not concern.
  constexpr double kLeft = 10.0;
  const VecX concerned = (moves.cwiseAbs() - kLeft * values).cwiseMax(0.0);
  const bool is_unique = moves.head(sizes.decided).norm() <= kZero;
  // One threshold is moved at a time.
  const bool stays_unique = concerned.head(sizes.perhaps).norm() <= kZero * kEitherWay &&
                            concerned.head(sizes.decided).norm() <= kZero / kEitherWay;
  const bool stays_moved =
      moves.head(sizes.surely).norm() > kZero && moves.head(sizes.decided).norm() > kZero * kEitherWay;
  return {is_unique, is_unique ? stays_unique : stays_moved};
}

void mark_joint(const NullSpaceEffect& movement, const NullSpaceSizes& sizes, const VecX& values,
                JointUniqueness& unique, JointUniqueness& decided) {
  const auto at = [&](int c) { return decide_unique(sizes, movement.of(c), values); };
  for (int c = 0; c < 12; ++c) {
    const UniquenessAnswer reaction = at(c);
    unique.unique[c / 6][c % 6] = reaction.is_unique;
    decided.unique[c / 6][c % 6] = reaction.stays;
    const UniquenessAnswer total = at(12 + c);
    unique.unique_total[c / 6][c % 6] = total.is_unique;
    decided.unique_total[c / 6][c % 6] = total.stays;
  }
  for (int c = 0; c < movement.n_u(); ++c) {
    const UniquenessAnswer tau = at(24 + c);
    unique.unique_tau[c] = tau.is_unique;
    decided.unique_tau[c] = tau.stays;
    const UniquenessAnswer driver = at(24 + movement.n_u() + c);
    unique.unique_driver[c] = driver.is_unique;
    decided.unique_driver[c] = driver.stays;
  }
}

}  // namespace

RankReport report_rank(const Equations& equations) {
  const Constraints& constraints = equations.constraints();
  const ScaledJacobian scaled = scaled_jacobian(equations);
  const RankDecision decision = decide_rank(scaled.matrix);
  RankReport report;
  report.constraints = constraints.n_rows();
  report.rank = decision.rank;
  report.degrees_of_freedom = equations.layout().n_Y() - decision.rank;
  report.smallest_kept = decision.smallest_kept;
  report.largest_dropped = decision.largest_dropped;
  const auto in_doubt = [](double value) { return value > kUndecidedAbove && value < kUndecidedBelow; };
  report.undecided = in_doubt(decision.smallest_kept) || in_doubt(decision.largest_dropped);
  report.joints.resize(equations.model().joints.size());
  report.decided.resize(equations.model().joints.size());
  report.unique_coupling.assign(equations.model().couplings.size(), true);
  report.decided_coupling.assign(equations.model().couplings.size(), true);
  const auto count_below = [&](double threshold) {
    return static_cast<Eigen::Index>((decision.near_values.array() <= threshold).count());
  };
  const NullSpaceSizes sizes{count_below(kRankThreshold / kEitherWay), count_below(kRankThreshold),
                             count_below(kRankThreshold * kEitherWay)};
  if (sizes.perhaps == 0) return report;
  const MatX& null_space = decision.near_null_space;
  for (const JointIndex k : constraints.joints()) {
    mark_joint(NullSpaceEffect(equations, k, scaled, null_space), sizes, decision.near_values, report.joints[k.value],
               report.decided[k.value]);
  }
  for (const CouplingIndex g : constraints.couplings()) {
    const VecX own = null_space.row(constraints.coupling(g).row.value);
    const UniquenessAnswer force = decide_unique(sizes, own, decision.near_values);
    report.unique_coupling[g.value] = force.is_unique;
    report.decided_coupling[g.value] = force.stays;
  }
  return report;
}

}  // namespace concord::cartesian
