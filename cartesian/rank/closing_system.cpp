#include "cartesian/rank/closing_system.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cartesian/rank/rank.h"

namespace concord::cartesian {

std::vector<KeptRow> kept_at(const Equations& equations, Hold hold, Kept what) {
  return hold == Hold::start ? kept_rows(equations, what) : std::vector<KeptRow>{};
}

VecX units_of_steps(const Equations& equations, Kept what, Modes modes) {
  const Layout& layout = equations.layout();
  VecX units = what == Kept::coordinates ? equations.scales().displacements : equations.units();
  if (modes == Modes::moving) return units;
  for (const BodyIndex i : layout.moving_bodies()) layout.adot(units, i).setZero();
  return units;
}

SparseMatrix closing_jacobian(const Equations& equations, Kept what, const std::vector<KeptRow>& kept,
                              const VecX& units) {
  const MovingConstraints& constraints = equations.moving_constraints();
  const Layout& layout = equations.layout();
  std::vector<Eigen::Triplet<double, SparseIndex>> entries;
  const auto add = [&](int row, BodyIndex body, const auto& gradient) {
    for (int c = 0; c < layout.size_Y(body); ++c) {
      const int column = layout.first_Y(body) + c;
      if (units(column) > 0.0) entries.emplace_back(row, column, gradient(c) * units(column));
    }
  };
  for (const RowBlock& block : constraints.blocks()) {
    for (int row = 0; row < block.n_rows; ++row) {
      const bool counts = what == Kept::speeds || constraints.holds_positions(block.row(row));
      if (counts) add(block.row(row).value, block.body, constraints.columns(block).col(row));
    }
  }
  for (std::size_t k = 0; k < kept.size(); ++k) {
    for (const Side side : {Side::parent, Side::child}) {
      const BodyIndex body = body_of(pick(equations.model().joints, kept[k].joint).on(side));
      if (is_ground(body)) continue;
      VecX gradient(layout.size_Y(body));
      write_transposed(constraints.joint(kept[k].joint), side, kept[k].row, gradient);
      add(constraints.n_rows() + static_cast<int>(k), body, gradient);
    }
  }
  SparseMatrix jacobian(constraints.n_rows() + static_cast<Eigen::Index>(kept.size()), layout.n_Y());
  jacobian.setFromTriplets(entries.begin(), entries.end());
  return jacobian;
}

namespace {

/// Norms of the rows of a closing Jacobian over steps, those of the constraints as the equations measure them; 1 for a
/// row that vanishes.
VecX closing_sizes(const Equations& equations, const SparseMatrix& jacobian) {
  VecX sizes = VecX::Zero(jacobian.rows());
  for (Eigen::Index column = 0; column < jacobian.outerSize(); ++column) {
    for (SparseMatrix::InnerIterator entry(jacobian, column); entry; ++entry) {
      sizes(entry.row()) += entry.value() * entry.value();
    }
  }
  sizes = sizes.cwiseSqrt();
  sizes.head(equations.constraints().n_rows()) = equations.row_sizes();
  return sizes.unaryExpr([](double size) { return size > 0.0 ? size : 1.0; });
}

}  // namespace

int rank_of_rows(const Equations& equations, SparseMatrix jacobian, bool coarse) {
  constexpr double kRootOfRoundOff = 1e-6;
  jacobian = closing_sizes(equations, jacobian).cwiseInverse().asDiagonal() * jacobian;
  const RankDecision decision = decide_rank(jacobian);
  if (!coarse) return decision.rank;
  return static_cast<int>(jacobian.rows() - (decision.near_values.array() <= kRootOfRoundOff).count());
}

ClosingSystem make_system(const Equations& equations, Holding hold, Kept what, const VecX& units,  // (C47)
                          const RoundOffShares& shares, std::vector<KeptRow> kept_rows) {
  const MovingConstraints& constraints = equations.moving_constraints();
  const int n_rows = constraints.n_rows();
  ClosingSystem system;
  system.kept = std::move(kept_rows);
  const std::vector<KeptRow>& kept = system.kept;
  system.jacobian = closing_jacobian(equations, what, kept, units);
  VecX by_size = closing_sizes(equations, system.jacobian).cwiseInverse();
  for (const RowIndex row : constraints.rows()) by_size(row.value) *= hold.weight(constraints, row);
  system.jacobian = by_size.asDiagonal() * system.jacobian;
  system.residual.resize(system.jacobian.rows());
  system.terms.resize(system.residual.size());
  system.residual.head(n_rows) = what == Kept::coordinates ? equations.residual() : equations.velocity_residual();
  system.terms.head(n_rows) = shares.terms;
  for (std::size_t k = 0; k < kept.size(); ++k) {
    const RelativeMotion& motion = constraints.joint(kept[k].joint).motion;
    const Eigen::Index row = n_rows + static_cast<Eigen::Index>(k);
    system.residual(row) =
        what == Kept::coordinates ? kept[k].row.value : rate_of(kept[k].row, motion) - kept[k].target;
    system.kept_rate = std::max(system.kept_rate, std::abs(kept[k].target) * by_size(row));
    system.terms(row) = std::max(kept[k].row.reads_places() ? shares.reach : 1.0, kept[k].size * by_size(row));
  }
  system.residual = system.residual.cwiseProduct(by_size);
  return system;
}

double ClosingReach::part_of(const Layout& layout, const VecX& step) const {
  double turn = 0.0;
  double other = 0.0;
  for (const BodyIndex i : layout.moving_bodies()) {
    const Eigen::Index first = layout.first_Y(i);
    for (int c = 0; c < layout.size_Y(i); ++c) {
      double& largest = c >= 3 && c < 6 ? turn : other;
      largest = std::max(largest, std::abs(step(first + c)));
    }
  }
  return std::min({1.0, kLargestTurn / std::max(turn, kLargestTurn), farthest_ / std::max(other, farthest_)});
}

void ClosingReach::learn(const VecX& before, const VecX& after, double part) {
  constexpr double kStraight = 0.01;  // of what the step takes away
  constexpr double kNothing = 1e-9;   // of the largest residual
  const VecX bent = (after - (1.0 - part) * before).cwiseAbs();
  const double floor = before.size() == 0 ? 0.0 : kNothing * before.lpNorm<Eigen::Infinity>();
  const bool is_straight = (bent.array() <= kStraight * part * before.array().abs() + floor).all();
  farthest_ = is_straight ? 2.0 * farthest_ : kLargestTurn;
}

}  // namespace concord::cartesian
