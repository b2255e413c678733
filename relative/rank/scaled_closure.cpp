#include "relative/rank/scaled_closure.h"

#include <algorithm>

#include "relative/rank/loop_rows.h"
#include "relative/rank/row_rank.h"

namespace concord::relative {

ScaledClosure::ScaledClosure(Equations& equations)
    : equations_(&equations), free_columns_(moving_columns(equations.driven(), Modes::moving)) {}

std::vector<int> ScaledClosure::moving_columns(const PrescribedMask& prescribed, Modes modes) const {
  std::vector<char> moves(equations_->topology().n_tree_u, 1);
  for (std::size_t c = 0; c < moves.size(); ++c) moves[c] = prescribed[c] == 0 ? 1 : 0;
  if (modes == Modes::kept) {
    for (const Span& span : equations_->topology().modes) {
      std::fill_n(moves.begin() + span.first_u, span.n_u, static_cast<char>(0));
    }
  }
  std::vector<int> columns;
  for (std::size_t c = 0; c < moves.size(); ++c) {
    if (moves[c] != 0) columns.push_back(static_cast<int>(c));
  }
  return columns;
}

void ScaledClosure::advance(VecX& q, const VecX& step) const {
  const Topology& topology = equations_->topology();
  for (const Link& link : topology.links) {
    const Span& joint = topology.joints[link.joint];
    equations_->kinematics().mobilizer(link.joint).advance(q.data() + joint.first_q, step.data() + joint.first_u);
    const Span& modes = topology.modes[link.body];
    q.segment(modes.first_q, modes.n_q) += step.segment(modes.first_u, modes.n_u);
  }
}

void ScaledClosure::move(Coordinates& coordinates) const {
  const Motion& motion = equations_->move(coordinates.t, coordinates.q, coordinates.u);
  coordinates.q = motion.q();
  coordinates.u = motion.u();
}

void ScaledClosure::normalize(VecX& q) const {
  const Topology& topology = equations_->topology();
  for (std::size_t k = 0; k < topology.joints.size(); ++k) {
    equations_->kinematics().mobilizer(JointIndex(k)).normalize(q.data() + topology.joints[k].first_q);
  }
}

double ScaledClosure::position_residual() const {
  const Closure& measured = closure();
  return largest_entry(
      measured.position_residual().cwiseQuotient(measured.row_units().head(measured.n_position_rows())));
}

double ScaledClosure::residual_of_coordinates(const Closure& measured, const std::vector<int>& columns) const {
  const VecX& residual = measured.position_residual();
  if (residual.size() == 0) return 0.0;
  const MatX Phi = rows(measured, columns).topRows(residual.size());
  VecX slopes = VecX::Ones(residual.size());
  if (Phi.cols() > 0) slopes = Phi.cwiseAbs().rowwise().maxCoeff().cwiseMax(1.0);
  return largest_entry(residual.cwiseQuotient(measured.row_units().head(residual.size())).cwiseQuotient(slopes));
}

double ScaledClosure::velocity_residual() const {
  return largest_entry(closure().velocity_residual().cwiseQuotient(closure().row_units()));
}

double ScaledClosure::size_of_places(const VecX& q) const {
  constexpr double kRoundOff = 0.01;  // some four units of it, as a part of kClosedPart
  const double farthest = equations_->kinematics().farthest_place();
  return std::max({1.0, size().largest_coordinate(q), kRoundOff * farthest / size().length()});
}

MatX ScaledClosure::rows(const Closure& measured, const std::vector<int>& columns) const {  // (R63)
  const VecX units = size().speeds()(columns);
  return measured.row_units().cwiseInverse().asDiagonal() * measured.Phi_u()(Eigen::all, columns) * units.asDiagonal();
}

int ScaledClosure::rank(const Coordinates& coordinates, ClosureRows which, Modes modes) const {
  equations_->move(coordinates.t, coordinates.q, coordinates.u);
  return rank_here(which, modes);
}

int ScaledClosure::rank_here(ClosureRows which, Modes modes) const {
  return rank_here(closure(), which, moving_columns(equations_->driven(), modes));
}

int ScaledClosure::rank_here(const Closure& measured, ClosureRows which, const std::vector<int>& columns) const {
  const int n_rows = which == ClosureRows::of_positions ? measured.n_position_rows() : measured.n_rows();
  if (LoopRows(*this, measured, columns).find_clear_singular_value()) return n_rows;
  return RowRank(rows(measured, columns).topRows(n_rows)).rank();
}

}  // namespace concord::relative
