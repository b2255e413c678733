#include "relative/rank/closing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/decompositions.h"
#include "common/error.h"
#include "relative/rank/loop_rows.h"
#include "relative/rank/row_rank.h"

namespace concord::relative {

namespace {

constexpr int kMostIterations = 60;
constexpr int kFewRows = 16;
constexpr double kFarthestStep = 0.5;  // in machine units: half a radian, half the length, unless rows are straight
constexpr double kFarFromDependent = 1e-4;  // smallest singular value of rows that need no filter
constexpr double kSquaredDamping = 1e-4;    // damping whose square is far above round-off
constexpr double kBeyondDamping = 30.0;     // times the damping, which takes a thousandth of the step there

/// To the last digit of each, and fast for few rows.
Svd svd_by_rotations(const MatX& Phi) {
  const Eigen::JacobiSVD<MatX> svd(Phi, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return {svd.singularValues(), svd.matrixU(), svd.matrixV()};
}

/// Directions in which the rows are dependent are left alone, those with singular values below the damping hardly used,
/// and those beyond `rank` not (R65).
VecX filtered_step(const MatX& Phi, const VecX& misfit, double damping, std::optional<int> rank) {
  const Svd svd = Phi.rows() <= kFewRows ? svd_by_rotations(Phi) : svd_of(Phi);
  const VecX& sigma = svd.sigma;
  VecX filter = VecX::Zero(sigma.size());
  const Eigen::Index used = std::min<Eigen::Index>(sigma.size(), rank.value_or(static_cast<int>(sigma.size())));
  for (Eigen::Index i = 0; i < used; ++i) {
    if (sigma(i) > kDependentPart * std::max(sigma(0), 1.0))
      filter(i) = sigma(i) / (sigma(i) * sigma(i) + damping * damping);
  }
  return -(svd.V.leftCols(sigma.size()) * filter.cwiseProduct(VecX(svd.U.leftCols(sigma.size()).transpose() * misfit)));
}

/// The same where the damping is so large that squares keep enough digits of it: with Phi Phi^T + mu^2 I = L L^T.
VecX damped_step(const MatX& Phi, const VecX& misfit, double damping) {
  MatX squares = Phi * Phi.transpose();
  squares.diagonal().array() += damping * damping;
  return -(Phi.transpose() * squares.llt().solve(misfit));
}

/// The same without singular values (R66), if all rows that are independent are far from dependent, and from the
/// damping; `rank` of them are used.
std::optional<VecX> undamped_step(const MatX& Phi, const RowRank& factors, const VecX& misfit, double damping,
                                  int rank) {
  const int found = factors.rank();
  const double least = std::max(kFarFromDependent, kBeyondDamping * damping);
  if (found == 0 || rank < found || factors.singular_value(found) <= least) return std::nullopt;
  if (found == factors.n_rows()) return factors.smallest_step(misfit);
  return VecX(-smallest_least_squares(Phi, misfit, kDependentPart));
}

/// A step of the tree's speeds, and whether it takes the whole misfit away to first order.
struct Step {
  VecX u;
  bool is_whole = false;
};

Step find_step(const ScaledClosure& scaled, const Closure& closure, const std::vector<int>& columns, const VecX& misfit,
               double damping, std::optional<int> rank) {
  const MatX Phi = scaled.rows(closure, columns).topRows(misfit.size());
  Step step{VecX::Zero(scaled.equations().topology().n_tree_u)};
  if (Phi.size() == 0) return step;
  const VecX misfit_in_units = misfit.cwiseQuotient(closure.row_units().head(misfit.size()));
  const bool uses_all = rank.value_or(static_cast<int>(Phi.rows())) >= Phi.rows();
  if (Phi.rows() > kFewRows && damping >= kSquaredDamping && uses_all) {
    step.u(columns) = damped_step(Phi, misfit_in_units, damping);
    return step;
  }
  const RowRank factors(Phi);
  const std::optional<VecX> undamped =
      undamped_step(Phi, factors, misfit_in_units, damping, rank.value_or(factors.n_rows()));
  step.is_whole = undamped && factors.rank() == factors.n_rows();
  step.u(columns) = undamped ? *undamped : filtered_step(Phi, misfit_in_units, damping, rank);
  return step;
}

/// The same loop by loop (R81), for which the rows over these columns are factorized where the machine stands.
std::optional<VecX> step_by_loops(LoopRows& loops, const Closure& closure, std::size_t columns, const VecX& misfit,
                                  double damping, std::optional<int> rank) {
  if (misfit.size() < closure.n_rows() || rank.value_or(closure.n_rows()) < closure.n_rows()) return std::nullopt;
  const double least = std::max(kFarFromDependent, kBeyondDamping * damping);
  if (!loops.factor(VecX::Ones(static_cast<Eigen::Index>(columns))) || loops.singular_value() <= least) {
    return std::nullopt;
  }
  return loops.smallest_step(misfit.cwiseQuotient(closure.row_units()));
}

/// find_step(), by loops where these serve.
Step step_of_closing(LoopRows& loops, const ScaledClosure& scaled, const Closure& closure,
                     const std::vector<int>& columns, const VecX& misfit, double damping,
                     std::optional<int> rank = {}) {
  const std::optional<VecX> by_loops = step_by_loops(loops, closure, columns.size(), misfit, damping, rank);
  if (!by_loops) return find_step(scaled, closure, columns, misfit, damping, rank);
  Step step{VecX::Zero(scaled.equations().topology().n_tree_u), true};
  step.u(columns) = *by_loops;
  return step;
}

}  // namespace

VecX smallest_step(const ScaledClosure& scaled, const Closure& closure, const std::vector<int>& columns,
                   const VecX& misfit, double damping, std::optional<int> rank) {
  return find_step(scaled, closure, columns, misfit, damping, rank).u;
}

double measure(const ScaledClosure& scaled, Coordinates& coordinates, Closure& closure) {
  scaled.equations().place(coordinates.t, coordinates.q, coordinates.u);
  closure.measure(coordinates.q, coordinates.u);
  return largest_entry(closure.position_residual().cwiseQuotient(closure.row_units().head(closure.n_position_rows())));
}

double try_to_measure(const ScaledClosure& scaled, Coordinates& coordinates, Closure& closure) {
  try {
    return measure(scaled, coordinates, closure);
  } catch (const SolverError&) {
    return HUGE_VAL;
  }
}

namespace {

/// Where a part of a step leads, and what it leaves open.
struct Trial {
  Coordinates coordinates;
  double residual = HUGE_VAL;
  VecX misfit;
};

/// A step of the tree's speeds (n_tree_u numbers), made in parts from where it begins.
class PartedStep {
 public:
  /// `step`: in SI units.
  PartedStep(const ScaledClosure& scaled, const Coordinates& from, Closure& closure, Step step)
      : scaled_(scaled), from_(from), closure_(closure), step_(std::move(step)) {}

