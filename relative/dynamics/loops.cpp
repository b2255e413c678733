#include "relative/dynamics/loops.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace concord::relative {

namespace {

/// Where a pivot of Lambda scaled to unit diagonal is below this, half the digits of its factor are lost; an orthogonal
/// factor of the stacked unit responses, of which Lambda is the square, keeps them.
constexpr double kIllConditioned = 1e-8;
/// Pivots of that factor, sines between rows, below this are round-off.
constexpr double kDependent = 1e-14;

/// Iterative refinement goes on until the residual is this part of the first one, or falls no further.
constexpr int kMostRefinements = 4;
constexpr double kRoundOffOfFirst = 2e-16;
constexpr double kStagnates = 0.25;
/// Accelerations that the constraints bring down by more than this are known better than the residual that began: that
/// of a light body under a large force, which the loop takes up.
constexpr double kBroughtDown = 0.01;

double largest_of(const VecX& values, const std::vector<int>& places) {
  double largest = 0.0;
  for (const int place : places) largest = std::max(largest, std::abs(values(place)));
  return largest;
}

}  // namespace

Loops::Loops(const Kinematics& kinematics, const Closure& closure, const ArticulatedInertias& tree)
    : kinematics_(&kinematics),
      closure_(&closure),
      paths_(lay_out_paths(tree)),
      Lambda_(order_of_paths()),
      diagonal_(VecX::Zero(closure.n_rows())),
      choice_(closure.n_rows()),
      factors_(Lambda_) {
  lay_out_shared();
  lay_out_stacked(tree);
  const int n = closure.n_rows();
  solution_.lambda.setZero(n);
  solution_.residual.setZero(n);
  solution_.used = IndependentRows(n);
  lambda_correction_.setZero(n);
  for (const JointIndex k : upward<JointIndex>(kinematics.topology().joints.size())) {
    const Span& span = kinematics.topology().joints[k];
    const Mobilizer& mobilizer = kinematics.mobilizer(k);
    for (int c = 0; c < span.n_u; ++c) (mobilizer.kind(c).is_length ? slides_ : turns_).push_back(span.first_u + c);
  }
  set_rank(n);
}

void Loops::set_rank(int rank) {
  rank_ = rank;
  std::vector<RowIndex>& rows = solution_.used.rows;
  rows.clear();
  rows.reserve(rank);
  for (const RowIndex row : upward<RowIndex>(rank)) rows.push_back(row);
  factors_.lay_out(rank, n_stacked_);
  right_.setZero(rank);
  if (rank < closure_->n_rows()) dense_Lambda_.setZero(closure_->n_rows(), closure_->n_rows());
}

/// Unit multipliers act with +T on the child of a cut joint, or with coordinate forces +C on a joint of the tree.
void Loops::apply_unit_multipliers(const ArticulatedInertias& tree, LoopPath& path) {
  if (const auto* rows = std::get_if<CutRows>(&path.owner)) {
    const auto& load = std::get<WrenchLoad>(path.loads.front());
    apply_unit_wrenches(path, load, closure_->cuts()[rows->cut].T_global.leftCols(path.n_rows));
    return;
  }
  const SpeedConstraint& constraint = closure_->speed_constraints()[std::get<SpeedRows>(path.owner).constraint];
  for (std::size_t p = 0; p < path.loads.size(); ++p) {
    const ConstrainedJoint& part = constraint.joints[p];
    if (const auto* load = std::get_if<CoordinateLoad>(&path.loads[p])) {
      PathLink& path_link = path.links[load->own_link];
      tree.add_coordinate_forces(path_link.link, part.C, path_link.unit_response);
    } else {
      apply_unit_wrenches(path, std::get<WrenchLoad>(path.loads[p]), part.T_global);
    }
  }
}

void Loops::apply_unit_wrenches(LoopPath& path, const WrenchLoad& load, const Eigen::Ref<const Mat6X>& on_child) {
  for (const Side side : {Side::child, Side::parent}) apply_unit_wrenches(path, load, side, on_child);
}

