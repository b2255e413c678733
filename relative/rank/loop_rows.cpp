#include "relative/rank/loop_rows.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "relative/rank/row_rank.h"

namespace concord::relative {

namespace {

/// The square of the sine between a row and those before it, and of its size beside the largest, above which it is
/// clearly independent.
constexpr double kClearlyIndependent = 1e-6;

}  // namespace

LoopRows::LoopRows(const ScaledClosure& scaled, const Closure& closure, std::vector<int> columns)
    : scaled_(&scaled),
      closure_(&closure),
      columns_(std::move(columns)),
      loops_(lay_out_loops()),
      squares_(order_of_loops()),
      cholesky_(squares_),
      rows_(squares_.n_rows()),
      diagonal_(VecX::Zero(squares_.n_rows())),
      column_sizes_(VecX::Zero(scaled.equations().topology().n_tree_u)) {
  for (const RowIndex row : upward<RowIndex>(squares_.n_rows())) rows_.rows.push_back(row);
  lay_out_shared();
}

/// Below the first link that the ways of both bodies to ground share, a loop moves joints and modes; on it only modes,
/// for what moves both bodies alike moves nothing between them.
std::vector<LoopRows::Loop> LoopRows::lay_out_loops() const {
  const Topology& topology = scaled_->equations().topology();
  std::vector<Loop> loops;
  for (const CutIndex c : upward<CutIndex>(closure_->cuts().size())) {
    const Closure::Cut& cut = closure_->cuts()[c];
    if (cut.measure.n_rows() == 0) continue;
    const Joint& joint = scaled_->equations().model().joints[cut.joint];
    std::vector<std::vector<LinkIndex>> ways;
    for (const Attachment& side : joint.sides) {
      std::vector<LinkIndex>& way = ways.emplace_back();
      for (std::optional<LinkIndex> l = topology.link_of_body[side.body]; l; l = topology.inward_link(*l))
        way.push_back(*l);
    }
    Loop loop{c, std::nullopt, {}};
    while (!ways[0].empty() && !ways[1].empty() && ways[0].back() == ways[1].back()) {
      loop.common = ways[0].back();
      ways[0].pop_back();
      ways[1].pop_back();
    }
    const auto add = [&](const Span& span) {
      if (span.n_u > 0) loop.columns.push_back({span.first_u, MatX::Zero(cut.measure.n_rows(), span.n_u)});
    };
    for (const std::vector<LinkIndex>& way : ways) {
      for (const LinkIndex l : way) {
        add(topology.joints[topology.links[l].joint]);
        add(topology.modes[topology.links[l].body]);
      }
    }
    if (loop.common) add(topology.modes[topology.links[*loop.common].body]);
    loops.push_back(std::move(loop));
  }
  return loops;
}

EliminationOrder LoopRows::order_of_loops() const {
  std::vector<RowGroup> groups;
  std::vector<std::vector<int>> loops_on(scaled_->equations().topology().n_tree_u);
  for (const Loop& loop : loops_) {
    for (const Columns& columns : loop.columns) loops_on[columns.first_u].push_back(static_cast<int>(groups.size()));
    const Closure::Cut& cut = closure_->cuts()[loop.cut];
    groups.push_back({cut.first_row.value(), cut.measure.n_rows()});
  }
  return {std::move(groups), neighbours_of(loops_on, loops_.size())};
}

void LoopRows::lay_out_shared() {
  struct Place {
    int loop, columns;
  };
  std::vector<std::vector<Place>> places_of(column_sizes_.size());
  for (int loop = 0; loop < static_cast<int>(loops_.size()); ++loop) {
    for (int c = 0; c < static_cast<int>(loops_[loop].columns.size()); ++c) {
      places_of[loops_[loop].columns[c].first_u].push_back({loop, c});
    }
  }
  const EliminationOrder& order = squares_.order();
  for (const std::vector<Place>& places : places_of) {
    for (const Place& row : places) {
      for (const Place& column : places) {
        if (order.place_of(row.loop) < order.place_of(column.loop)) continue;
        shared_.push_back({order.block_of(row.loop, column.loop), row.loop, row.columns, column.loop, column.columns});
      }
    }
  }
}

MatX& LoopRows::rows_of(Loop& loop, int first_u) const {
  return std::find_if(loop.columns.begin(), loop.columns.end(),
                      [first_u](const Columns& columns) { return columns.first_u == first_u; })
      ->rows;
}

/// Rows over Y of one body, carried to the speeds of the links on its way (R23).
void LoopRows::carry(BodyIndex body, MatX rows_on_body, Loop& loop) const {
  const Kinematics& kinematics = scaled_->equations().kinematics();
  const Topology& topology = kinematics.topology();
  for (std::optional<LinkIndex> l = topology.link_of_body[body]; l; l = topology.inward_link(*l)) {
    const Link& link = topology.links[*l];
    const LinkBlocks& blocks = kinematics.blocks(*l);
    const Span& joint = topology.joints[link.joint];
    const Span& modes = topology.modes[link.body];
    if (modes.n_u > 0) rows_of(loop, modes.first_u) += rows_on_body.rightCols(modes.n_u);
    if (loop.common == l) return;
    const auto rigid = rows_on_body.leftCols<6>();
    if (joint.n_u > 0) rows_of(loop, joint.first_u).noalias() += rigid * blocks.H.leftCols(joint.n_u);
    if (modes.n_u > 0) rows_of(loop, modes.first_u).noalias() -= rigid * blocks.Ha;
    MatX passed(rows_on_body.rows(), 6 + blocks.Xa.cols());
    passed.rightCols(blocks.Xa.cols()).noalias() = rigid * blocks.Xa;
    for (Eigen::Index row = 0; row < passed.rows(); ++row) {
      passed.row(row).head<6>() = shift_wrench(rows_on_body.row(row).head<6>(), blocks.rho);
    }
    rows_on_body = std::move(passed);
  }
}

/// Phi_u of one loop (R46), in units.
void LoopRows::compute(Loop& loop) const {
  const Closure::Cut& cut = closure_->cuts()[loop.cut];
  const int n = cut.measure.n_rows();
  const Kinematics& kinematics = scaled_->equations().kinematics();
  const JointPoint& parent = kinematics.point(cut.joint, Side::parent);
  const JointPoint& child = kinematics.point(cut.joint, Side::child);
  const Joint& joint = kinematics.model().joints[cut.joint];
  const Mat6X on_child = cut.T_global.leftCols(n);
  Mat6X on_parent(6, n);
  for (int row = 0; row < n; ++row) on_parent.col(row) = opposite_wrench_at(on_child.col(row), child.r, parent.r);
  for (Columns& columns : loop.columns) columns.rows.setZero();
  carry(BodyIndex(joint.on(Side::child).body), rows_on_body(child, on_child), loop);
  carry(BodyIndex(joint.on(Side::parent).body), rows_on_body(parent, on_parent), loop);
  const auto units = closure_->row_units().segment(cut.first_row, n);
  for (Columns& columns : loop.columns) {
    columns.rows.array().colwise() /= units.array();
    columns.rows.array().rowwise() *= column_sizes_.segment(columns.first_u, columns.rows.cols()).transpose().array();
  }
}

void LoopRows::sum_squares() {
  squares_.set_zero();
  for (const Shared& shared : shared_) {
    const MatX& a = loops_[shared.loop].columns[shared.columns].rows;
    const MatX& b = loops_[shared.other_loop].columns[shared.other_columns].rows;
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
        squares_.values(shared.block), a.rows(), b.rows()) += a.lazyProduct(b.transpose());
  }
}

