#include "cartesian/machine_rank.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "cartesian/pose_watch.h"
#include "cartesian/rank.h"
#include "cartesian/row_choice.h"
#include "common/error.h"

namespace concord::cartesian {

namespace {

/// Rank at a closed pose, whether it counts singular values below 1e-6 of the largest, as there are beside a singular
/// pose, and whether what dependent rows hold is elsewhere than at the start.
struct RankThere {
  int rank = 0;
  bool doubtful = false;
  bool elsewhere = false;
};

/// How far some bodies are from another pose: the largest angle [rad], and the largest way in the machine's length.
struct Distance {
  double turn = 0.0;
  double way = 0.0;
};

Distance distance_between(const Equations& equations, const std::vector<BodyIndex>& bodies, const VecX& one,
                          const VecX& other) {
  const Layout& layout = equations.layout();
  Distance distance;
  for (const BodyIndex i : bodies) {
    const Vec4 p = layout.p(one, i);
    const Vec4 q = layout.p(other, i);
    // Half the angle is that of the chord between the Euler parameters, by one sign or the other.
    const double chord = std::min((p - q).norm(), (p + q).norm());
    distance.turn = std::max(distance.turn, 4.0 * std::asin(std::min(0.5 * chord, 1.0)));
    distance.way =
        std::max(distance.way, (layout.r(one, i) - layout.r(other, i)).norm() / layout.v(equations.units(), i)(0));
  }
  return distance;
}

/// Bodies that rows hold which depend on each other at the last update: what moves elsewhere in the machine says
/// nothing of these rows.
std::vector<BodyIndex> held_by_dependent_rows(const Equations& equations) {
  constexpr double kRoundOff = 1e-9;
  const Layout& layout = equations.layout();
  const SparseMatrix matrix = scaled_jacobian(equations).matrix;
  const VecX takes_part = decide_rank(matrix).left_null_space.rowwise().norm();
  VecX effect = VecX::Zero(matrix.cols());
  for (Eigen::Index k = 0; k < matrix.outerSize(); ++k) {
    for (SparseMatrix::InnerIterator entry(matrix, k); entry; ++entry) {
      if (takes_part(entry.row()) > kRoundOff) effect(entry.col()) += std::abs(entry.value());
    }
  }
  std::vector<BodyIndex> bodies;
  for (const BodyIndex i : layout.moving_bodies()) {
    if (effect.segment(layout.first_Y(i), 6 + layout.n_modes(i)).maxCoeff() > kRoundOff) bodies.push_back(i);
  }
  return bodies;
}

/// Rank at a closed pose about `far` from the start, in the machine's units; nothing if none was found, or one to which
/// a body turns so far that the machine may not move there: what is put together otherwise may be a structure.
std::optional<RankThere> rank_nearby(Equations& equations, const State& start, Modes modes,
                                     const std::vector<BodyIndex>& held, double far, std::mt19937& engine) {
  constexpr double kElsewhere = 1e-4;
  const double too_far = std::max(0.1, 3.0 * far);  // rad
  const Layout& layout = equations.layout();
  std::uniform_real_distribution<double> spread(-far, far);
  VecX q(layout.n_q());
  VecX Y(layout.n_Y());
  layout.unpack(start, q, Y);
  const VecX from = q;
  VecX move = VecX::NullaryExpr(layout.n_Y(), [&] { return spread(engine); }).cwiseProduct(equations.units());
  for (const BodyIndex i : layout.moving_bodies()) layout.adot(move, i).setZero();
  layout.displace(move, q);
  Y.setZero();
  equations.count_turns_from(start.q);
  try {
    if (!close_machine(equations, start.t, Hold::joints_alone, modes, q, Y).closed) return std::nullopt;
    const Distance moved = distance_between(equations, held, from, q);
    if (moved.turn > too_far) return std::nullopt;
    const RankDecision decision = decide_rank(scaled_jacobian(equations).matrix);
    return RankThere{decision.rank, (decision.near_values.array() > kRankThreshold).any(),
                     std::max(moved.turn, moved.way) > kElsewhere};
  } catch (const SolverError&) {
    return std::nullopt;  // a deformation out of range on the way
  }
}

/// Names what the rows' dependence at this pose rests on.
[[noreturn]] void refuse_singular(const Equations& equations, int rank, int generic_rank) {
  constexpr double kRestsOn = 0.1;
  const MatX Z = decide_rank(scaled_jacobian(equations).matrix).left_null_space;
  std::vector<std::string> names;
  for (const RowIndex row : equations.constraints().rows()) {
    if (Z.row(row.value).norm() < kRestsOn) continue;
    const std::string name = equations.constraints().name_of(row);
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  throw SingularPose(
      fmt::format("cartesian: at t = {:.6g} s the machine is in a singular pose: its constraints have rank {} there, "
                  "{} elsewhere; "
                  "those of {} depend on each other; the motion may branch, and reactions may be unbounded",
                  equations.time(), rank, generic_rank, fmt::join(names, ", ")));
}

}  // namespace

MachineRank decide_for_the_machine(Equations& equations, const State& start) {
  // Near a flat pose only poses that are nearer still are apart from it.
  constexpr std::array kFar{0.2, 0.05, 0.0125, 0.003, 0.0008, 0.0002};
  constexpr int kEnough = 4;
  const Layout& layout = equations.layout();
  VecX q(layout.n_q());
  VecX Y(layout.n_Y());
  layout.unpack(start, q, Y);
  equations.update(start.t, q, Y);
  MachineRank machine;
  machine.closing_modes = modes_are_restricted(equations) ? Modes::moving : Modes::kept;
  const int n_rows = equations.constraints().n_rows();
  machine.generic = may_lose_rank(equations.model()) ? choose_rows(equations, n_rows).rank : n_rows;
  if (machine.generic == n_rows) return machine;
  const std::vector<BodyIndex> held = held_by_dependent_rows(equations);
  std::mt19937 engine(20);
  int doubtful = 0;
  int clear = 0;
  for (const double far : kFar) {
    if (clear == kEnough) break;
    const auto there = rank_nearby(equations, start, machine.closing_modes, held, far, engine);
    if (!there) continue;
    if (!there->doubtful && there->elsewhere) ++clear;
    int& rank = there->doubtful ? doubtful : machine.generic;
    rank = std::max(rank, there->rank);
  }
  // A machine whose rows are hardly independent anywhere has the rank that it shows.
  if (clear == 0) machine.generic = std::max(machine.generic, doubtful);
  equations.count_turns_from(start);
  return machine;
}

/// Rows that depend on each other in this pose alone need not agree in what they ask of accelerations.
const Solution& solve_with_independent_rows(Dynamics& dynamics, const MachineRank& machine) {
  const Equations& equations = dynamics.equations();
  if (may_lose_rank(equations.model())) {
    const RowChoice choice = choose_rows(equations, machine.generic);
    if (choice.rank < machine.generic) refuse_singular(equations, choice.rank, machine.generic);
    dynamics.use_rows(choice.independent);
  }
  const Solution& solution = dynamics.solve(Pivots::fresh);
  const std::optional<RowIndex> row = dynamics.contradicted_row(solution);
  if (!row) return solution;
  throw SingularPose(
      fmt::format("cartesian: at t = {:.6g} s no accelerations obey all constraints: those of {} depend on others in "
                  "this pose and contradict them: the pose is singular, or a driver moves what the joints hold",
                  equations.time(), equations.constraints().name_of(*row)));
}

}  // namespace concord::cartesian
