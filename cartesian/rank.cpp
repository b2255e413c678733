#include "cartesian/rank.h"

#include <Eigen/SPQRSupport>
#include <SuiteSparseQR.hpp>
#include <algorithm>
#include <cmath>
#include <limits>

#include "cartesian/reactions.h"
#include "common/error.h"

namespace concord::cartesian {

namespace {

constexpr double kRankThreshold = 1e-10;
constexpr double kUndecidedBelow = 1e-8;
constexpr double kUndecidedAbove = 1e-12;
constexpr Eigen::Index kDenseRows = 500;

RankDecision decide_dense(const MatX& matrix) {
  RankDecision decision;
  const Eigen::BDCSVD<MatX> svd(matrix, Eigen::ComputeFullU);
  const VecX& values = svd.singularValues();
  const double largest = values.size() > 0 ? values(0) : 1.0;
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    const double relative = values(k) / largest;
    if (relative > kRankThreshold) {
      ++decision.rank;
      decision.smallest_kept = relative;
    } else {
      decision.largest_dropped = std::max(decision.largest_dropped, relative);
    }
  }
  decision.left_null_space = svd.matrixU().rightCols(matrix.rows() - decision.rank);
  const Eigen::ColPivHouseholderQR<MatX> qr(matrix.transpose());
  decision.independent.assign(matrix.rows(), false);
  for (int k = 0; k < decision.rank; ++k) decision.independent[qr.colsPermutation().indices()(k)] = true;
  return decision;
}

RankDecision decide_sparse(const SparseMatrix& matrix) {
  RankDecision decision;
  Eigen::SPQR<SparseMatrix> qr;
  qr.setPivotThreshold(kRankThreshold);
  qr.compute(SparseMatrix(matrix.transpose()));
  decision.rank = static_cast<int>(qr.rank());
  const auto n_rows = static_cast<Eigen::Index>(matrix.rows());
  const Eigen::Index nullity = n_rows - decision.rank;
  const SparseMatrix R = qr.matrixR();
  const VecX diagonal = R.diagonal().cwiseAbs();
  const VecX kept = diagonal.head(decision.rank);
  decision.smallest_kept = kept.minCoeff() / kept.maxCoeff();
  const auto order = qr.colsPermutation().indices();
  decision.independent.assign(n_rows, false);
  for (int k = 0; k < decision.rank; ++k) decision.independent[order(k)] = true;
  MatX Z = MatX::Zero(n_rows, nullity);
  if (nullity > 0) {
    const SparseMatrix R11 = R.topLeftCorner(decision.rank, decision.rank);
    const MatX R12 = MatX(R.topRightCorner(decision.rank, nullity));
    const MatX dependence = R11.triangularView<Eigen::Upper>().solve(R12);
    for (Eigen::Index column = 0; column < nullity; ++column) {
      for (int k = 0; k < decision.rank; ++k) Z(order(k), column) = -dependence(k, column);
      Z(order(decision.rank + column), column) = 1.0;
    }
    const Eigen::HouseholderQR<MatX> orthogonal(Z);
    Z = orthogonal.householderQ() * MatX::Identity(n_rows, nullity);
  }
  decision.left_null_space = Z;
  return decision;
}

/// Size of a mode's rate that moves some joint of its body by `length` per second.
double modal_size(const Model& model, int body, int mode, double length) {
  double largest = 0.0;
  for (const Joint& joint : model.joints) {
    for (const Attachment& side : joint.sides) {
      if (side.body != body) continue;
      largest = std::max(largest, side.Psi_t_L.col(mode).norm());
      largest = std::max(largest, side.Psi_r_L.col(mode).norm() * length);
    }
  }
  return largest > 0.0 ? length / largest : 1.0;
}

/// A component is unique if no multiplier of the null space moves it: relative to what unit multipliers do to the
/// joint's forces or torques. `null_space` holds the joint's own multipliers and those of its coupled coordinates.
void mark_uniqueness(const Joint& stated, const JointEquations& joint, const MatX& null_space,
                     JointUniqueness& uniqueness) {
  constexpr double kZero = 1e-9;
  const int n_u = stated.type->n_u();
  // Largest sizes: reactions of both sides (12), totals of both sides (12), coordinate forces.
  const auto largest = [&](const MatX& multipliers) {
    VecX sizes = VecX::Zero(24 + n_u);
    for (const auto& lambda : multipliers.colwise()) {
      const JointWrenches wrenches = compute_wrenches(stated, joint, lambda, nullptr);
      VecX of_one(24 + n_u);
      of_one << wrenches.reaction[0].in_C.vector(), wrenches.reaction[1].in_C.vector(), wrenches.total[0].in_C.vector(),
          wrenches.total[1].in_C.vector(), wrenches.tau;
      sizes = sizes.cwiseMax(of_one.cwiseAbs());
    }
    return sizes;
  };
  const VecX of_units = largest(MatX::Identity(null_space.rows(), null_space.rows()));
  const VecX of_null_space = largest(null_space);
  for (int c = 0; c < 12; ++c) {
    const auto stays = [&](int first) {
      return of_null_space(first + c) <= kZero * of_units.segment<3>(first + 3 * (c / 3)).maxCoeff();
    };
    uniqueness.unique[c / 6][c % 6] = stays(0);
    uniqueness.unique_total[c / 6][c % 6] = stays(12);
  }
  for (int c = 0; c < n_u; ++c) uniqueness.unique_tau[c] = of_null_space(24 + c) <= kZero * of_units(24 + c);
}

}  // namespace