bool LoopRows::factor(const VecX& weights) {
  if (!closure_->speed_constraints().empty() || loops_.empty()) return false;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    column_sizes_(columns_[c]) = weights(static_cast<Eigen::Index>(c)) * scaled_->size().speeds()(columns_[c]);
  }
  for (Loop& loop : loops_) compute(loop);
  sum_squares();
  damping_ = 0.0;
  squares_.write_diagonal(diagonal_);
  if (!(diagonal_.minCoeff() > kClearlyIndependent * std::max(1.0, diagonal_.maxCoeff()))) return false;
  scale_rows(diagonal_, VecX::Ones(diagonal_.size()), rows_);
  return cholesky_.factor(rows_) > kClearlyIndependent;
}

bool LoopRows::factor_damped(double damping) {
  if (!closure_->speed_constraints().empty() || loops_.empty()) return false;
  damping_ = damping;
  const EliminationOrder& order = squares_.order();
  for (int group = 0; group < static_cast<int>(loops_.size()); ++group) {
    const int block = order.block_of(group, group);
    const int n = squares_.n_rows(block);
    for (int r = 0; r < n; ++r) squares_.values(block)[r * n + r] += damping * damping;
  }
  squares_.write_diagonal(diagonal_);
  scale_rows(diagonal_, VecX::Ones(diagonal_.size()), rows_);
  return cholesky_.factor(rows_) > 0.0;
}

