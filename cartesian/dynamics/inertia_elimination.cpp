#include "cartesian/dynamics/inertia_elimination.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace concord::cartesian {

namespace {

/// A pivot below this part of what stood in its place leaves few digits.
constexpr double kLeastPivot = 1e-9;
constexpr int kNodeSize = 6;

/// L and the inverse of D of a modal mass matrix, which is the same in every state. False if it is not positive.
bool factor_modes(const MatX& mass, MatX& L, VecX& inverse_D) {
  L = mass;
  inverse_D.setZero(mass.rows());
  for (Eigen::Index c = 0; c < mass.rows(); ++c) {
    if (!(L(c, c) > kLeastPivot * mass(c, c))) return false;
    const VecX column = L.col(c);
    inverse_D(c) = 1.0 / column(c);
    L.col(c) = inverse_D(c) * column;
    for (Eigen::Index later = c + 1; later < mass.rows(); ++later) L.col(later) -= column(later) * L.col(c);
  }
  return true;
}

double part_of(double residual, double terms) { return residual == 0.0 ? 0.0 : std::abs(residual) / terms; }
/// What is no number counts as larger.
double larger(double one, double other) { return one > other || std::isnan(one) ? one : other; }

}  // namespace

InertiaElimination::InertiaElimination(const Equations& equations, const ByBody<MatX>& modal_masses)
    : n_Y_(equations.layout().n_Y()), blocks_(equations.constraints().blocks()) {
  for (const BodyIndex i : equations.layout().moving_bodies()) {
    Part part;
    part.body = i;
    part.first_Y = equations.layout().first_Y(i);
    part.n_modes = equations.layout().n_modes(i);
    part.modal_mass = modal_masses[i];
    part.has_regular_modes = factor_modes(part.modal_mass, part.L_modal, part.inverse_D_modal);
    part.M.setZero(6, 6 + part.n_modes);
    part.coupling.setZero(6, part.n_modes);
    part.modal.setZero(part.n_modes);
    part.terms.setZero(6 + part.n_modes);
    part.sizes.setZero(6 + part.n_modes);
    if (no_row_.size() < part.M.cols()) no_row_.setZero(part.M.cols());
    parts_.push_back(std::move(part));
  }
  residual_.setZero(n_Y_ + equations.constraints().n_rows());
  use_rows(std::vector<bool>(equations.constraints().n_rows(), true));
}

void InertiaElimination::use_rows(const std::vector<bool>& active) {
  std::map<RowIndex, std::vector<int>> nodes_from;  // by the first row of a joint or coupling
  std::vector<std::vector<int>> rows;               // by node
  for (const RowBlock& block : blocks_) {
    const auto [found, is_new] = nodes_from.try_emplace(block.first_row);
    for (int own = 0; is_new && own < block.n_rows; ++own) {
      const int row = block.row(own).value;
      if (!active[row]) continue;
      if (found->second.empty() || rows[found->second.back()].size() == kNodeSize) {
        found->second.push_back(static_cast<int>(rows.size()));
        rows.emplace_back();
      }
      rows[found->second.back()].push_back(row);
    }
  }
  std::map<BodyIndex, std::vector<NodeOfBlock>> on_body;
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    for (const int node : nodes_from[blocks_[b].first_row]) on_body[blocks_[b].body].push_back({node, b});
  }
  lay_out(rows, on_body);
}