/// Adds W^T T of one side to the generalized forces on its body.
void Loops::apply_unit_wrenches(LoopPath& path, const WrenchLoad& load, Side side,
                                const Eigen::Ref<const Mat6X>& on_child) {
  const std::optional<int> at = side == Side::child ? load.child_link : load.parent_link;
  if (!at) return;
  PathLink& path_link = path.links[*at];
  const JointPoint& point = kinematics_->point(load.joint, side);
  const Vec3 d = kinematics_->point(load.joint, Side::child).r - kinematics_->point(load.joint, Side::parent).r;
  for (Eigen::Index c = 0; c < path_link.z_r.cols(); ++c) {
    Vec6 w = on_child.col(c);
    if (side == Side::parent) w = -shift_wrench(w, d);
    path_link.z_r.col(c) += shift_wrench(w, point.lever);
    path_link.z_a.col(c).noalias() += point.Ga().transpose().lazyProduct(w);
  }
}

/// Carries the unit multipliers of one path to ground (R51).
void Loops::compute_unit_responses(const ArticulatedInertias& tree, LoopPath& path) {
  for (PathLink& path_link : path.links) {
    path_link.z_r.setZero();
    path_link.z_a.setZero();
    path_link.unit_response.setZero();
  }
  apply_unit_multipliers(tree, path);
  for (PathLink& path_link : path.links) {
    tree.propagate_force(path_link.link, path_link.z_r, path_link.z_a, path_link.unit_response);
    if (!path_link.next) continue;
    PathLink& next = path.links[*path_link.next];
    tree.add_passed_force(path_link.link, path_link.z_r, next.z_r, next.z_a);
  }
}

/// Lambda = sum over links of unit_response^T unit_response (R52).
void Loops::sum_Lambda() {
  Lambda_.set_zero();
  for (const SharedLink& shared : shared_) {
    const MatX& a = paths_[shared.path].links[shared.link].unit_response;
    const MatX& b = paths_[shared.other_path].links[shared.other_link].unit_response;
    const Eigen::Index n = a.rows();
    double* entry = Lambda_.values(shared.block);
    for (Eigen::Index row = 0; row < a.cols(); ++row) {
      const double* of_row = a.data() + row * n;
      for (Eigen::Index column = 0; column < b.cols(); ++column) {
        const double* of_column = b.data() + column * n;
        double sum = 0.0;
        for (Eigen::Index k = 0; k < n; ++k) sum += of_row[k] * of_column[k];
        *entry++ += sum;
      }
    }
  }
  Lambda_.write_diagonal(diagonal_);
}

void Loops::throw_singular(RowIndex row) const {
  const VecX place = VecX::Unit(closure_->n_rows(), row);
  throw SingularPose(fmt::format(
      "relative: the {} closure rows{} have a rank below {}, their rank in a general pose, at {}: the pose is singular "
      "and the motion may branch",
      closure_->n_rows(), closure_->speed_constraints().empty() ? "" : " of loops, couplings and rolling contacts",
      rank_, closure_->worst_place(place)));
}

/// All rows, or as many as are independent in a general pose.
void Loops::choose_rows() {
  constexpr double kSound = 1e-6;        // kept rows are independent enough in this pose
  constexpr double kHeavy = 1e-4;        // and none has almost vanished, since
  constexpr double kMuchLighter = 1e-2;  // they were chosen
  IndependentRows& used = solution_.used;
  scale_rows(diagonal_, closure_->row_units(), used);
  if (rank_ == closure_->n_rows()) return;
  const bool may_stay = keeps_rows_ && has_kept_ && used.least_weight() > least_kept_weight_;
  if (may_stay && factors_.factor(used) > kSound) return;
  Lambda_.write_dense(dense_Lambda_);
  if (!choice_.choose(dense_Lambda_, rank_, used))
    throw_singular(RowIndex(0));  // of the rows that are left none is independent
  has_kept_ = keeps_rows_;
  least_kept_weight_ = std::min(kHeavy, kMuchLighter * used.least_weight());
}

void Loops::factorize() {
  const IndependentRows& used = solution_.used;
  for (const RowIndex row : used.rows) {
    if (used.scale[row] == 0.0) throw_singular(row);
  }
  solution_.least_pivot = factors_.factor(used);
  if (solution_.least_pivot > kIllConditioned) return;
  stack_unit_responses();
  const MultiplierFactors::LeastSine least = factors_.factor_stacked();
  solution_.least_pivot = least.pivot * least.pivot;
  if (!(least.pivot > kDependent)) throw_singular(used.rows[least.place]);
}