  [[nodiscard]] Trial make(double part) const {
    Trial trial{from_, HUGE_VAL, {}};
    scaled_.advance(trial.coordinates.q, part * step_.u);
    trial.residual = try_to_measure(scaled_, trial.coordinates, closure_);
    trial.misfit = closure_.position_residual();
    return trial;
  }

  /// Goes on from `reached`, a part of the step, twice as far each time, while every row changes in proportion: so does
  /// a coupling, or a thread, along which a slide may have many lengths to go. `begin`: the misfit where it begins.
  /// Whether it has gone, or has looked whether it may.
  bool go_on(const VecX& begin, double part, Trial& reached) const {
    if (step_.is_whole && !is_near(reached.misfit, (1.0 - part) * begin, begin)) return false;
    while (part < 1.0) {
      const double farther = std::min(1.0, 2.0 * part);
      Trial trial = make(farther);
      const VecX expected = begin + farther / part * (reached.misfit - begin);
      if (!(trial.residual < reached.residual) || !is_near(trial.misfit, expected, begin)) break;
      reached = std::move(trial);
      part = farther;
    }
    return true;
  }

 private:
  static bool is_near(const VecX& misfit, const VecX& expected, const VecX& begin) {
    constexpr double kBent = 0.01;      // of a row's change
    constexpr double kRoundOff = 1e-9;  // of the largest row
    const VecX allowed = kBent * (misfit - begin).cwiseAbs();
    return ((misfit - expected).cwiseAbs().array() <= allowed.array() + kRoundOff * largest_entry(begin)).all();
  }

