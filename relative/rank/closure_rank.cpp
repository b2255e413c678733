#include "relative/rank/closure_rank.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "common/error.h"
#include "relative/rank/closing.h"
#include "relative/rank/row_rank.h"

namespace concord::relative {

namespace {

/// By how much coordinates of the tree are moved in search of a general pose: their units, modes a twentieth of it.
VecX exploring_steps(const Equations& equations) {
  VecX steps = equations.size().speeds();
  for (const Span& modes : equations.topology().modes) steps.segment(modes.first_u, modes.n_u) *= 0.05;
  return steps;
}

/// Over q: 1 for coordinates of joints and modes that closure rows hold which depend on others in this pose, else 0.
/// What moves elsewhere in the machine says nothing of these rows.
VecX held_by_dependent_rows(const ScaledClosure& scaled, Coordinates closed) {
  constexpr double kRoundOff = 1e-9;
  const Topology& topology = scaled.equations().topology();
  VecX held = VecX::Zero(topology.n_q);
  scaled.move(closed);
  const std::vector<int>& columns = scaled.free_columns();
  const MatX Phi = scaled.rows(columns);
  if (Phi.size() == 0) return held;
  const RowRank rows(Phi);
  const MatX dependent = rows.vanishing_combinations(rows.rank());
  const VecX takes_part = (dependent.rowwise().norm().array() > kRoundOff).select(VecX::Ones(Phi.rows()), 0.0);
  const VecX effect = Phi.cwiseAbs().transpose() * takes_part;
  const auto mark = [&](const Span& span) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const bool is_its = columns[c] >= span.first_u && columns[c] < span.first_u + span.n_u;
      if (is_its && effect(static_cast<Eigen::Index>(c)) > kRoundOff) held.segment(span.first_q, span.n_q).setOnes();
    }
  };
  for (const Span& span : topology.joints) mark(span);
  for (const Span& span : topology.modes) mark(span);
  return held;
}

}  // namespace

/// Joints alone close a machine as far as its loops leave the modes free; others must move too. In a pose
/// that is not closed, dependent rows look independent, so that the ranks must be taken in a closed one.
void ClosureRank::decide_modes(const Coordinates& closed) {
  const auto rank_with = [&](Modes modes) { return scaled_->rank(closed, ClosureRows::of_velocities, modes); };
  const bool restricted =
      scaled_->equations().model().is_flexible() && rank_with(Modes::moving) > rank_with(Modes::kept);
  closing_modes_ = restricted ? Modes::moving : Modes::kept;
}

void ClosureRank::decide_near(const Coordinates& closed) {
  constexpr int kTrials = 8;
  // In the units of the coordinates. What folds to a pose that it cannot leave closes near that pose again and again.
  constexpr double kElsewhere = 1e-4;
  constexpr double kNearest = 0.0002;
  int looks = 4;
  double far = 0.2;
  struct Found {
    int rank;
    Coordinates pose;
  };
  Found clear{scaled_->rank(closed, ClosureRows::of_velocities, Modes::moving), closed};
  Found doubtful{0, closed};
  bool is_clear = false;  // whether another pose was found that is apart from singular ones
  std::mt19937 random(1);
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  const PrescribedMask nothing(scaled_->equations().topology().n_u, 0);
  Closure free(scaled_->equations().kinematics(), nothing);
  const std::vector<int> columns = scaled_->moving_columns(nothing, Modes::moving);
  const VecX steps = exploring_steps(scaled_->equations());
  const bool has_dependent = clear.rank < scaled_->closure().n_rows();
  const VecX held = has_dependent ? held_by_dependent_rows(*scaled_, closed) : VecX();
  for (int trial = 0; trial < kTrials && looks > 0 && clear.rank < scaled_->closure().n_rows(); ++trial) {
    Coordinates nearby = closed;
    VecX step = VecX::Zero(scaled_->equations().topology().n_tree_u);
    for (const int c : columns) step(c) = far * part(random) * steps(c);
    scaled_->advance(nearby.q, step);
    if (try_to_measure(*scaled_, nearby, free) == HUGE_VAL ||
        !close_positions(*scaled_, nearby, nothing, Modes::moving)) {
      --looks;
      continue;
    }
    scaled_->move(nearby);
    const RowRank rows(scaled_->rows(scaled_->free_columns()));
    const bool is_doubtful = rows.is_beside_singular();
    if (!is_doubtful) --looks;
    // Near a flat pose only poses that are nearer still are apart from it.
    if (is_doubtful) far = std::max(0.25 * far, kNearest);
    const bool has_moved = scaled_->size().largest_coordinate(held.cwiseProduct(nearby.q - closed.q)) > kElsewhere;
    is_clear = is_clear || (!is_doubtful && has_moved);
    Found& best = is_doubtful ? doubtful : clear;
    if (rows.rank() > best.rank) best = {rows.rank(), nearby};
  }
  // A machine whose rows are hardly independent anywhere has the rank that it shows.
  const Found& most = !is_clear && doubtful.rank > clear.rank ? doubtful : clear;
  decide_modes(most.pose);
  is_decided_ = true;
  scaled_->equations().loops().set_rank(most.rank);
}

void ClosureRank::require_general(const Coordinates& coordinates, const Evaluated& evaluated) const {
  // Pivots in the metric of the inverse inertia are squares of sines between rows: above this no row depends.
  constexpr double kSurelyIndependent = 1e-10;
  if (scaled_->closure().n_rows() == 0 || evaluated.loops().least_pivot > kSurelyIndependent) return;
  if (scaled_->rank_here(ClosureRows::of_velocities, Modes::moving) < rank()) throw_singular(coordinates, "");
}

void ClosureRank::require_agreeing_rows(const Coordinates& coordinates, const Evaluated& evaluated) const {
  constexpr double kContradiction = 1e-7;  // of the machine's accelerations
  if (rank() == scaled_->closure().n_rows()) return;
  const double rate = scaled_->size().rate_at(coordinates.u);
  const double largest = std::max(rate * rate, scaled_->size().largest_speed(evaluated.udot()));
  const Closure& closure = scaled_->closure();
  const std::optional<RowIndex> row = evaluated.loops().contradicted_row(closure.row_units(), kContradiction * largest);
  if (!row) return;
  throw SingularPose(fmt::format(
      "relative: at t = {:.6g} s no accelerations close everything: rows at {} depend on others in this pose "
      "and contradict them: the pose is singular, or a driver moves what the loops hold",
      coordinates.t, closure.worst_place(VecX::Unit(closure.n_rows(), *row))));
}

void ClosureRank::throw_singular(const Coordinates& coordinates, const std::string& passing) const {
  scaled_->equations().move(coordinates.t, coordinates.q, coordinates.u);
  const Closure& closure = scaled_->closure();
  const RowRank rows(scaled_->rows(scaled_->free_columns()));
  throw SingularPose(fmt::format(
      "relative: at t = {:.6g} s the {} closure rows{} {}lose rank: {} of {} at {}: the pose is singular and the "
      "motion may branch",
      coordinates.t, closure.n_rows(),
      closure.speed_constraints().empty() ? "" : " of loops, couplings and rolling contacts", passing,
      std::min(rows.rank(), rank() - 1), rank(), closure.worst_place(rows.weakest_combination(rank()))));
}

double ClosureRank::singular_value(const MatX& Phi) const {
  const bool is_clear = rank() == scaled_->closure().n_rows() && loop_rows_.factor(VecX::Ones(Phi.cols()));
  return is_clear ? loop_rows_.singular_value() : RowRank(Phi).singular_value(rank());
}

}  // namespace concord::relative