void Loops::stack_unit_responses() {
  const IndependentRows& used = solution_.used;
  MatX& stacked = factors_.stacked();
  stacked.setZero();
  for (const LoopPath& path : paths_) {
    for (std::size_t c = 0; c < used.rows.size(); ++c) {
      const int column = used.rows[c] - path.first_row;
      if (column < 0 || column >= path.n_rows) continue;
      for (const PathLink& path_link : path.links) {
        stacked.col(static_cast<Eigen::Index>(c))
            .segment(*first_of_link_[path_link.link], path_link.unit_response.rows()) =
            used.scale[used.rows[c]] * path_link.unit_response.col(column);
      }
    }
  }
}

/// Adds -Phi_u^T lambda to the right side of the tree (R53).
void Loops::apply_constraint_forces(const VecX& lambda, TreeAccelerations& accelerations) {
  for (const LoopPath& path : paths_) {
    const auto of_path = lambda.segment(path.first_row, path.n_rows);
    for (const PathLink& path_link : path.links) {
      auto force = force_.head(path_link.unit_response.rows());
      force.noalias() = -path_link.unit_response.lazyProduct(of_path);
      accelerations.add_force(path_link.link, force);
    }
  }
}

const LoopSolution& Loops::close(const ArticulatedInertias& tree, TreeAccelerations& accelerations) {  // (R53)
  if (closure_->n_rows() == 0) return solution_;
  for (LoopPath& path : paths_) compute_unit_responses(tree, path);
  sum_Lambda();
  solution_.lambda.setZero();
  solution_.least_pivot = 1.0;
  if (rank_ == 0) return solution_;
  choose_rows();
  factorize();
  refine(tree, accelerations);
  return solution_;
}

/// Solves for the multipliers, and again for what round-off has left of the closure until it falls no further.
void Loops::refine(const ArticulatedInertias& tree, TreeAccelerations& accelerations) {
  const IndependentRows& used = solution_.used;
  Eigen::Array4d sizes;  // of accelerations at the cuts, linear and angular, and of those of slides and turns
  const auto acceleration = [&](JointIndex joint, Side side) {
    Vec6 found = accelerations.of_point(joint, side);
    sizes(0) = std::max(sizes(0), found.head<3>().lpNorm<Eigen::Infinity>());
    sizes(1) = std::max(sizes(1), found.tail<3>().lpNorm<Eigen::Infinity>());
    return found;
  };
  Eigen::Array4d first_sizes;
  double first_residual = 0.0;
  double last_residual = 0.0;
  for (int round = 0; round < kMostRefinements; ++round) {
    sizes << 0.0, 0.0, largest_of(accelerations.udot(), slides_), largest_of(accelerations.udot(), turns_);
    closure_->compute_acceleration_residual(acceleration, accelerations.udot(), solution_.residual);
    const double residual = select_residual();
    if (round == 0) {
      first_residual = residual;
      first_sizes = sizes;
    } else {
      if (residual == 0.0) break;
      const bool is_known_better = (sizes < kBroughtDown * first_sizes).any();
      if (!is_known_better && residual <= kRoundOffOfFirst * first_residual) break;
      if (residual > kStagnates * last_residual) break;
    }
    last_residual = residual;
    factors_.solve(used, right_);
    lambda_correction_.setZero();
    for (std::size_t i = 0; i < used.rows.size(); ++i) lambda_correction_[used.rows[i]] = right_(i);
    solution_.lambda += lambda_correction_;
    apply_constraint_forces(lambda_correction_, accelerations);
    accelerations.solve_again(tree);
  }
}

/// Takes the residuals of the used rows for right side; the largest, each by what a unit multiplier moves in its row,
/// so that units do not weigh.
double Loops::select_residual() {
  const IndependentRows& used = solution_.used;
  double largest = 0.0;
  for (std::size_t i = 0; i < used.rows.size(); ++i) {
    right_(i) = solution_.residual[used.rows[i]];
    largest = std::max(largest, std::abs(right_(i)) * used.scale[used.rows[i]]);
  }
  return largest;
}

std::optional<RowIndex> LoopSolution::contradicted_row(const VecX& row_units, double allowed) const {
  std::optional<RowIndex> found;
  if (used.rows.size() == static_cast<std::size_t>(lambda.size())) return found;
  double worst = allowed;
  for (const RowIndex row : upward<RowIndex>(lambda.size())) {
    if (used.hold(row)) continue;
    const double misfit = std::abs(residual[row]) / row_units[row];
    if (misfit <= worst) continue;
    worst = misfit;
    found = row;
  }
  return found;
}

}  // namespace concord::relative