VecX column_scales(const Equations& equations) {
  const Model& model = equations.model();
  const Layout& layout = equations.layout();
  const double length = model.length_scale();
  VecX scales = VecX::Ones(layout.n_Y());
  for (int i = 1; i < layout.n_bodies(); ++i) {
    layout.v(scales, i).setConstant(length);
    for (int mode = 0; mode < layout.n_modes(i); ++mode) {
      layout.adot(scales, i)(mode) = modal_size(model, i, mode, length);
    }
  }
  return scales;
}

VecX row_sizes(const Equations& equations, const VecX& columns) {
  const Constraints& constraints = equations.constraints();
  const auto norm_of = [&](int k, int row) {
    double squared = 0.0;
    for (const Side side : {Side::parent, Side::child}) {
      const int body = equations.model().joints[k].on(side).body;
      if (body == kGround) continue;
      const auto over_Y = constraints.joint(k).Phi_Y_transposed[index(side)].col(row);
      squared += over_Y.cwiseProduct(columns.segment(equations.layout().first_Y(body), over_Y.size())).squaredNorm();
    }
    return std::sqrt(squared);
  };
  VecX sizes = VecX::Zero(constraints.n_rows());
  for (int k = 0; k < constraints.n_joints(); ++k) {
    const JointEquations& joint = constraints.joint(k);
    for (int row = 0; row < joint.n_rows; ++row) sizes(joint.first_row + row) = norm_of(k, row);
  }
  for (int g = 0; g < constraints.n_couplings(); ++g) {
    const CouplingEquations& coupling = constraints.coupling(g);
    for (const CouplingEquations::Term& term : coupling.terms) {
      sizes(coupling.row) += std::abs(term.factor) * norm_of(term.joint, term.row);
    }
  }
  return sizes;
}

RankDecision decide_rank(const SparseMatrix& matrix) {
  if (matrix.rows() == 0) return {};
  if (!Eigen::Map<const VecX>(matrix.valuePtr(), matrix.nonZeros()).allFinite()) {
    throw SolverError("cartesian: the Jacobian of the constraints holds what is no number: its rank cannot be decided");
  }
  return matrix.rows() <= kDenseRows ? decide_dense(MatX(matrix)) : decide_sparse(matrix);
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
  if (has_full_rank || matrix.rows() > kDenseRows) return x;
  // Of a matrix that lacks rank SuiteSparseQR gives a solution, but not the shortest.
  Eigen::CompleteOrthogonalDecomposition<MatX> shortest;
  shortest.setThreshold(kDependent);
  return shortest.compute(MatX(matrix)).solve(right_side);
}

