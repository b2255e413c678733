#include "relative/loops.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace concord::relative {

namespace {

/// Diagonal entries of Lambda in machine units below this part of the largest are squares of round-off: the row
/// vanishes.
constexpr double kVanishing = 1e-22;
/// Where a pivot of Lambda scaled to unit diagonal is below this, half the digits of its factor are lost; an orthogonal
/// factor of the stacked unit responses, of which Lambda is the square, keeps them.
constexpr double kIllConditioned = 1e-8;
/// Pivots of that factor, sines between rows, below this are round-off.
constexpr double kDependent = 1e-14;

/// The square of the sine that a row must have against the rows chosen before, in rounds.
constexpr std::array kLeastOwnParts{0.1, 0.01, 1e-4, 1e-8, 1e-12, 0.0};

/// Iterative refinement goes on until the residual is this part of the first one, or falls no further.
constexpr int kMostRefinements = 4;
constexpr double kRoundOffOfFirst = 2e-16;
constexpr double kStagnates = 0.25;

}  // namespace

Loops::Loops(const Kinematics& kinematics, const Closure& closure, ArticulatedBodies& articulated_bodies)
    : kinematics_(&kinematics), closure_(&closure), articulated_bodies_(&articulated_bodies) {
  lay_out_paths();
  lay_out_shared();
  const int n = closure.n_rows();
  Lambda_.setZero(n, n);
  residual_.setZero(n);
  lambda_.setZero(n);
  lambda_correction_.setZero(n);
  int most_unknowns = 0;
  for (const LoopPath& path : paths_) {
    for (const PathLink& path_link : path.links)
      most_unknowns = std::max(most_unknowns, articulated_bodies.n_unknowns(path_link.link));
  }
  force_.setZero(most_unknowns);
  scale_.setZero(n);
  rest_.setZero(n, n);
  first_of_link_.resize(kinematics.topology().links.size());
  int n_stacked = 0;
  for (const LoopPath& path : paths_) {
    for (const PathLink& path_link : path.links) {
      if (first_of_link_[path_link.link]) continue;
      first_of_link_[path_link.link] = n_stacked;
      n_stacked += articulated_bodies.n_unknowns(path_link.link);
    }
  }
  stacked_.setZero(n_stacked, n);
  set_rank(n);
}

void Loops::lay_out_paths() {
  for (std::size_t c = 0; c < closure_->cuts().size(); ++c) {
    const Closure::Cut& cut = closure_->cuts()[c];
    if (cut.measure.n_rows() == 0) continue;  // permits all six, and exerts nothing
    lay_out({CutRows{static_cast<int>(c)}, cut.first_row, cut.measure.n_rows(), {}, {}}, {cut.joint});
  }
  for (std::size_t r = 0; r < closure_->speed_constraints().size(); ++r) {
    const SpeedConstraint& constraint = closure_->speed_constraints()[r];
    std::vector<int> joints;
    for (const ConstrainedJoint& part : constraint.joints) joints.push_back(part.joint);
    lay_out({SpeedRows{static_cast<int>(r)}, constraint.first_row, constraint.n_rows, {}, {}}, joints);
  }
}

/// Pairs of links of two paths that are the same link; paths in the order of their rows.
void Loops::lay_out_shared() {
  for (int a = 0; a < static_cast<int>(paths_.size()); ++a) {
    for (int b = a; b < static_cast<int>(paths_.size()); ++b) {
      for (int i = 0; i < static_cast<int>(paths_[a].links.size()); ++i) {
        for (int j = 0; j < static_cast<int>(paths_[b].links.size()); ++j) {
          if (paths_[a].links[i].link == paths_[b].links[j].link) shared_.push_back({a, i, b, j});
        }
      }
    }
  }
}

void Loops::set_rank(int rank) {
  rank_ = rank;
  used_.clear();
  used_.reserve(rank);
  for (int row = 0; row < rank; ++row) used_.push_back(row);
  selected_.setIdentity(rank, rank);
  llt_.compute(selected_);
  stacked_.setZero(stacked_.rows(), rank);
  if (stacked_.size() > 0) qr_.compute(stacked_);
  solution_.setZero(rank);
  permuted_.setZero(rank);
}