  const ScaledClosure& scaled_;
  const Coordinates& from_;
  Closure& closure_;
  Step step_;
};

/// Round-off adds up along a loop, which has at most all links.
double closed_part(const ScaledClosure& scaled, const Coordinates& coordinates) {
  const double longest = 0.01 * static_cast<double>(scaled.equations().topology().links.size());
  return kClosedPart * std::max(scaled.size_of_places(coordinates.q), longest);
}

/// How fast residuals fall. Where eight steps take less than a fiftieth away, the misfit is stationary: as many steps
/// as are left would not close the machine.
class Pace {
 public:
  /// Takes the residual of each step once.
  [[nodiscard]] bool stalls(double residual) {
    double& before = last_[steps_++ % kSteps];
    const bool is_slow = steps_ > kSteps && residual > kStationary * before;
    before = residual;
    return is_slow;
  }

 private:
  static constexpr std::size_t kSteps = 8;
  static constexpr double kStationary = 0.98;

  std::array<double, kSteps> last_{};
  std::size_t steps_ = 0;
};

}  // namespace

bool close_positions(const ScaledClosure& scaled, Coordinates& coordinates, const PrescribedMask& prescribed,
                     Modes modes, std::optional<int> rank) {
  Closure closure(scaled.equations().kinematics(), prescribed);
  if (closure.n_position_rows() == 0) return true;
  const std::vector<int> columns = scaled.moving_columns(prescribed, modes);
  LoopRows loops(scaled, closure, columns);
  double residual = measure(scaled, coordinates, closure);
  Pace pace;
  for (int iteration = 0; iteration < kMostIterations && residual > 0.0 && !pace.stalls(residual); ++iteration) {
    const VecX misfit = closure.position_residual();
    Step step = step_of_closing(loops, scaled, closure, columns, misfit, std::min(1e-3, residual), rank);
    const double longest = std::min(1.0, kFarthestStep / std::max(largest_entry(step.u), 1e-300));
    step.u = step.u.cwiseProduct(scaled.size().speeds().head(step.u.size()));
    const PartedStep parted(scaled, coordinates, closure, std::move(step));
    double part = longest;
    Trial reached = parted.make(part);
    const bool is_closed = residual < closed_part(scaled, coordinates);  // what a whole step leaves is round-off
    for (int halvings = 1; halvings < 12 && !is_closed && !(reached.residual < residual); ++halvings) {
      part *= 0.5;
      reached = parted.make(part);
    }
    if (!(reached.residual < residual)) break;
    const bool is_cut = longest < 1.0 && part == longest;
    const bool stands_elsewhere = is_cut && parted.go_on(misfit, part, reached);
    coordinates = std::move(reached.coordinates);
    residual = stands_elsewhere ? measure(scaled, coordinates, closure) : reached.residual;
  }
  measure(scaled, coordinates, closure);
  const double allowed = closed_part(scaled, coordinates);
  return residual < allowed || scaled.residual_of_coordinates(closure, columns) < allowed;
}

bool close_velocities(const ScaledClosure& scaled, Coordinates& coordinates, const PrescribedMask& prescribed,
                      Modes modes) {
  Closure closure(scaled.equations().kinematics(), prescribed);
  if (closure.n_rows() == 0) return true;
  const std::vector<int> columns = scaled.moving_columns(prescribed, modes);
  LoopRows loops(scaled, closure, columns);
  const double rate = scaled.size().rate_at(coordinates.u);
  double residual = 0.0;
  for (int iteration = 0; iteration < 4; ++iteration) {
    measure(scaled, coordinates, closure);
    residual = largest_entry(closure.velocity_residual().cwiseQuotient(closure.row_units()));
    const VecX step = step_of_closing(loops, scaled, closure, columns, closure.velocity_residual(), 0.0).u;
    coordinates.u.head(step.size()) += step.cwiseProduct(scaled.size().speeds().head(step.size()));
  }
  measure(scaled, coordinates, closure);
  residual = std::min(residual, largest_entry(closure.velocity_residual().cwiseQuotient(closure.row_units())));
  return residual <= kClosedPart * std::max(rate, scaled.size().rate_at(coordinates.u));
}

}  // namespace concord::relative