ScaledJacobian scaled_jacobian(const Equations& equations) {
  const Constraints& constraints = equations.constraints();
  const Layout& layout = equations.layout();
  const VecX columns = column_scales(equations);
  ScaledJacobian scaled;
  scaled.row_scale = row_sizes(equations, columns).unaryExpr([](double size) { return size > 0.0 ? 1.0 / size : 1.0; });
  std::vector<Eigen::Triplet<double, SuiteSparse_long>> entries;
  for (const RowBlock& block : constraints.blocks()) {
    const Eigen::Ref<const MatX> Phi_Y_transposed = constraints.columns(block);
    for (int row = block.first_row; row < block.first_row + block.n_rows; ++row) {
      for (int c = 0; c < layout.size_Y(block.body); ++c) {
        const int column = layout.first_Y(block.body) + c;
        const double value = Phi_Y_transposed(c, row - block.first_row) * columns(column) * scaled.row_scale(row);
        entries.emplace_back(row, column, value);
      }
    }
  }
  scaled.matrix = SparseMatrix(constraints.n_rows(), layout.n_Y());
  scaled.matrix.setFromTriplets(entries.begin(), entries.end());
  return scaled;
}

std::vector<bool> independent_rows(const Equations& equations) {
  const Constraints& constraints = equations.constraints();
  const SparseMatrix all = scaled_jacobian(equations).matrix;
  const RankDecision decision = decide_rank(all);
  if (decision.rank == all.rows() || !constraints.has_slip_rows()) {
    return decision.rank == all.rows() ? std::vector<bool>(all.rows(), true) : decision.independent;
  }
  std::vector<int> chosen;
  const auto decide_chosen = [&] {
    std::vector<Eigen::Triplet<double, SuiteSparse_long>> picks;
    for (std::size_t k = 0; k < chosen.size(); ++k) picks.emplace_back(k, chosen[k], 1.0);
    SparseMatrix pick(static_cast<Eigen::Index>(chosen.size()), all.rows());
    pick.setFromTriplets(picks.begin(), picks.end());
    return decide_rank(SparseMatrix(pick * all));
  };
  for (int row = 0; row < all.rows(); ++row) {
    if (constraints.holds_positions(row)) chosen.push_back(row);
  }
  const RankDecision of_positions = decide_chosen();
  std::vector<int> kept;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    if (of_positions.independent[k]) kept.push_back(chosen[k]);
  }
  chosen = kept;
  for (int row = 0; row < all.rows(); ++row) {
    if (constraints.holds_positions(row)) continue;
    chosen.push_back(row);
    if (decide_chosen().rank < static_cast<int>(chosen.size())) chosen.pop_back();
  }
  std::vector<bool> independent(all.rows(), false);
  for (const int row : chosen) independent[row] = true;
  return independent;
}

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
  null_space = column_scales(equations).asDiagonal() * null_space;
  const double length = equations.model().length_scale();
  for (int i = 1; i < layout.n_bodies(); ++i) null_space.middleRows<3>(layout.first_Y(i)) /= length;
  const Eigen::HouseholderQR<MatX> orthonormal(null_space);
  return orthonormal.householderQ() * MatX::Identity(null_space.rows(), null_space.cols());
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
  if (decision.rank == report.constraints) return report;
  const MatX null_space = scaled.row_scale.asDiagonal() * decision.left_null_space;
  for (int k = 0; k < constraints.n_joints(); ++k) {
    const JointEquations& joint = constraints.joint(k);
    MatX own(static_cast<Eigen::Index>(joint.rows.size()), null_space.cols());
    for (Eigen::Index z = 0; z < null_space.cols(); ++z) {
      own.col(z) = constraints.joint_multipliers(k, null_space.col(z));
    }
    mark_uniqueness(equations.model().joints[k], joint, own, report.joints[k]);
  }
  return report;
}

}  // namespace concord::cartesian
