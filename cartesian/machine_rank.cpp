#include "cartesian/machine_rank.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "cartesian/pose_watch.h"
#include "cartesian/rank.h"
#include "cartesian/row_choice.h"
#include "common/error.h"

namespace concord::cartesian {

namespace {

/// Rank at a closed pose near the start; 0 if none was found.
int rank_nearby(Equations& equations, const State& start, Modes modes, std::mt19937& engine) {
  constexpr double kFar = 0.2;  // in the machine's units
  const Layout& layout = equations.layout();
  std::uniform_real_distribution<double> spread(-kFar, kFar);
  VecX q(layout.n_q());
  VecX Y(layout.n_Y());
  layout.unpack(start, q, Y);
  VecX move = VecX::NullaryExpr(layout.n_Y(), [&] { return spread(engine); }).cwiseProduct(equations.units());
  for (const BodyIndex i : layout.moving_bodies()) layout.adot(move, i).setZero();
  layout.displace(move, q);
  Y.setZero();
  equations.count_turns_from(start.q);
  try {
    if (!close_machine(equations, start.t, Hold::joints_alone, modes, q, Y).closed) return 0;
    return choose_rows(equations, -1).rank;
  } catch (const SolverError&) {
    return 0;  // a deformation out of range on the way
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
  constexpr int kPoses = 4;
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
  std::mt19937 engine(20);
  for (int pose = 0; pose < kPoses; ++pose) {
    machine.generic = std::max(machine.generic, rank_nearby(equations, start, machine.closing_modes, engine));
  }
  equations.count_turns_from(start.q);
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