/// (Phi Phi^T)^-1, in place.
void LoopRows::solve_squares(VecX& right) const {
  right.array() *= rows_.scale.array();
  cholesky_.solve(right);
  right.array() *= rows_.scale.array();
}

/// With Phi^T = Q R, (Phi Phi^T)^-1 y = R^-1 R^-T y, and |R^-T y|^2 = y^T (Phi Phi^T)^-1 y.
double LoopRows::singular_value() const {  // (R70)
  constexpr int kIterations = 8;
  VecX y = inverse_iteration_start(static_cast<int>(diagonal_.size()));
  double sigma = 0.0;
  for (int round = 0; round < kIterations; ++round) {
    VecX next = y;
    solve_squares(next);
    const double size = next.norm();
    sigma = std::sqrt(y.dot(next)) / size;
    y = next / size;
  }
  return sigma;
}

std::optional<double> LoopRows::find_clear_singular_value() {
  constexpr double kClear = 1e-5;
  if (!factor(VecX::Ones(static_cast<Eigen::Index>(columns_.size())))) return std::nullopt;
  const double part = singular_value() / std::sqrt(std::max(1.0, diagonal_.maxCoeff()));
  return part > kClear ? std::optional(part) : std::nullopt;
}

/// Phi^T y, over all speeds of the tree.
VecX LoopRows::times_transpose(const VecX& y) const {
  VecX along = VecX::Zero(column_sizes_.size());
  for (const Loop& loop : loops_) {
    const Closure::Cut& cut = closure_->cuts()[loop.cut];
    const auto of_loop = y.segment(cut.first_row, cut.measure.n_rows());
    for (const Columns& columns : loop.columns) {
      along.segment(columns.first_u, columns.rows.cols()).noalias() += columns.rows.transpose().lazyProduct(of_loop);
    }
  }
  return along;
}

/// Phi x, from all speeds of the tree.
VecX LoopRows::times(const VecX& along) const {
  VecX product(diagonal_.size());
  for (const Loop& loop : loops_) {
    const Closure::Cut& cut = closure_->cuts()[loop.cut];
    auto of_loop = product.segment(cut.first_row, cut.measure.n_rows());
    of_loop.setZero();
    for (const Columns& columns : loop.columns) {
      of_loop.noalias() += columns.rows.lazyProduct(along.segment(columns.first_u, columns.rows.cols()));
    }
  }
  return product;
}

VecX LoopRows::smallest_step(const VecX& misfit) const {  // (R81)
  VecX y = -misfit;
  solve_squares(y);
  return times_transpose(y)(columns_);
}

VecX LoopRows::refined_step(const VecX& misfit) const {  // (R81)
  constexpr int kRefinements = 2;
  VecX y = -misfit;
  solve_squares(y);
  VecX along = times_transpose(y);
  for (int round = 0; round < kRefinements; ++round) {
    VecX left = -misfit - times(along) - damping_ * damping_ * y;
    solve_squares(left);
    y += left;
    along = times_transpose(y);
  }
  return along(columns_);
}

}  // namespace concord::relative