/// The links between the bodies of some joints and ground, outermost first.
std::vector<int> Loops::links_to_ground(const std::vector<int>& joints) const {
  const Topology& topology = kinematics_->topology();
  std::vector<int> links;
  for (const int joint : joints) {
    for (const Attachment& side : kinematics_->model().joints[joint].sides) {
      for (std::optional<int> l = topology.link_of_body[side.body]; l; l = topology.inward_link(*l))
        links.push_back(*l);
    }
  }
  std::sort(links.begin(), links.end(), std::greater<>());
  links.erase(std::unique(links.begin(), links.end()), links.end());
  return links;
}

/// Gives a path its links, and a load for each of its joints.
void Loops::lay_out(LoopPath path, const std::vector<int>& joints) {
  const Topology& topology = kinematics_->topology();
  const std::vector<int> links = links_to_ground(joints);
  const auto path_link_of = [&](std::optional<int> link) -> std::optional<int> {
    if (!link) return std::nullopt;
    return static_cast<int>(std::find(links.begin(), links.end(), *link) - links.begin());
  };
  for (const int l : links) {
    const int m = topology.modes[topology.links[l].body].n_u;
    path.links.push_back({l, path_link_of(topology.inward_link(l)), Mat6X::Zero(6, path.n_rows),
                          MatX::Zero(m, path.n_rows), MatX::Zero(articulated_bodies_->n_unknowns(l), path.n_rows)});
  }
  for (const int k : joints) {
    if (const auto* on_link = std::get_if<OnLink>(&topology.places[k])) {
      path.loads.emplace_back(CoordinateLoad{*path_link_of(on_link->link)});
      continue;
    }
    const auto link_on = [&](Side side) {
      return path_link_of(topology.link_of_body[kinematics_->model().joints[k].on(side).body]);
    };
    path.loads.emplace_back(WrenchLoad{k, link_on(Side::child), link_on(Side::parent)});
  }
  paths_.push_back(std::move(path));
}

