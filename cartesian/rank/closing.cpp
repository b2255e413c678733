#include "cartesian/rank/closing.h"

#include <algorithm>
#include <cmath>

#include "cartesian/dynamics/state_scales.h"
#include "cartesian/rank/closing_system.h"
#include "cartesian/rank/kept_rows.h"

namespace concord::cartesian {

namespace {

constexpr double kClosed = 1e-13;  // in the machine's units and of the row's terms; velocities of the largest
constexpr int kMaxSteps = 80;
constexpr double kNearer = 0.98;  // of the residual
constexpr int kBarrenSteps = 16;  // that have come no nearer: Newton's method goes round a pose that cannot be closed

double size_of(const VecX& residual) { return residual.size() == 0 ? 0.0 : residual.lpNorm<Eigen::Infinity>(); }

/// Residuals by the sizes of their rows.
void name_open(const Equations& equations, const std::vector<KeptRow>& kept, const VecX& residual, Closing& closing) {
  const Model& model = equations.model();
  const double large = 0.05 * size_of(residual);
  for (const JointIndex k : indices_of(model.joints)) {
    const JointLayout& joint = equations.constraints().joint(k);
    double own = size_of(residual.segment(joint.first_row.value, joint.n_rows));
    for (std::size_t row = 0; row < kept.size(); ++row) {
      if (kept[row].joint != k) continue;
      own = std::max(own, std::abs(residual(equations.constraints().n_rows() + row)));
    }
    if (own >= large) closing.joints_left_open.push_back(pick(model.joints, k).name);
  }
  for (const CouplingIndex g : indices_of(model.couplings)) {
    const double own = std::abs(residual(equations.constraints().coupling(g).row.value));
    if (own >= large) closing.couplings_left_open.push_back(pick(model.couplings, g).name);
  }
}

/// Whether another Newton step is worth while: not yet closed, or still falling.
bool goes_on(double size, double last, double closed) {
  return size > closed ? true : size > 0.0 && size < 0.25 * last;
}

/// Newton's method on positions; the best q that it meets stays.
template <class Rows>
void close_positions(Equations& equations, double t, Holding hold, const Rows& rows, Modes modes, VecX& q,
                     const VecX& Y, ShortestSolver& solver, Closing& closing, std::optional<int> rank = {}) {
  const VecX units = units_of_steps(equations, Kept::coordinates, modes);
  RoundOffShares shares(equations.constraints());
  const auto system_at = [&] {
    equations.update(t, q, Y);
    measure_round_off(equations, t, q, shares);
    return make_system(equations, hold, Kept::coordinates, units, shares, rows());
  };
  ClosingSystem system = system_at();
  VecX best_q = q;
  double best = system.largest_residual();
  double last = HUGE_VAL;
  double near = best;
  int nearer_at = 0;
  ClosingReach reach;
  for (int step = 0; step < kMaxSteps && goes_on(system.largest_residual(), last, kClosed); ++step) {
    if (step > nearer_at + kBarrenSteps) break;
    last = system.largest_residual();
    write_jacobian(equations, Kept::coordinates, units, system);
    const VecX move = system.shortest_step(solver, rank);
    if (!move.allFinite()) break;
    const double part = reach.part_of(equations.layout(), move);
    equations.layout().displace(units.cwiseProduct(part * move), q);
    equations.update(t, q, Y);
    equations.moving_constraints().follow_turns();
    const VecX before = std::move(system.residual);
    system = system_at();
    reach.learn(before, system.residual, part);
    if (system.largest_residual() <= best) {
      best = system.largest_residual();
      best_q = q;
    }
    if (best < kNearer * near) {
      near = best;
      nearer_at = step;
    }
  }
  if (q != best_q) {
    q = best_q;
    system = system_at();
  }
  closing.position_residual = system.largest_residual();
  closing.closed = closing.position_residual <= kClosed;
  if (!closing.closed) name_open(equations, system.kept, system.residual, closing);
}

void close_velocities(Equations& equations, double t, Hold hold, Modes modes, const VecX& q, VecX& Y,
                      ShortestSolver& solver, Closing& closing) {
  constexpr int kMostSteps = 4;
  constexpr double kRoundOff = 1e-16;
  const VecX units = units_of_steps(equations, Kept::speeds, modes);
  const RoundOffShares none(equations.constraints());  // velocities are judged by their rate
  const auto system_at = [&] {
    equations.update(t, q, Y);
    return make_system(equations, {hold}, Kept::speeds, units, none, kept_at(equations, hold, Kept::speeds));
  };
  ClosingSystem system = system_at();
  const auto speed = [&] { return std::max(system.kept_rate, largest_rate(equations, t, Y)); };
  double last = HUGE_VAL;
  for (int step = 0; step < kMostSteps && system.rate() > kRoundOff * speed() && system.rate() < 0.5 * last; ++step) {
    last = system.rate();
    write_jacobian(equations, Kept::speeds, units, system);
    Y += units.cwiseProduct(system.shortest_step(solver));
    system = system_at();
  }
  closing.velocity_residual = system.rate();
  closing.closed = closing.velocity_residual <= kClosed * speed();
  if (!closing.closed) name_open(equations, system.kept, system.residual, closing);
}

}  // namespace

bool modes_are_restricted(const Equations& equations) {
  const auto rank = [&](Modes modes) {
    const VecX units = units_of_steps(equations, Kept::speeds, modes);
    return rank_of_rows(equations, Kept::speeds, {}, units);
  };
  return equations.model().is_flexible() && rank(Modes::moving) > rank(Modes::kept);
}

Closing close_machine(Equations& equations, double t, Hold hold, Modes modes, VecX& q, VecX& Y,
                      std::optional<int> rank) {
  ShortestSolver solver;
  return close_machine(equations, t, hold, modes, q, Y, solver, rank);
}

Closing close_machine(Equations& equations, double t, Hold hold, Modes modes, VecX& q, VecX& Y, ShortestSolver& solver,
                      std::optional<int> rank) {
  Closing closing;
  equations.layout().normalize(q);
  const auto rows = [&] { return kept_at(equations, hold, Kept::coordinates); };
  close_positions(equations, t, {hold}, rows, modes, q, Y, solver, closing, rank);
  if (!closing.closed) return closing;
  if (const std::optional<JointIndex> joint = equations.moving_constraints().first_joint_off_branch()) {
    closing.closed = false;
    closing.is_off_branch = true;
    closing.joints_left_open = {pick(equations.model().joints, *joint).name};
    return closing;
  }
  closing.places_closed = true;
  close_velocities(equations, t, hold, modes, q, Y, solver, closing);
  return closing;
}

std::optional<TurnError> largest_turn_error(const Equations& equations, const std::vector<VecX>& q) {
  std::optional<TurnError> largest;
  each_counting_reading(equations.model(), [&](JointIndex k, int place, const joints::Read& read, int component) {
    const double value = evaluate_read(read, component, equations.moving_constraints().joint(k).motion).value;
    const double error = std::abs(value - q[k.value](place));
    if (!largest || error > largest->size) largest = TurnError{k, error, value, q[k.value](place)};
  });
  return largest;
}

void seek_turns(Equations& equations, double t, Modes modes, const std::vector<VecX>& known, VecX& q, const VecX& Y) {
  const VecX before = q;
  Closing closing;
  ShortestSolver solver;
  const auto rows = [&] { return turn_rows(equations, known); };
  close_positions(equations, t, {Hold::constraints}, rows, modes, q, Y, solver, closing);
  if (closing.closed) return;
  q = before;
  equations.count_turns_from(known);
}

std::vector<StartWord> words_to_keep(Equations& equations, double t, const VecX& q, const VecX& Y, Kept what) {
  constexpr int kMostNamed = 12;  // longer lists are not read
  constexpr int kMostTried = 200;
  equations.update(t, q, Y);
  const VecX units = units_of_steps(equations, Kept::speeds, Modes::kept);
  const auto rank_with = [&](const std::vector<KeptRow>& kept) { return rank_of_rows(equations, what, kept, units); };
  const int constrained = rank_with({});
  const int freedom = static_cast<int>((units.array() > 0.0).count()) - constrained;
  std::vector<StartWord> chosen;
  if (freedom > kMostNamed) return chosen;
  std::vector<KeptRow> rows;
  int tried = 0;
  for (const StartWord& word : words_kept_first(equations.model(), what)) {
    if (std::ssize(rows) == freedom || ++tried > kMostTried) break;
    std::vector<KeptRow> with = rows;
    add_kept_rows(equations, word, with);
    if (with.size() == rows.size() || std::ssize(with) > freedom) continue;
    if (rank_with(with) < constrained + static_cast<int>(with.size())) continue;
    rows = std::move(with);
    chosen.push_back(word);
  }
  if (std::ssize(rows) < freedom) chosen.clear();
  return chosen;
}

KeptCount count_kept(Equations& equations, double t, const VecX& q, const VecX& Y, bool coarse) {
  equations.update(t, q, Y);
  const VecX units = units_of_steps(equations, Kept::speeds, Modes::kept);
  const auto columns = static_cast<int>((units.array() > 0.0).count());
  const auto rank_with = [&](Kept what, const std::vector<KeptRow>& kept) {
    return rank_of_rows(equations, what, kept, units, coarse);
  };
  const std::vector<KeptRow> coordinates = kept_rows(equations, Kept::coordinates);
  const std::vector<KeptRow> speeds = kept_rows(equations, Kept::speeds);
  const int constrained = rank_with(Kept::coordinates, {});
  const bool has_nonholonomic_rows = equations.constraints().has_nonholonomic_rows();
  const int speeds_constrained = has_nonholonomic_rows ? rank_with(Kept::speeds, {}) : constrained;
  KeptCount count;
  count.coordinates = static_cast<int>(coordinates.size());
  count.speeds = static_cast<int>(speeds.size());
  count.speeds_kept_as_wholes = static_cast<int>(
      std::count_if(speeds.begin(), speeds.end(), [](const KeptRow& row) { return row.component > 0; }));
  count.coordinate_freedom = columns - constrained;
  count.speed_freedom = columns - speeds_constrained;
  count.independent_coordinates = rank_with(Kept::coordinates, coordinates) - constrained;
  count.independent_speeds = rank_with(Kept::speeds, speeds) - speeds_constrained;
  return count;
}

}  // namespace concord::cartesian
