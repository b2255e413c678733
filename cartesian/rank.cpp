#include "cartesian/rank.h"

#include <Eigen/SPQRSupport>
#include <SuiteSparseQR.hpp>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <type_traits>
#include <utility>

#include "cartesian/reactions.h"
#include "common/decompositions.h"
#include "common/error.h"

namespace concord::cartesian {

static_assert(std::is_same_v<SparseIndex, SuiteSparse_long>);

namespace {

constexpr double kRankThreshold = 1e-10;
constexpr double kUndecidedBelow = 1e-8;
constexpr double kUndecidedAbove = 1e-12;
/// Rows that others leave less than this of are candidates of the null space: far above every threshold, far below
/// what independent rows leave.
constexpr double kCandidate = 1e-6;
/// The factor by which a threshold is moved, up and down, to see whether a flag depends on it.
constexpr double kEitherWay = 31.622776601683793;
constexpr Eigen::Index kDenseRows = 60;
constexpr Eigen::Index kShortestDenseRows = 500;

/// Rows in the order in which a QR factorization of the transposed matrix takes them: `live` ones first, then those
/// that are left over. R11 over the live rows, and how the others depend on them: row = dependence^T live rows + rest.
struct RowSelection {
  Eigen::Index live = 0;
  std::vector<Eigen::Index> order;
  MatX dependence;             // live x left over
  double smallest_live = 0.0;  // estimate of the smallest singular value of the live rows
};

/// Smallest singular value of an upper triangular matrix, by two rounds of inverse iteration; `solve` and
/// `solve_transposed` apply its inverse in place.
template <class Solve, class SolveTransposed>
double estimate_smallest(Eigen::Index size, const Solve& solve, const SolveTransposed& solve_transposed) {
  if (size == 0) return 0.0;
  VecX x = VecX::NullaryExpr(size, [](Eigen::Index k) { return k % 3 == 1 ? -1.0 : 1.0; }).normalized();
  double smallest = HUGE_VAL;
  for (int round = 0; round < 3; ++round) {
    solve_transposed(x);
    solve(x);
    const double growth = x.norm();
    if (!(growth > 0.0) || !std::isfinite(growth)) break;
    smallest = 1.0 / std::sqrt(growth);
    x /= growth;
  }
  return smallest;
}

template <class Triangle>
void select_from(const Triangle& R, RowSelection& selection) {
  const Eigen::Index live = selection.live;
  const MatX R11 = R.topLeftCorner(live, live);
  const auto triangle = R11.template triangularView<Eigen::Upper>();
  selection.dependence = R.topRightCorner(live, R.cols() - live);
  // Eigen's triangular solver reads the first entry of an empty matrix too.
  if (selection.dependence.size() > 0) triangle.solveInPlace(selection.dependence);
  selection.smallest_live = estimate_smallest(
      live, [&](VecX& x) { triangle.solveInPlace(x); }, [&](VecX& x) { triangle.transpose().solveInPlace(x); });
}

Eigen::Index count_live(const VecX& diagonal, double tolerance) {
  Eigen::Index live = 0;
  while (live < diagonal.size() && std::abs(diagonal(live)) > tolerance) ++live;
  return live;
}

/// Order of the columns of a matrix by column pivoting, those above the tolerance first; returns how many these are.
Eigen::Index pivot_columns(const MatX& columns, double tolerance, std::vector<Eigen::Index>& order) {
  const Eigen::ColPivHouseholderQR<MatX> qr(columns);
  const auto indices = qr.colsPermutation().indices();
  order.assign(indices.begin(), indices.end());
  return count_live(qr.matrixQR().diagonal(), tolerance);
}

RowSelection select_dense(const MatX& transposed, double tolerance) {
  RowSelection selection;
  const Eigen::ColPivHouseholderQR<MatX> qr(transposed);
  const auto indices = qr.colsPermutation().indices();
  selection.order.assign(indices.begin(), indices.end());
  selection.live = count_live(qr.matrixQR().diagonal(), tolerance);
  select_from(qr.matrixQR(), selection);
  return selection;
}

/// The rows that go first are selected among themselves, the others by their parts independent of these.
RowSelection select_dense_in_order(const MatX& transposed, const std::vector<bool>& goes_first, double tolerance) {
  std::vector<Eigen::Index> first;
  std::vector<Eigen::Index> then;
  for (Eigen::Index row = 0; row < transposed.cols(); ++row) (goes_first[row] ? first : then).push_back(row);
  std::vector<Eigen::Index> order;
  const Eigen::Index live_first = pivot_columns(transposed(Eigen::all, first), tolerance, order);
  RowSelection selection;
  std::vector<Eigen::Index> left_over;
  for (std::size_t k = 0; k < order.size(); ++k) {
    (static_cast<Eigen::Index>(k) < live_first ? selection.order : left_over).push_back(first[order[k]]);
  }
  const Eigen::HouseholderQR<MatX> qr_first(transposed(Eigen::all, selection.order));
  const MatX turned = qr_first.householderQ().transpose() * MatX(transposed(Eigen::all, then));
  const Eigen::Index live_then = pivot_columns(turned.bottomRows(turned.rows() - live_first), tolerance, order);
  for (std::size_t k = 0; k < order.size(); ++k) {
    (static_cast<Eigen::Index>(k) < live_then ? selection.order : left_over).push_back(then[order[k]]);
  }
  selection.live = live_first + live_then;
  selection.order.insert(selection.order.end(), left_over.begin(), left_over.end());
  const Eigen::HouseholderQR<MatX> qr(transposed(Eigen::all, selection.order));
  select_from(qr.matrixQR(), selection);
  return selection;
}

/// SuiteSparseQR leaves over a row whose part independent of its predecessors is below the tolerance.
RowSelection select_sparse(const SparseMatrix& transposed, double tolerance) {
  Eigen::SPQR<SparseMatrix> qr;
  qr.setPivotThreshold(tolerance);
  qr.compute(transposed);
  RowSelection selection;
  selection.live = static_cast<Eigen::Index>(qr.rank());
  const auto indices = qr.colsPermutation().indices();
  selection.order.assign(indices.begin(), indices.end());
  const SparseMatrix R = qr.matrixR();
  const SparseMatrix R11 = R.topLeftCorner(selection.live, selection.live);
  const auto triangle = R11.triangularView<Eigen::Upper>();
  selection.dependence = triangle.solve(MatX(R.topRightCorner(selection.live, transposed.cols() - selection.live)));
  const SparseMatrix R11_transposed = R11.transpose();
  const auto transposed_triangle = R11_transposed.triangularView<Eigen::Lower>();
  selection.smallest_live = estimate_smallest(
      selection.live, [&](VecX& x) { triangle.solveInPlace(x); },
      [&](VecX& x) { transposed_triangle.solveInPlace(x); });
  return selection;
}

RowSelection select_rows(const SparseMatrix& transposed, const std::vector<bool>* goes_first, double tolerance) {
  if (goes_first != nullptr) return select_dense_in_order(MatX(transposed), *goes_first, tolerance);
  return transposed.cols() > kDenseRows ? select_sparse(transposed, tolerance)
                                        : select_dense(MatX(transposed), tolerance);
}

/// Largest singular value, by rounds of power iteration on the transposed matrix; a few per cent off.
double estimate_largest(const SparseMatrix& transposed) {
  VecX x = VecX::Ones(transposed.cols()).normalized();
  double largest = 0.0;
  for (int round = 0; round < 8; ++round) {
    const VecX image = transposed * x;
    largest = std::max(largest, image.norm());
    x = transposed.transpose() * image;
    const double size = x.norm();
    if (!(size > 0.0)) break;
    x /= size;
  }
  for (Eigen::Index row = 0; row < transposed.cols(); ++row) {
    largest = std::max(largest, transposed.col(row).norm());
  }
  return largest > 0.0 ? largest : 1.0;
}

/// The parts of the left-over rows that are independent of all others, and their singular values (C50).
void decide_left_over(const SparseMatrix& transposed, const RowSelection& selection, double largest,
                      RankDecision& decision) {
  const Eigen::Index n = transposed.cols();
  const Eigen::Index left_over = n - selection.live;
  MatX Z = MatX::Zero(n, left_over);
  for (Eigen::Index column = 0; column < left_over; ++column) {
    for (Eigen::Index k = 0; k < selection.live; ++k) Z(selection.order[k], column) = -selection.dependence(k, column);
    Z(selection.order[selection.live + column], column) = 1.0;
  }
  const MatX rest = transposed * Z;
  Z = orthonormal_columns(Z);
  decision.near_values = VecX::Zero(left_over);
  constexpr double kFarBelow = 1e-2;
  const double bound = rest.norm() / largest;  // of all of them: Z had unit vectors on the left-over rows
  decision.near_null_space = Z;
  decision.largest_dropped = bound;
  Eigen::Index added = 0;
  if (!(bound <= kFarBelow * kRankThreshold / kEitherWay)) {
    const Eigen::JacobiSVD<MatX> svd(MatX(transposed * Z), Eigen::ComputeFullV);
    VecX values = VecX::Zero(left_over);
    values.head(svd.singularValues().size()) = svd.singularValues() / largest;
    decision.near_values = values.reverse();
    decision.near_null_space = Z * svd.matrixV().rowwise().reverse();
    decision.largest_dropped = 0.0;
    for (const double value : values) {
      if (value > kRankThreshold) {
        ++added;
        decision.smallest_kept = std::min(decision.smallest_kept, value);
      } else {
        decision.largest_dropped = std::max(decision.largest_dropped, value);
      }
    }
  }
  std::vector<Eigen::Index> order(left_over);
  std::iota(order.begin(), order.end(), 0);
  if (added > 0) (void)pivot_columns(rest, 0.0, order);
  for (Eigen::Index k = 0; k < added; ++k) decision.independent[selection.order[selection.live + order[k]]] = true;
  decision.rank += static_cast<int>(added);
  decision.left_null_space = decision.near_null_space.leftCols(left_over - added);
}

/// How far multipliers of the null space move what a joint reports: rows are the reactions of both sides (12), totals
/// of both sides (12), coordinate forces (C51).
class Movement {
 public:
  Movement(const Equations& equations, int k, const ScaledJacobian& scaled, const MatX& null_space)
      : n_u_(equations.model().joints[k].type->n_u()) {
    const Joint& stated = equations.model().joints[k];
    const JointEquations& joint = equations.constraints().joint(k);
    const auto n_own = static_cast<Eigen::Index>(joint.rows.size());
    MatX of_rows(24 + n_u_, n_own);
    for (Eigen::Index row = 0; row < n_own; ++row) {
      const JointWrenches wrenches = compute_wrenches(stated, joint, VecX::Unit(n_own, row), nullptr);
      of_rows.col(row) << wrenches.reaction[0].in_C.vector(), wrenches.reaction[1].in_C.vector(),
          wrenches.total[0].in_C.vector(), wrenches.total[1].in_C.vector(), wrenches.tau;
    }
    MatX own(n_own, null_space.cols());
    for (Eigen::Index z = 0; z < null_space.cols(); ++z) {
      own.col(z) = equations.constraints().joint_multipliers(k, scaled.row_scale.cwiseProduct(null_space.col(z)));
    }
    moved_ = of_rows * own;
    VecX units = VecX::Zero(24 + n_u_);  // largest that a unit multiplier of the scaled rows moves
    for (int row = 0; row < joint.n_rows; ++row) {
      units = units.cwiseMax(of_rows.col(row).cwiseAbs() * scaled.row_scale(joint.first_row + row));
    }
    for (const CoupledShare& share : joint.shares) {
      units = units.cwiseMax(of_rows.col(share.row).cwiseAbs() *
                             std::abs(share.factor * scaled.row_scale(share.coupling_row)));
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

void mark_joint(const Movement& movement, const NullSpaceSizes& sizes, const VecX& values, JointUniqueness& unique,
                JointUniqueness& decided) {
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
  }
}

/// Rows that hold for positions, where there are others; nullptr else.
const std::vector<bool>* rows_that_go_first(const Constraints& constraints, std::vector<bool>& rows) {
  if (!constraints.has_nonholonomic_rows()) return nullptr;
  for (int row = 0; row < constraints.n_rows(); ++row) rows.push_back(constraints.holds_positions(row));
  return &rows;
}

}  // namespace

RankDecision decide_rank(const SparseMatrix& matrix, const std::vector<bool>* goes_first) {
  RankDecision decision;
  if (matrix.rows() == 0) return decision;
  if (!Eigen::Map<const VecX>(matrix.valuePtr(), matrix.nonZeros()).allFinite()) {
    throw SolverError(
        "cartesian: the Jacobian of the constraints holds an entry that is not a number: its rank cannot be decided");
  }
  const SparseMatrix transposed = matrix.transpose();
  const RowSelection selection = select_rows(transposed, goes_first, kCandidate);
  const double largest = estimate_largest(transposed);
  decision.rank = static_cast<int>(selection.live);
  decision.smallest_kept = selection.smallest_live / largest;
  decision.independent.assign(matrix.rows(), false);
  for (Eigen::Index k = 0; k < selection.live; ++k) decision.independent[selection.order[k]] = true;
  decision.left_null_space = decision.near_null_space = MatX::Zero(matrix.rows(), 0);
  if (selection.live < matrix.rows()) decide_left_over(transposed, selection, largest, decision);
  return decision;
}

VecX solve_shortest(const SparseMatrix& matrix, const VecX& right_side) {
  constexpr double kDependent = 1e-8;  // rows that depend on others to this are left out of a Newton step
  constexpr int kPlaceOfRank = 4;      // in SuiteSparseQR's statistics
  cholmod_common common;
  cholmod_l_start(&common);
  SparseMatrix copy = matrix;
  copy.makeCompressed();
  cholmod_sparse view = Eigen::viewAsCholmod(copy);
  VecX b = right_side;
  cholmod_dense b_view = Eigen::viewAsCholmod(b);
  cholmod_dense* solution = SuiteSparseQR_min2norm<double>(SPQR_ORDERING_DEFAULT, kDependent, &view, &b_view, &common);
  VecX x = VecX::Constant(matrix.cols(), std::numeric_limits<double>::quiet_NaN());
  if (solution != nullptr) {
    x = Eigen::Map<const VecX>(static_cast<const double*>(solution->x), matrix.cols());
    cholmod_l_free_dense(&solution, &common);
  }
  const bool has_full_rank = common.SPQR_istat[kPlaceOfRank] == matrix.rows();
  cholmod_l_finish(&common);
  if (has_full_rank || matrix.rows() > kShortestDenseRows) return x;
  // Of a matrix that lacks rank SuiteSparseQR gives a solution, but not the shortest.
  return smallest_least_squares(MatX(matrix), right_side, kDependent);
}

ScaledJacobian scaled_jacobian(const Equations& equations) {
  const Constraints& constraints = equations.constraints();
  const Layout& layout = equations.layout();
  const VecX& units = equations.units();
  ScaledJacobian scaled;
  scaled.row_scale = equations.row_sizes().unaryExpr([](double size) { return size > 0.0 ? 1.0 / size : 1.0; });
  std::vector<Eigen::Triplet<double, SparseIndex>> entries;
  for (const RowBlock& block : constraints.blocks()) {
    const Eigen::Ref<const MatX> Phi_Y_transposed = constraints.columns(block);
    for (int row = block.first_row; row < block.first_row + block.n_rows; ++row) {
      for (int c = 0; c < layout.size_Y(block.body); ++c) {
        const int column = layout.first_Y(block.body) + c;
        const double value = Phi_Y_transposed(c, row - block.first_row) * units(column) * scaled.row_scale(row);
        entries.emplace_back(row, column, value);
      }
    }
  }
  scaled.matrix = SparseMatrix(constraints.n_rows(), layout.n_Y());
  scaled.matrix.setFromTriplets(entries.begin(), entries.end());
  return scaled;
}

RowChoice choose_rows(const Equations& equations, int expected) {
  constexpr double kWell = 1e-2;  // what others leave of a row that is well independent of them
  const SparseMatrix matrix = scaled_jacobian(equations).matrix;
  std::vector<bool> rows;
  const std::vector<bool>* goes_first = rows_that_go_first(equations.constraints(), rows);
  if (matrix.rows() > kDenseRows) {
    const RowSelection selection = select_rows(matrix.transpose(), goes_first, kWell);
    if (selection.live == expected) {
      RowChoice choice{expected, std::vector<bool>(matrix.rows(), false)};
      for (int k = 0; k < expected; ++k) choice.independent[selection.order[k]] = true;
      return choice;
    }
  }
  RankDecision decision = decide_rank(matrix, goes_first);
  return {decision.rank, std::move(decision.independent)};
}

RowChoice choose_rows_beside(const Equations& equations, int expected) {
  RowChoice choice = choose_rows(equations, expected);
  if (choice.rank <= expected) return choice;
  constexpr double kHigher = 10.0;
  const SparseMatrix transposed = scaled_jacobian(equations).matrix.transpose();
  std::vector<bool> rows;
  const std::vector<bool>* goes_first = rows_that_go_first(equations.constraints(), rows);
  double tolerance = kRankThreshold;
  RowSelection selection = select_rows(transposed, goes_first, tolerance);
  while (selection.live > expected) {
    tolerance *= kHigher;
    RowSelection fewer = select_rows(transposed, goes_first, tolerance);
    if (fewer.live < expected) break;
    selection = std::move(fewer);
  }
  choice = {expected, std::vector<bool>(static_cast<std::size_t>(transposed.cols()), false)};
  for (int k = 0; k < expected; ++k) choice.independent[selection.order[k]] = true;
  return choice;
}

std::vector<bool> independent_rows(const Equations& equations) { return choose_rows(equations, -1).independent; }

MatX permitted_velocities(const Equations& equations) {
  const Layout& layout = equations.layout();
  const MatX transposed = MatX(scaled_jacobian(equations).matrix).transpose();
  MatX null_space = MatX::Identity(layout.n_Y(), layout.n_Y());
  if (transposed.cols() > 0) {
    Eigen::ColPivHouseholderQR<MatX> qr(transposed);
    qr.setThreshold(kRankThreshold);
    const MatX Q = qr.householderQ();
    null_space = Q.rightCols(layout.n_Y() - qr.rank());
  }
  null_space = equations.units().asDiagonal() * null_space;
  const double length = equations.model().length_scale();
  for (int i = 1; i < layout.n_bodies(); ++i) null_space.middleRows<3>(layout.first_Y(i)) /= length;
  return orthonormal_columns(null_space);
}

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
  report.joints.resize(constraints.n_joints());
  report.decided.resize(constraints.n_joints());
  report.unique_coupling.assign(constraints.n_couplings(), true);
  report.decided_coupling.assign(constraints.n_couplings(), true);
  const auto count_below = [&](double threshold) {
    return static_cast<Eigen::Index>((decision.near_values.array() <= threshold).count());
  };
  const NullSpaceSizes sizes{count_below(kRankThreshold / kEitherWay), count_below(kRankThreshold),
                             count_below(kRankThreshold * kEitherWay)};
  if (sizes.perhaps == 0) return report;
  const MatX& null_space = decision.near_null_space;
  for (int k = 0; k < constraints.n_joints(); ++k) {
    mark_joint(Movement(equations, k, scaled, null_space), sizes, decision.near_values, report.joints[k],
               report.decided[k]);
  }
  for (int g = 0; g < constraints.n_couplings(); ++g) {
    const VecX own = null_space.row(constraints.coupling(g).row);
    const UniquenessAnswer force = decide_unique(sizes, own, decision.near_values);
    report.unique_coupling[g] = force.is_unique;
    report.decided_coupling[g] = force.stays;
  }
  return report;
}

}  // namespace concord::cartesian