void InertiaElimination::lay_out(const std::vector<std::vector<int>>& rows,
                                 std::map<BodyIndex, std::vector<NodeOfBlock>>& on_body) {
  const int n = static_cast<int>(rows.size());
  const auto pairs_of = [&] {
    std::vector<BlockLdlt::Coupled> pairs;
    for (const auto& [body, own] : on_body) {
      for (const NodeOfBlock& one : own) {
        for (const NodeOfBlock& other : own) {
          if (one.node < other.node) pairs.emplace_back(one.node, other.node);
        }
      }
    }
    return pairs;
  };
  const std::vector<int> order = elimination_order(n, pairs_of());
  std::vector<int> turn(n);
  nodes_.assign(n, {});
  for (int k = 0; k < n; ++k) {
    nodes_[k] = rows[order[k]];
    turn[order[k]] = k;
  }
  for (auto& [body, own] : on_body) {
    for (NodeOfBlock& one : own) one.node = turn[one.node];
    std::sort(own.begin(), own.end(), [](const auto& one, const auto& other) { return one.node < other.node; });
  }
  std::vector<int> sizes;
  for (const std::vector<int>& own : nodes_) sizes.push_back(static_cast<int>(own.size()));
  H_ = BlockLdlt(std::move(sizes), pairs_of());
  multipliers_.setZero(6, n);
  row_residuals_.setZero(6, n);
  row_terms_.setZero(6, n);
  legs_.clear();
  for (Part& part : parts_) add_legs(part, on_body[part.body]);
}

void InertiaElimination::add_legs(Part& part, const std::vector<NodeOfBlock>& own) {
  part.first_leg = static_cast<int>(legs_.size());
  part.n_legs = static_cast<int>(own.size());
  part.places.clear();
  for (const NodeOfBlock& one : own) {
    Leg leg;
    leg.node = one.node;
    leg.block = one.block;
    for (const int row : nodes_[one.node]) leg.own.push_back(row - blocks_[one.block].first_row.value);
    leg.J.setZero(6, 6 + part.n_modes);
    leg.W = leg.J;
    legs_.push_back(std::move(leg));
    for (const NodeOfBlock& before : own) {
      if (before.node <= one.node) part.places.push_back(H_.find(one.node, before.node));
    }
  }
}

bool InertiaElimination::factor(const Equations& equations) {
  H_.set_zero();
  for (Part& part : parts_) {
    if (!factor_inertia(equations, part)) return false;
    for (Leg& leg : legs_of(part)) {
      read_rows(equations, leg);
      divide_by_inertia(part, leg);
    }
    add_to_rows(part);
  }
  return H_.factor(kLeastPivot);
}

void InertiaElimination::read(const Equations& equations) {
  for (Part& part : parts_) {
    equations.write_rigid_rows(part.body, part.M);
    for (Leg& leg : legs_of(part)) read_rows(equations, leg);
  }
}

bool InertiaElimination::factor_inertia(const Equations& equations, Part& part) {  // (C65)
  if (!part.has_regular_modes) return false;
  equations.write_rigid_rows(part.body, part.M);
  part.L_rigid = part.M.leftCols<6>();
  const Vec6 least = kLeastPivot * part.L_rigid.diagonal();
  if (part.n_modes > 0) {
    part.coupling = part.M.rightCols(part.n_modes);
    divide_rows(part.L_modal, part.coupling);
    add_product<-1>(part.coupling, part.inverse_D_modal, part.coupling, part.L_rigid, 6);
  }
  return factor_block<6>(part.L_rigid, part.inverse_D_rigid, least);
}

void InertiaElimination::read_rows(const Equations& equations, Leg& leg) {
  const Eigen::Ref<const MatX> columns = equations.moving_constraints().columns(blocks_[leg.block]);
  for (std::size_t row = 0; row < leg.own.size(); row += 2) {
    const double* one = columns.col(leg.own[row]).data();
    const double* other = row + 1 < leg.own.size() ? columns.col(leg.own[row + 1]).data() : no_row_.data();
    double* to = leg.J.data() + row;
#pragma GCC unroll 6
    for (int c = 0; c < 6; ++c) store_pair(Pair{one[c], other[c]}, to + 6 * c);
    for (Eigen::Index c = 6; c < leg.J.cols(); ++c) store_pair(Pair{one[c], other[c]}, to + 6 * c);
  }
}

void InertiaElimination::divide_by_inertia(const Part& part, Leg& leg) {  // (C66)
  leg.W = leg.J;
  auto rigid = leg.W.leftCols<6>();
  if (part.n_modes > 0) {
    auto modal = leg.W.rightCols(part.n_modes);
    divide_rows(part.L_modal, modal);
    add_product<-1>(modal, part.inverse_D_modal, part.coupling, rigid, 6);
  }
  divide_rows<6>(part.L_rigid, rigid);
}