/// Unit multipliers act with +T on the child of a cut joint, or with coordinate forces +C on a joint of the tree.
void Loops::apply_unit_multipliers(LoopPath& path) {
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
      articulated_bodies_->add_coordinate_forces(path_link.link, part.C, path_link.unit_response);
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
void Loops::compute_unit_responses(LoopPath& path) {
  for (PathLink& path_link : path.links) {
    path_link.z_r.setZero();
    path_link.z_a.setZero();
    path_link.unit_response.setZero();
  }
  apply_unit_multipliers(path);
  for (PathLink& path_link : path.links) {
    articulated_bodies_->propagate_force(path_link.link, path_link.z_r, path_link.z_a, path_link.unit_response);
    if (!path_link.next) continue;
    const LinkBlocks& blocks = kinematics_->blocks(path_link.link);
    PathLink& next = path.links[*path_link.next];
    for (Eigen::Index c = 0; c < path_link.z_r.cols(); ++c)
      next.z_r.col(c) += shift_wrench(path_link.z_r.col(c), blocks.rho);
    next.z_a.noalias() += blocks.Xa.transpose().lazyProduct(path_link.z_r);
  }
}

/// Lambda = sum over links of unit_response^T unit_response (R52).
void Loops::sum_Lambda() {
  Lambda_.setZero();
  for (const SharedLink& shared : shared_) {
    const MatX& a = paths_[shared.path].links[shared.link].unit_response;
    const MatX& b = paths_[shared.other_path].links[shared.other_link].unit_response;
    const int row = paths_[shared.path].first_row;
    const int column = paths_[shared.other_path].first_row;
    Lambda_.block(row, column, a.cols(), b.cols()).noalias() += a.transpose().lazyProduct(b);
  }
  Lambda_.triangularView<Eigen::StrictlyLower>() = Lambda_.transpose();
}

void Loops::throw_singular(int row) const {
  const VecX place = VecX::Unit(closure_->n_rows(), row);
  throw SingularPose(fmt::format(
      "relative: the {} closure rows{} have a rank below {}, their rank in a general pose, at {}: the pose is singular "
      "and the motion may branch",
      closure_->n_rows(), closure_->speed_constraints().empty() ? "" : " of loops, couplings and rolling contacts",
      rank_, closure_->worst_place(place)));
}

/// The scale of each row, zero for one that vanishes; and the rows to use, all or as many as are independent in a
/// general pose, by elimination in the scaled Lambda: the first in order that keep enough of their own beside those
/// taken, so that round-off does not choose between rows that are as good.
void Loops::choose_rows() {
  const auto n = static_cast<int>(Lambda_.rows());
  double largest = 0.0;
  const VecX& units = closure_->row_units();
  for (int i = 0; i < n; ++i) largest = std::max(largest, Lambda_(i, i) / (units(i) * units(i)));
  for (int i = 0; i < n; ++i) {
    const bool vanishes = !(Lambda_(i, i) / (units(i) * units(i)) > kVanishing * largest);
    scale_(i) = vanishes ? 0.0 : 1.0 / std::sqrt(Lambda_(i, i));
  }
  if (rank_ == n) return;  // all rows are used
  if (keeps_rows_ && has_kept_ && are_kept_rows_sound()) return;
  rest_.noalias() = scale_.asDiagonal() * Lambda_ * scale_.asDiagonal();
  used_.clear();
  for (const double least : kLeastOwnParts) {
    for (int row = 0; row < n && static_cast<int>(used_.size()) < rank_; ++row) {
      if (rest_(row, row) > least) use(row);
    }
  }
  // Of the rows that are left none is independent.
  if (static_cast<int>(used_.size()) < rank_) throw_singular(0);
  std::sort(used_.begin(), used_.end());
  has_kept_ = keeps_rows_;
}

/// Whether the rows in use are still independent enough in this pose.
bool Loops::are_kept_rows_sound() {
  constexpr double kSound = 1e-6;
  select();
  return llt_.compute(selected_).info() == Eigen::Success &&
         llt_.matrixLLT().diagonal().cwiseAbs2().minCoeff() > kSound;
}

/// Lambda of the used rows, scaled to unit diagonal.
void Loops::select() {
  const auto n = static_cast<Eigen::Index>(used_.size());
  for (Eigen::Index j = 0; j < n; ++j) {
    for (Eigen::Index i = 0; i < n; ++i) {
      selected_(i, j) = scale_(used_[i]) * Lambda_(used_[i], used_[j]) * scale_(used_[j]);
    }
  }
}

/// Takes a row and its part off what is left of the others.
void Loops::use(int pivot) {
  used_.push_back(pivot);
  const double size = rest_(pivot, pivot);
  for (Eigen::Index j = 0; j < rest_.cols(); ++j) {
    if (j == pivot) continue;
    const double factor = rest_(pivot, j) / size;
    for (Eigen::Index i = 0; i < rest_.rows(); ++i) {
      if (i != pivot) rest_(i, j) -= factor * rest_(i, pivot);
    }
  }
  rest_.row(pivot).setZero();
  rest_.col(pivot).setZero();
}

/// Cholesky's factor of the used rows of Lambda, or where that loses digits the orthogonal factor of the stacked unit
/// responses.
void Loops::factorize() {
  for (const int row : used_) {
    if (scale_(row) == 0.0) throw_singular(row);
  }
  select();
  is_orthogonal_ = false;
  least_pivot_ = 0.0;
  if (llt_.compute(selected_).info() == Eigen::Success) {
    least_pivot_ = llt_.matrixLLT().diagonal().cwiseAbs2().minCoeff();
  }
  if (!(least_pivot_ > kIllConditioned)) factorize_stacked();
}

void Loops::factorize_stacked() {
  is_orthogonal_ = true;
  stacked_.setZero();
  for (const LoopPath& path : paths_) {
    for (std::size_t c = 0; c < used_.size(); ++c) {
      const int column = used_[c] - path.first_row;
      if (column < 0 || column >= path.n_rows) continue;
      for (const PathLink& path_link : path.links) {
        stacked_.col(static_cast<Eigen::Index>(c))
            .segment(*first_of_link_[path_link.link], path_link.unit_response.rows()) =
            scale_(used_[c]) * path_link.unit_response.col(column);
      }
    }
  }
  qr_.compute(stacked_);
  const auto n = static_cast<Eigen::Index>(used_.size());
  const Eigen::Index least = n - 1;
  const double pivot = stacked_.rows() < n ? 0.0 : std::abs(qr_.matrixQR()(least, least));
  least_pivot_ = pivot * pivot;
  if (!(pivot > kDependent)) throw_singular(used_[qr_.colsPermutation().indices()(least)]);
}

/// Lambda^-1 of the used rows, in place.
void Loops::solve(VecX& right) const {
  for (std::size_t i = 0; i < used_.size(); ++i) right(i) *= scale_(used_[i]);
  if (is_orthogonal_) {
    const auto n = static_cast<Eigen::Index>(used_.size());
    const auto& place = qr_.colsPermutation().indices();
    for (Eigen::Index i = 0; i < n; ++i) permuted_(i) = right(place(i));
    const auto R = qr_.matrixQR().topRows(n).triangularView<Eigen::Upper>();
    R.transpose().solveInPlace(permuted_);
    R.solveInPlace(permuted_);
    for (Eigen::Index i = 0; i < n; ++i) right(place(i)) = permuted_(i);
  } else {
    llt_.solveInPlace(right);
  }
  for (std::size_t i = 0; i < used_.size(); ++i) right(i) *= scale_(used_[i]);
}

/// Adds -Phi_u^T lambda to the right side of the tree (R53).
void Loops::apply_constraint_forces(const VecX& lambda) {
  for (const LoopPath& path : paths_) {
    const auto of_path = lambda.segment(path.first_row, path.n_rows);
    for (const PathLink& path_link : path.links) {
      auto force = force_.head(path_link.unit_response.rows());
      force.noalias() = -path_link.unit_response.lazyProduct(of_path);
      articulated_bodies_->add_force(path_link.link, force);
    }
  }
}

void Loops::close(VecX& udot) {  // (R53)
  if (closure_->n_rows() == 0) return;
  for (LoopPath& path : paths_) compute_unit_responses(path);
  sum_Lambda();
  lambda_.setZero();
  least_pivot_ = 1.0;
  if (rank_ == 0) return;
  choose_rows();
  factorize();
  const auto acceleration = [this](int joint, Side side) {
    return articulated_bodies_->acceleration_of_point(joint, side);
  };
  double first_residual = 0.0;
  double last_residual = 0.0;
  for (int round = 0; round < kMostRefinements; ++round) {
    closure_->compute_acceleration_residual(acceleration, udot, residual_);
    double residual = 0.0;
    for (std::size_t i = 0; i < used_.size(); ++i) {
      solution_(i) = residual_(used_[i]);
      // Each row by what a unit multiplier moves in it, so that units do not weigh.
      residual = std::max(residual, std::abs(solution_(i)) * scale_(used_[i]));
    }
    if (round == 0) first_residual = residual;
    if (round > 0 && (residual <= kRoundOffOfFirst * first_residual || residual > kStagnates * last_residual)) break;
    last_residual = residual;
    solve(solution_);
    lambda_correction_.setZero();
    for (std::size_t i = 0; i < used_.size(); ++i) lambda_correction_(used_[i]) = solution_(i);
    lambda_ += lambda_correction_;
    apply_constraint_forces(lambda_correction_);
    articulated_bodies_->forward_pass(udot);
  }
}

std::optional<int> Loops::contradicted_row(double allowed) const {
  std::optional<int> found;
  if (rank_ == static_cast<int>(lambda_.size())) return found;
  double worst = allowed;
  for (int row = 0; row < static_cast<int>(lambda_.size()); ++row) {
    if (std::binary_search(used_.begin(), used_.end(), row)) continue;
    const double misfit = std::abs(residual_(row)) / closure_->row_units()(row);
    if (misfit <= worst) continue;
    worst = misfit;
    found = row;
  }
  return found;
}

}  // namespace concord::relative
