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

namespace {

/// Calls use(body, gradient over the body's Y) for each body that a kept row moves.
template <class Use>
void each_gradient(const Equations& equations, const KeptRow& kept, const Use& use) {
  for (const Side side : {Side::parent, Side::child}) {
    const BodyIndex body = body_of(pick(equations.model().joints, kept.joint).on(side));
    if (is_ground(body)) continue;
    VecX gradient(equations.layout().size_Y(body));
    write_transposed(equations.moving_constraints().joint(kept.joint), side, kept.row, gradient);
    use(body, gradient);
  }
}

/// Over 1 the norms of the rows over steps, those of the constraints as the equations measure them; 1 for a row that
/// vanishes.
VecX reciprocal_sizes(const Equations& equations, const std::vector<KeptRow>& kept, const VecX& units) {
  const Layout& layout = equations.layout();
  const int n_rows = equations.constraints().n_rows();
  VecX sizes = VecX::Zero(n_rows + static_cast<Eigen::Index>(kept.size()));
  sizes.head(n_rows) = equations.row_sizes();
  for (std::size_t k = 0; k < kept.size(); ++k) {
    double& size = sizes(n_rows + static_cast<Eigen::Index>(k));
    each_gradient(equations, kept[k], [&](BodyIndex body, const VecX& gradient) {
      const auto own_units = units.segment(layout.first_Y(body), layout.size_Y(body));
      size = std::hypot(size, gradient.cwiseProduct(own_units).norm());
    });
  }
  return sizes.unaryExpr([](double size) { return size > 0.0 ? 1.0 / size : 1.0; });
}

/// Jacobian over steps in these units, its rows times `by_row`: constraints first, then the kept rows. For coordinates
/// the rows that hold for velocities alone are empty, as is their residual.
SparseMatrix closing_jacobian(const Equations& equations, Kept what, const std::vector<KeptRow>& kept,
                              const VecX& units, const VecX& by_row) {
  const MovingConstraints& constraints = equations.moving_constraints();
  const Layout& layout = equations.layout();
  std::vector<Eigen::Triplet<double, SparseIndex>> entries;
  const auto add = [&](int row, BodyIndex body, const auto& gradient) {
    for (int c = 0; c < layout.size_Y(body); ++c) {
      const int column = layout.first_Y(body) + c;
      if (units(column) > 0.0) entries.emplace_back(row, column, gradient(c) * units(column) * by_row(row));
    }
  };
  for (const RowBlock& block : constraints.blocks()) {
    for (int row = 0; row < block.n_rows; ++row) {
      const bool counts = what == Kept::speeds || constraints.holds_positions(block.row(row));
      if (counts) add(block.row(row).value, block.body, constraints.columns(block).col(row));
    }
  }
  for (std::size_t k = 0; k < kept.size(); ++k) {
    const int row = constraints.n_rows() + static_cast<int>(k);
    each_gradient(equations, kept[k], [&](BodyIndex body, const VecX& gradient) { add(row, body, gradient); });
  }
  SparseMatrix jacobian(by_row.size(), layout.n_Y());
  jacobian.setFromTriplets(entries.begin(), entries.end());
  return jacobian;
}

}  // namespace

int rank_of_rows(const Equations& equations, Kept what, const std::vector<KeptRow>& kept, const VecX& units,
                 bool coarse) {
  constexpr double kRootOfRoundOff = 1e-6;
  const RankDecision decision =
      decide_rank(closing_jacobian(equations, what, kept, units, reciprocal_sizes(equations, kept, units)));
  if (!coarse) return decision.rank;
  const auto n_rows = equations.constraints().n_rows() + std::ssize(kept);
  return static_cast<int>(n_rows - (decision.near_values.array() <= kRootOfRoundOff).count());
}

ClosingSystem make_system(const Equations& equations, Holding hold, Kept what, const VecX& units,  // (C47)
                          const RoundOffShares& shares, std::vector<KeptRow> kept_rows) {
  const MovingConstraints& constraints = equations.moving_constraints();
  const int n_rows = constraints.n_rows();
  ClosingSystem system;
  system.kept = std::move(kept_rows);
  const std::vector<KeptRow>& kept = system.kept;
  system.by_row = reciprocal_sizes(equations, kept, units);
  for (const RowIndex row : constraints.rows()) system.by_row(row.value) *= hold.weight(constraints, row);
  system.residual.resize(system.by_row.size());
  system.terms.resize(system.residual.size());
  system.residual.head(n_rows) = what == Kept::coordinates ? equations.residual() : equations.velocity_residual();
  system.terms.head(n_rows) = shares.terms;
  for (std::size_t k = 0; k < kept.size(); ++k) {
    const RelativeMotion& motion = constraints.joint(kept[k].joint).motion;
    const Eigen::Index row = n_rows + static_cast<Eigen::Index>(k);
    system.residual(row) =
        what == Kept::coordinates ? kept[k].row.value : rate_of(kept[k].row, motion) - kept[k].target;
    system.kept_rate = std::max(system.kept_rate, std::abs(kept[k].target) * system.by_row(row));
    system.terms(row) = std::max(kept[k].row.reads_places() ? shares.reach : 1.0, kept[k].size * system.by_row(row));
  }
  system.residual = system.residual.cwiseProduct(system.by_row);
  return system;
}

void write_jacobian(const Equations& equations, Kept what, const VecX& units, ClosingSystem& system) {
  system.jacobian = closing_jacobian(equations, what, system.kept, units, system.by_row);
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