/// H += W D^-1 W^T of all pairs of nodes on a body.
void InertiaElimination::add_to_rows(const Part& part) {  // (C66)
  auto place = part.places.begin();
  for (int row = part.first_leg; row < part.first_leg + part.n_legs; ++row) {
    const Mat6X& W_row = legs_[row].W;
    for (int column = part.first_leg; column <= row; ++column) {
      const Mat6X& W_column = legs_[column].W;
      const int n = static_cast<int>(legs_[column].own.size());
      Mat6& block = H_.block(*place++);
      add_product<1, 6>(W_row.leftCols<6>(), part.inverse_D_rigid, W_column.leftCols<6>(), block, n);
      if (part.n_modes == 0) continue;
      add_product<1>(W_row.rightCols(part.n_modes), part.inverse_D_modal, W_column.rightCols(part.n_modes), block, n);
    }
  }
}

void InertiaElimination::solve(VecX& x) {
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    for (std::size_t row = 0; row < nodes_[k].size(); ++row) {
      multipliers_(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(k)) = -x(n_Y_ + nodes_[k][row]);
    }
  }
  for (Part& part : parts_) eliminate(part, x);
  H_.solve(multipliers_);
  for (Part& part : parts_) substitute(part, x);
  x.tail(x.size() - n_Y_).setZero();
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    for (std::size_t row = 0; row < nodes_[k].size(); ++row) {
      x(n_Y_ + nodes_[k][row]) = multipliers_(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(k));
    }
  }
}

/// y = L^-1 f, and W D^-1 y to the right sides of the rows (C67).
void InertiaElimination::eliminate(Part& part, const VecX& x) {
  part.rigid = x.segment<6>(part.first_Y);
  for (int c = 0; c < part.n_modes; ++c) {
    double own = x(part.first_Y + 6 + c);
    for (int k = 0; k < c; ++k) own -= part.L_modal(c, k) * part.modal(k);
    part.modal(c) = own;
    part.rigid -= (part.inverse_D_modal(c) * own) * part.coupling.col(c);
  }
  solve_lower(part.L_rigid, part.rigid);
  const Vec6 weighted = part.inverse_D_rigid.cwiseProduct(part.rigid);
  for (const Leg& leg : legs_of(part)) {
    Vec6 sum = multipliers_.col(leg.node);
#pragma GCC unroll 6
    for (int c = 0; c < 6; ++c) sum += weighted(c) * leg.W.col(c);
    for (int c = 0; c < part.n_modes; ++c) sum += (part.inverse_D_modal(c) * part.modal(c)) * leg.W.col(6 + c);
    multipliers_.col(leg.node) = sum;
  }
}

/// L^-T D^-1 (y - W^T lambda) (C67).
void InertiaElimination::substitute(Part& part, VecX& x) {
  for (const Leg& leg : legs_of(part)) {
    const Vec6 lambda = multipliers_.col(leg.node);
    part.rigid -= transpose_times(leg.W.leftCols<6>(), lambda);
    for (int c = 0; c < part.n_modes; ++c) part.modal(c) -= leg.W.col(6 + c).dot(lambda);
  }
  part.rigid.array() *= part.inverse_D_rigid.array();
  solve_upper(part.L_rigid, part.rigid);
  for (int c = part.n_modes - 1; c >= 0; --c) {
    double own = part.inverse_D_modal(c) * (part.modal(c) - part.coupling.col(c).dot(part.rigid));
    for (int k = c + 1; k < part.n_modes; ++k) own -= part.L_modal(k, c) * part.modal(k);
    part.modal(c) = own;
  }
  x.segment<6>(part.first_Y) = part.rigid;
  x.segment(part.first_Y + 6, part.n_modes) = part.modal;
}

