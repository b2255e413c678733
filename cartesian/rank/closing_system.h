#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "cartesian/dynamics/equations.h"
#include "cartesian/dynamics/state_scales.h"
#include "cartesian/rank/closing.h"
#include "cartesian/rank/kept_rows.h"
#include "cartesian/rank/rank.h"

/// The linear systems by which a machine is closed: residuals of constraints and of what the start keeps, by their
/// sizes, and their Jacobian over steps in the machine's units.
namespace concord::cartesian {

/// What the start keeps, where closing holds that.
std::vector<KeptRow> kept_at(const Equations& equations, Hold hold, Kept what);

/// What a unit of a closing step of speeds, or of coordinates, moves over Y: the machine's units, or its displacements,
/// without those of modes that are kept.
VecX units_of_steps(const Equations& equations, Kept what, Modes modes);

/// Rank of the Jacobian over steps in these units: constraints first, then the kept rows. `coarse`: singular values
/// below kRootOfRoundOff of the largest count as zero.
int rank_of_rows(const Equations& equations, Kept what, const std::vector<KeptRow>& kept, const VecX& units,
                 bool coarse = false);

/// What closing holds, and a joint that gives way where not all of it can be: what this forbids weighs so much.
struct Holding {
  Hold what;
  std::optional<JointIndex> giving_way = {};
  double weight_of_giving_way = 1.0;

  [[nodiscard]] double weight(const MovingConstraints& constraints, RowIndex row) const {
    if (what == Hold::joints_alone && constraints.is_driver(row)) return 0.0;
    if (!giving_way) return 1.0;
    const JointLayout& joint = constraints.joint(*giving_way);
    const int own = row.value - joint.first_row.value;
    return own >= 0 && own < joint.n_forbids ? weight_of_giving_way : 1.0;
  }
};

/// Residuals by the sizes of their rows, and the Jacobian that goes with them: numbers in the machine's units.
struct ClosingSystem {
  std::vector<KeptRow> kept;
  VecX by_row;  // 1 over the size, times the weight
  VecX residual;
  SparseMatrix jacobian;   // once it is written
  VecX terms;              // how often a residual holds its round-off
  double kept_rate = 0.0;  // the largest speed that is kept, by the size of its row [1/s]

  [[nodiscard]] VecX shortest_step(ShortestSolver& solver, std::optional<int> rank = {}) const {  // (C47)
    return solve_shortest(jacobian, -residual, solver, rank);
  }
  [[nodiscard]] double largest_residual() const {
    return residual.size() == 0 ? 0.0 : residual.cwiseQuotient(terms).lpNorm<Eigen::Infinity>();
  }
  [[nodiscard]] double rate() const { return residual.size() == 0 ? 0.0 : residual.lpNorm<Eigen::Infinity>(); }
};

/// At the last update, without the Jacobian, which takes most of the time and serves steps alone.
ClosingSystem make_system(const Equations& equations, Holding hold, Kept what, const VecX& units,
                          const RoundOffShares& shares, std::vector<KeptRow> kept_rows);
/// At the update of the system.
void write_jacobian(const Equations& equations, Kept what, const VecX& units, ClosingSystem& system);

/// How far one step of Newton's method on positions may go: half a radian, so that no turn is lost and no other branch
/// is met, and half the machine's length. Where a step leaves of every residual what its first order says, as along a
/// slide that a rope hauls, the way is straight, and the next step may displace bodies twice as far.
class ClosingReach {
 public:
  /// The part of a step [dr; dpi; da], in the machine's units, that may be made; at most one.
  [[nodiscard]] double part_of(const Layout& layout, const VecX& step) const;
  /// Residuals before and after that `part` of a step was made.
  void learn(const VecX& before, const VecX& after, double part);

 private:
  static constexpr double kLargestTurn = 0.5;  // rad
  double farthest_ = kLargestTurn;             // of all else, in the machine's units
};

}  // namespace concord::cartesian
