#include "cartesian/rank/constraint_rank.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "common/decompositions.h"
#include "common/error.h"

namespace concord::cartesian {

ScaledJacobian scaled_jacobian(const Equations& equations) {
  const MovingConstraints& constraints = equations.moving_constraints();
  const Layout& layout = equations.layout();
  const VecX& units = equations.units();
  ScaledJacobian scaled;
  scaled.row_scale = equations.row_sizes().unaryExpr([](double size) { return size > 0.0 ? 1.0 / size : 1.0; });
  std::vector<Eigen::Triplet<double, SparseIndex>> entries;
  for (const RowBlock& block : constraints.blocks()) {
    const Eigen::Ref<const MatX> Phi_Y_transposed = constraints.columns(block);
    for (int own = 0; own < block.n_rows; ++own) {
      const int row = block.row(own).value;
      for (int c = 0; c < layout.size_Y(block.body); ++c) {
        const int column = layout.first_Y(block.body) + c;
        const double value = Phi_Y_transposed(c, own) * units(column) * scaled.row_scale(row);
        entries.emplace_back(row, column, value);
      }
    }
  }
  scaled.matrix = SparseMatrix(constraints.n_rows(), layout.n_Y());
  scaled.matrix.setFromTriplets(entries.begin(), entries.end());
  return scaled;
}

RowChoice choose_rows(const Equations& equations, int most, RowsOnceClear* before) {
  const Constraints& constraints = equations.constraints();
  const SparseMatrix matrix = scaled_jacobian(equations).matrix;
  const auto are_clear = [&] {
    return before != nullptr ? before->are_independent(matrix) : ClearRows(matrix).are_independent();
  };
  if (most >= matrix.rows() && are_clear()) {
    return {static_cast<int>(matrix.rows()), std::vector<bool>(matrix.rows(), true)};
  }
  std::vector<bool> holds_positions;
  for (const RowIndex row : constraints.rows()) holds_positions.push_back(constraints.holds_positions(row));
  RankDecision decision = decide_rank(matrix, constraints.has_nonholonomic_rows() ? &holds_positions : nullptr);
  if (decision.rank > most && matrix.rows() > kMostDenseRows) {
    (void)pivot_columns(MatX(matrix).transpose(), 0.0, decision.independent);
  }
  RowChoice choice{std::min(decision.rank, most), std::vector<bool>(matrix.rows(), false)};
  for (int k = 0; k < choice.rank; ++k) choice.independent[decision.independent[k]] = true;
  return choice;
}

MatX permitted_velocities(const Equations& equations) {
  const Layout& layout = equations.layout();
  const MatX transposed = MatX(scaled_jacobian(equations).matrix).transpose();
  MatX null_space = MatX::Identity(layout.n_Y(), layout.n_Y());
  if (transposed.cols() > 0) {
    Eigen::ColPivHouseholderQR<MatX> qr(transposed);
    qr.setThreshold(kRankThreshold);
    null_space = orthogonal_factor(qr).rightCols(layout.n_Y() - qr.rank());
  }
  null_space = equations.units().asDiagonal() * null_space;
  const double length = equations.model().length_scale();
  VecX sizes = VecX::Ones(layout.n_Y());
  for (const BodyIndex i : layout.moving_bodies()) {
    null_space.middleRows<3>(layout.first_Y(i)) /= length;
    layout.adot(sizes, i) = layout.adot(equations.units(), i);
  }
  return sizes.asDiagonal() * orthonormal_columns(sizes.cwiseInverse().asDiagonal() * null_space);
}

bool may_lose_rank(const Model& model) {
  if (!model.couplings.empty()) return true;
  ByBody<BodyIndex> tree;
  for (const BodyIndex body : indices_of(model.bodies)) tree.add(body);
  const auto root = [&](BodyIndex body) {
    while (tree[body] != body) body = tree[body];
    return body;
  };
  for (const Joint& joint : model.joints) {
    const bool restricts = joint.type->n_u() < 6 || !joint.drivers.empty();
    if (!restricts) continue;
    const BodyIndex parent = root(body_of(joint.on(Side::parent)));
    const BodyIndex child = root(body_of(joint.on(Side::child)));
    if (parent == child) return true;
    tree[child] = parent;
  }
  return false;
}

namespace {

/// Rank at a closed pose, and whether it counts singular values below 1e-6 of the largest, as there are beside a
/// singular pose.
struct RankThere {
  int rank = 0;
  bool doubtful = false;
};

/// The largest angle by which a body has turned from one pose to the other [rad].
double largest_turn(const Layout& layout, const VecX& one, const VecX& other) {
  double largest = 0.0;
  for (const BodyIndex i : layout.moving_bodies()) {
    const Vec4 p = layout.p(one, i);
    const Vec4 q = layout.p(other, i);
    // Half the angle is that of the chord between the Euler parameters, by one sign or the other.
    const double chord = std::min((p - q).norm(), (p + q).norm());
    largest = std::max(largest, 4.0 * std::asin(std::min(0.5 * chord, 1.0)));
  }
  return largest;
}

/// Rank at a closed pose about `far` from the start, in the machine's units; nothing if none was found, or one to which
/// a body turns so far that the machine may not move there: what is put together otherwise may be a structure.
std::optional<RankThere> rank_nearby(Equations& equations, const State& start, Modes modes, double far,
                                     std::mt19937& engine) {
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
    if (largest_turn(layout, from, q) > too_far) return std::nullopt;
    const RankDecision decision = decide_rank(scaled_jacobian(equations).matrix);
    return RankThere{decision.rank, (decision.near_values.array() > kRankThreshold).any()};
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
  const Layout& layout = equations.layout();
  VecX q(layout.n_q());
  VecX Y(layout.n_Y());
  layout.unpack(start, q, Y);
  equations.update(start.t, q, Y);
  MachineRank machine;
  machine.closing_modes = modes_are_restricted(equations) ? Modes::moving : Modes::kept;
  const int n_rows = equations.constraints().n_rows();
  machine.generic = may_lose_rank(equations.model()) ? choose_rows(equations).rank : n_rows;
  if (machine.generic == n_rows) return machine;
  std::mt19937 engine(20);
  int doubtful = 0;
  bool is_clear = false;
  for (const double far : kFar) {
    const auto there = rank_nearby(equations, start, machine.closing_modes, far, engine);
    if (!there) continue;
    is_clear = is_clear || !there->doubtful;
    int& rank = there->doubtful ? doubtful : machine.generic;
    rank = std::max(rank, there->rank);
  }
  // A machine whose rows are hardly independent anywhere has the rank that it shows.
  if (!is_clear) machine.generic = std::max(machine.generic, doubtful);
  equations.count_turns_from(start);
  return machine;
}

/// Rows that depend on each other in this pose alone need not agree in what they ask of accelerations.
const Solution& solve_with_independent_rows(Dynamics& dynamics, const MachineRank& machine, RowsOnceClear* before) {
  const Equations& equations = dynamics.equations();
  if (may_lose_rank(equations.model())) {
    const RowChoice choice = choose_rows(equations, INT_MAX, before);
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