double InertiaElimination::largest_residual(const VecX& right_side, const VecX& x, const VecX& least) {
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    const auto node = static_cast<Eigen::Index>(k);
    for (std::size_t own = 0; own < nodes_[k].size(); ++own) {
      const auto row = static_cast<Eigen::Index>(own);
      multipliers_(row, node) = x(n_Y_ + nodes_[k][own]);
      row_residuals_(row, node) = right_side(n_Y_ + nodes_[k][own]);
    }
  }
  row_terms_ = row_residuals_.cwiseAbs();
  double largest = 0.0;
  for (Part& part : parts_) largest = larger(residual_of(part, right_side, x, least), largest);
  residual_.tail(residual_.size() - n_Y_).setZero();
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    const auto node = static_cast<Eigen::Index>(k);
    for (std::size_t own = 0; own < nodes_[k].size(); ++own) {
      const auto row = static_cast<Eigen::Index>(own);
      residual_(n_Y_ + nodes_[k][own]) = row_residuals_(row, node);
      largest = larger(part_of(row_residuals_(row, node), row_terms_(row, node)), largest);
    }
  }
  return largest;
}

void InertiaElimination::correct(VecX& x) {
  solve(residual_);
  x += residual_;
}

/// The modal rows of M x, and the sizes of their terms.
void InertiaElimination::subtract_modal_rows(const Part& part, const VecX& x, double* left, double* terms) {
  for (int c = 0; c < part.n_modes; ++c) {
    left[c] -= part.M.col(6 + c).dot(x.segment<6>(part.first_Y)) +
               part.modal_mass.col(c).dot(x.segment(part.first_Y + 6, part.n_modes));
    terms[c] += part.M.col(6 + c).cwiseAbs().dot(part.sizes.head<6>()) +
                part.modal_mass.col(c).cwiseAbs().dot(part.sizes.tail(part.n_modes));
  }
}

/// Of a body's own equations; adds its part to those of the rows.
double InertiaElimination::residual_of(Part& part, const VecX& right_side, const VecX& x, const VecX& least) {
  const int n = 6 + part.n_modes;
  const double* own = x.data() + part.first_Y;
  double* left = residual_.data() + part.first_Y;
  double* terms = part.terms.data();
  for (int c = 0; c < n; ++c) {
    part.sizes(c) = std::max(std::abs(own[c]), least(part.first_Y + c));
    left[c] = right_side(part.first_Y + c);
    terms[c] = std::abs(left[c]);
  }
  Vec6 rigid = Eigen::Map<const Vec6>(left);
  Vec6 rigid_terms = Eigen::Map<const Vec6>(terms);
  for (int c = 0; c < n; ++c) {
    rigid -= own[c] * part.M.col(c);
    rigid_terms += part.sizes(c) * part.M.col(c).cwiseAbs();
  }
  subtract_modal_rows(part, x, left + 6, terms + 6);
  for (const Leg& leg : legs_of(part)) {
    const Vec6 lambda = multipliers_.col(leg.node);
    const Vec6 sizes = lambda.cwiseAbs();
    Vec6 of_rows = row_residuals_.col(leg.node);
    Vec6 of_row_terms = row_terms_.col(leg.node);
    const Mat6 absolute = leg.J.leftCols<6>().cwiseAbs();
    rigid -= transpose_times(leg.J, lambda);
    rigid_terms += transpose_times(absolute, sizes);
#pragma GCC unroll 6
    for (int c = 0; c < 6; ++c) {
      of_rows -= own[c] * leg.J.col(c);
      of_row_terms += part.sizes(c) * absolute.col(c);
    }
    for (int c = 6; c < n; ++c) {
      const Vec6 column = leg.J.col(c);
      const Vec6 size = column.cwiseAbs();
      of_rows -= own[c] * column;
      of_row_terms += part.sizes(c) * size;
      left[c] -= column.dot(lambda);
      terms[c] += size.dot(sizes);
    }
    row_residuals_.col(leg.node) = of_rows;
    row_terms_.col(leg.node) = of_row_terms;
  }
  Eigen::Map<Vec6>{left} = rigid;
  Eigen::Map<Vec6>{terms} = rigid_terms;
  double largest = 0.0;
  for (int c = 0; c < n; ++c) largest = larger(part_of(left[c], terms[c]), largest);
  return largest;
}

}  // namespace concord::cartesian
