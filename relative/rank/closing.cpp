#include "relative/rank/closing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/decompositions.h"
#include "common/error.h"
#include "common/products.h"
#include "relative/rank/loop_rows.h"
#include "relative/rank/row_rank.h"

namespace concord::relative {

namespace {

constexpr int kMostIterations = 60;
constexpr int kFewRows = 16;
constexpr double kFarthestStep = 0.5;  // in machine units: half a radian, half the length, unless rows are straight
constexpr double kFarFromDependent = 1e-4;  // smallest singular value of rows that need no filter
constexpr double kRefinable = 1e-6;         // the same of many rows whose squares are refined
constexpr double kSameRows = 1e-9;          // a step that changes rows by no more than this part of themselves
constexpr double kSquaredDamping = 1e-4;    // damping whose square is far above round-off
constexpr double kBeyondDamping = 30.0;     // times the damping, which takes a thousandth of the step there

/// To the last digit of each, and fast for few rows.
Svd svd_by_rotations(const MatX& Phi) {
  const Eigen::JacobiSVD<MatX> svd(Phi, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return {svd.singularValues(), svd.matrixU(), svd.matrixV()};
}

/// A step of the tree's speeds, and whether it takes the whole misfit away to first order.
struct Step {
  VecX u;
  bool is_whole = false;
};

/// The rows of a closing in one pose, factorized once for the steps against any of their misfits (R65).
class RowsOfPose {
 public:
  /// The first `n_rows` of the closure where the machine stands, of which as many are used as `rank` says. `loops`:
  /// over the same columns, to serve where they can.
  RowsOfPose(LoopRows* loops, const ScaledClosure& scaled, const Closure& closure, const std::vector<int>& columns,
             Eigen::Index n_rows, double damping, std::optional<int> rank = {})
      : columns_(columns),
        n_tree_u_(scaled.equations().topology().n_tree_u),
        units_(closure.row_units().head(n_rows)),
        damping_(damping),
        rank_(rank.value_or(static_cast<int>(n_rows))) {
    if (loops != nullptr && n_rows == closure.n_rows() && rank_ >= n_rows) factor_by_loops(*loops);
    if (way_ == Way::nowhere) factor(scaled.rows(closure, columns).topRows(n_rows));
  }

  /// Whether steps are none but those that the rows themselves ask for.
  [[nodiscard]] bool are_undamped() const { return !is_damped_; }

  [[nodiscard]] Step step(const VecX& misfit) const {
    Step found{VecX::Zero(n_tree_u_), is_whole_};
    if (way_ != Way::nowhere) found.u(columns_) = solve(misfit.cwiseQuotient(units_));
    return found;
  }

 private:
  enum class Way { nowhere, loops, refined_loops, squares, independent, least_squares, singular_values };

  [[nodiscard]] bool are_many() const { return units_.size() > kFewRows; }
  /// Singular values above this are not filtered.
  [[nodiscard]] double least(double otherwise) const { return std::max(otherwise, kBeyondDamping * damping_); }

  void factor_by_loops(LoopRows& loops) {
    loops_ = &loops;
    bool keeps_digits = damping_ >= kSquaredDamping;
    if (loops.factor(VecX::Ones(static_cast<Eigen::Index>(columns_.size())))) {
      const double sigma = loops.singular_value();
      keeps_digits = keeps_digits || sigma > kRefinable;
      is_whole_ = sigma > least(are_many() ? kRefinable : kFarFromDependent);
      if (is_whole_) way_ = sigma > kFarFromDependent ? Way::loops : Way::refined_loops;
    }
    if (is_whole_ || !are_many() || !keeps_digits || !loops.factor_damped(damping_)) return;
    is_damped_ = true;
    way_ = Way::refined_loops;
  }

  void factor(MatX Phi) {
    if (Phi.size() == 0) return;
    Phi_ = std::move(Phi);
    if (are_many() && damping_ >= kSquaredDamping && rank_ >= Phi_.rows()) {
      way_ = Way::squares;
      is_damped_ = true;
      MatX squares = product(Phi_, Phi_.transpose());
      squares.diagonal().array() += damping_ * damping_;
      squares_.compute(squares);
      return;
    }
    factors_.compute(Phi_);
    const int found = factors_.rank();
    if (found > 0 && rank_ >= found && factors_.singular_value(found) > least(kFarFromDependent)) {
      is_whole_ = found == factors_.n_rows();
      way_ = is_whole_ ? Way::independent : Way::least_squares;
    } else {
      way_ = Way::singular_values;
      is_damped_ = true;
      svd_ = are_many() ? svd_of(Phi_) : svd_by_rotations(Phi_);
    }
  }

  /// Misfit in the units of the rows.
  [[nodiscard]] VecX solve(const VecX& misfit) const {
    switch (way_) {
      case Way::loops:
        return loops_->smallest_step(misfit);
      case Way::refined_loops:
        return loops_->refined_step(misfit);
      case Way::squares:
        return -(Phi_.transpose() * squares_.solve(misfit));
      case Way::independent:
        return factors_.smallest_step(misfit);
      case Way::least_squares:
        return -smallest_least_squares(Phi_, misfit, kDependentPart);
      default:
        return filtered_step(misfit);
    }
  }

  /// Directions in which the rows are dependent are left alone, those with singular values below the damping hardly
  /// used, and those beyond the rank not.
  [[nodiscard]] VecX filtered_step(const VecX& misfit) const {
    const VecX& sigma = svd_.sigma;
    VecX filter = VecX::Zero(sigma.size());
    const Eigen::Index used = std::min<Eigen::Index>(sigma.size(), rank_);
    for (Eigen::Index i = 0; i < used; ++i) {
      if (sigma(i) > kDependentPart * std::max(sigma(0), 1.0))
        filter(i) = sigma(i) / (sigma(i) * sigma(i) + damping_ * damping_);
    }
    const VecX along = svd_.U.leftCols(sigma.size()).transpose() * misfit;
    return -(svd_.V.leftCols(sigma.size()) * filter.cwiseProduct(along));
  }

  const std::vector<int>& columns_;
  int n_tree_u_;
  VecX units_;
  double damping_;
  int rank_;
  Way way_ = Way::nowhere;
  bool is_whole_ = false;
  bool is_damped_ = false;
  LoopRows* loops_ = nullptr;
  MatX Phi_;
  Eigen::LLT<MatX> squares_;
  RowRank factors_;
  Svd svd_;
};

}  // namespace

VecX smallest_step(const ScaledClosure& scaled, const Closure& closure, const std::vector<int>& columns,
                   const VecX& misfit, double damping, std::optional<int> rank) {
  return RowsOfPose(nullptr, scaled, closure, columns, misfit.size(), damping, rank).step(misfit).u;
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
  std::optional<RowsOfPose> rows;
  double moved = HUGE_VAL;  // since they were factorized, in machine units
  for (int iteration = 0; iteration < kMostIterations && residual > 0.0 && !pace.stalls(residual); ++iteration) {
    const VecX misfit = closure.position_residual();
    if (!(moved < kSameRows) || !rows->are_undamped()) {
      rows.emplace(&loops, scaled, closure, columns, misfit.size(), std::min(1e-3, residual), rank);
      moved = 0.0;
    }
    Step step = rows->step(misfit);
    moved += largest_entry(step.u);
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
  measure(scaled, coordinates, closure);
  const RowsOfPose rows(&loops, scaled, closure, columns, closure.n_rows(), 0.0);
  const auto size_of_residual = [&] {
    return largest_entry(closure.velocity_residual().cwiseQuotient(closure.row_units()));
  };
  double residual = 0.0;
  for (int iteration = 0; iteration < 4; ++iteration) {
    residual = size_of_residual();
    const VecX step = rows.step(closure.velocity_residual()).u;
    coordinates.u.head(step.size()) += step.cwiseProduct(scaled.size().speeds().head(step.size()));
    measure(scaled, coordinates, closure);
  }
  residual = std::min(residual, size_of_residual());
  return residual <= kClosedPart * std::max(rate, scaled.size().rate_at(coordinates.u));
}

}  // namespace concord::relative
