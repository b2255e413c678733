#include "cartesian/run/pose_watch.h"

#include <amd.h>
#include <fmt/format.h>
#include <klu.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "cartesian/rank/constraint_rank.h"
#include "common/error.h"

namespace concord::cartesian {

namespace {

/// Of the largest that a pivot has been; the root of that is the distance. Closed poses this near to a singular one are
/// known to the root of round-off only: on which side they stand is open.
constexpr double kVanished = 1e-13;

/// Constraint rows in an order of little fill for J M^-1 J^T: rows on one body are neighbours.
std::vector<int> order_rows(const Equations& equations) {
  const Constraints& constraints = equations.constraints();
  ByBody<std::vector<int>> of_body(equations.layout().n_bodies());
  for (const RowBlock& block : constraints.blocks()) {
    for (int row = 0; row < block.n_rows; ++row) of_body[block.body].push_back(block.row(row).value);
  }
  std::vector<std::vector<int>> columns(constraints.n_rows());
  for (const auto& rows : of_body) {
    for (const int row : rows) columns[row].insert(columns[row].end(), rows.begin(), rows.end());
  }
  std::vector<int> starts{0};
  std::vector<int> indices;
  for (auto& column : columns) {
    std::sort(column.begin(), column.end());
    column.erase(std::unique(column.begin(), column.end()), column.end());
    indices.insert(indices.end(), column.begin(), column.end());
    starts.push_back(static_cast<int>(indices.size()));
  }
  std::vector<int> order(constraints.n_rows());
  std::iota(order.begin(), order.end(), 0);
  if (!order.empty())
    (void)amd_order(constraints.n_rows(), starts.data(), indices.data(), order.data(), nullptr, nullptr);
  return order;
}

}  // namespace

/// Pivots of J M^-1 J^T by eliminating, in a fixed order without exchanges, first the inertias and then the rows of
/// [M J^T; J 0]; memory is laid out once. The inertias only weigh directions, so that a small part of the machine's
/// largest is added to each: a thin rod has none about its axis.
class PoseWatch::RowPivots {
 public:
  /// `matrix`: that of the equations, with what their inertias count as at least.
  RowPivots(const Equations& equations, const SparseLu& matrix)
      : matrix_(matrix), first_row_(equations.layout().n_Y()), values_(matrix_.row_indices().size(), 0.0) {
    klu_defaults(&common_);
    common_.btf = 0;
    common_.scale = 0;
    common_.tol = 0.0;  // always the diagonal
    const std::vector<int> rows = order_rows(equations);
    order_.resize(matrix_.size());
    std::iota(order_.begin(), order_.end(), 0);
    for (std::size_t k = 0; k < rows.size(); ++k) order_[first_row_ + k] = first_row_ + rows[k];
    for (int place = 0; place < first_row_; ++place) diagonal_.push_back(matrix_.find(place, place));
    symbolic_ = klu_analyze_given(matrix_.size(), starts(), indices(), order_.data(), order_.data(), &common_);
    if (symbolic_ == nullptr) throw SolverError("cartesian: klu_analyze_given failed");
  }
  ~RowPivots() {
    if (numeric_ != nullptr) klu_free_numeric(&numeric_, &common_);
    klu_free_symbolic(&symbolic_, &common_);
  }
  RowPivots(const RowPivots&) = delete;
  RowPivots& operator=(const RowPivots&) = delete;

  /// By constraint row: the pivots, zero for rows that take no part, and all zero where a pivot vanishes.
  VecX of(const std::vector<double>& values, const std::vector<bool>& rows) {
    fill(values, rows);
    VecX found = VecX::Zero(matrix_.size() - first_row_);
    if (!factor()) return found;
    const auto* diagonal = static_cast<const double*>(numeric_->Udiag);
    for (int k = first_row_; k < matrix_.size(); ++k) {
      const int row = order_[k] - first_row_;
      if (rows[row]) found(row) = -diagonal[k];
    }
    return found;
  }

 private:
  /// The order of pivots is the same every time; a refactorization that fails leaves factors that cannot be used again.
  bool factor() {
    if (numeric_ == nullptr) {
      numeric_ = klu_factor(starts(), indices(), values_.data(), symbolic_, &common_);
      return numeric_ != nullptr && common_.status == KLU_OK;
    }
    const int done = klu_refactor(starts(), indices(), values_.data(), symbolic_, numeric_, &common_);
    if (done != 0 && common_.status == KLU_OK) return true;
    klu_free_numeric(&numeric_, &common_);
    return false;
  }

  int* starts() { return const_cast<int*>(matrix_.column_starts().data()); }  // KLU reads them only
  int* indices() { return const_cast<int*>(matrix_.row_indices().data()); }

  void fill(const std::vector<double>& values, const std::vector<bool>& rows) {
    const auto takes_part = [&](int place) { return place < first_row_ || rows[place - first_row_]; };
    for (int column = 0; column < matrix_.size(); ++column) {
      for (int k = matrix_.column_starts()[column]; k < matrix_.column_starts()[column + 1]; ++k) {
        const int row = matrix_.row_indices()[k];
        if (takes_part(row) && takes_part(column)) {
          values_[k] = values[k];
        } else {
          values_[k] = row == column ? -1.0 : 0.0;
        }
      }
    }
    const VecX& least = matrix_.least_diagonal();
    for (int place = 0; place < first_row_; ++place) values_[diagonal_[place]] += least(place);
  }

  const SparseLu& matrix_;
  int first_row_;
  std::vector<int> order_;
  std::vector<double> values_;
  std::vector<int> diagonal_;  // places of the inertias' own entries
  klu_common common_{};
  klu_symbolic* symbolic_ = nullptr;
  klu_numeric* numeric_ = nullptr;
};

PoseWatch::PoseWatch(Dynamics& dynamics, int generic_rank, double t, const MotionState& start)
    : dynamics_(dynamics),
      equations_(dynamics.equations()),
      generic_rank_(generic_rank),
      may_lose_rank_(may_lose_rank(equations_.model())) {
  if (!may_lose_rank_) return;
  equations_.update(t, start.q, start.Y);
  pivots_ = std::make_unique<RowPivots>(equations_, dynamics_.fill_matrix());
  last_ = sample_pose(t, start);
  chosen_pivots_ = largest_pivots_ = last_.pivots;
}

PoseWatch::~PoseWatch() = default;

/// At the last update of the equations, with the rows in use.
PoseWatch::PoseSample PoseWatch::sample_pose(double t, const MotionState& motion) {
  const SparseLu& matrix = dynamics_.fill_matrix();
  PoseSample at{t, motion.q, motion.Y, {matrix.values(), matrix.values() + matrix.row_indices().size()}, {}, {}};
  at.rows = dynamics_.active_rows();
  at.pivots = pivots_->of(at.values, at.rows);
  return at;
}

/// Rows chosen anew at a pose, which are in use from then on.
void PoseWatch::choose(PoseSample& at) {
  const RowChoice choice = choose_rows(equations_);
  if (choice.rank < generic_rank_) refuse(at.t, weakest_row_);
  dynamics_.use_rows(choice.independent);
  at.rows = choice.independent;
  at.pivots = pivots_->of(at.values, at.rows);
}

bool PoseWatch::follow(double t, const MotionState& motion, bool ends_step) {
  constexpr int kDepth = 16;
  constexpr double kLittle = 0.1;       // pivots that change so little from look to look cannot vanish in between
  constexpr double kVeryLittle = 0.02;  // within a step they need not even be looked at
  if (!may_lose_rank_ || t <= last_.t) return false;
  if (!ends_step && rate_ * (t - last_.t) < kVeryLittle) return false;
  const std::vector<bool> rows = dynamics_.active_rows();
  equations_.update(t, motion.q, motion.Y);
  PoseSample now = sample_pose(t, motion);
  if (has_weakened(now)) {
    choose(now);
    chosen_pivots_ = now.pivots;
  }
  refuse_vanished(now);
  const double rate = rate_of_change(last_, now);
  const bool changes_little = std::max(rate_, rate) * (now.t - last_.t) < kLittle;
  if (!changes_little && !is_straight_so_far(now)) bisect(last_, now, kDepth);
  rate_ = rate;
  dynamics_.use_rows(now.rows);
  before_last_ = std::move(last_);
  last_ = std::move(now);
  return last_.rows != rows;
}

/// Whether other rows might be better than those in use: a row has lost much of its pivot, or the rows together have
/// come to be nearly dependent, which no pivot need show: what round-off leaves of the dependent rows grows with it.
bool PoseWatch::has_weakened(const PoseSample& now) {
  constexpr double kWeakened = 1e-2;   // a row's pivot of that where the rows were chosen
  constexpr double kRoundOff = 1e-14;  // of the largest speed
  constexpr double kMuchWorse = 30.0;
  if (generic_rank_ == equations_.constraints().n_rows()) return false;
  const double left = dynamics_.velocity_residual_left();
  const bool closes_worse = left > kMuchWorse * std::max(least_left_, kRoundOff);
  if (closes_worse) least_left_ = left;  // unless it gets much worse still, it is not the choice of rows
  return closes_worse || !(now.pivots.array() >= kWeakened * chosen_pivots_.array()).all();
}

void PoseWatch::refuse_vanished(const PoseSample& now) {
  largest_pivots_ = largest_pivots_.cwiseMax(now.pivots);
  for (Eigen::Index row = 0; row < now.pivots.size(); ++row) {
    if (now.rows[row] && !(now.pivots(row) > kVanished * largest_pivots_(row)))
      refuse(now.t, RowIndex(static_cast<int>(row)));
  }
}

VecX PoseWatch::own_pivots(const PoseSample& at, const std::vector<bool>& rows) {
  return at.rows == rows ? at.pivots : pivots_->of(at.values, rows);
}

/// The largest relative rate of the roots of pivots between two samples [1/s].
double PoseWatch::rate_of_change(const PoseSample& before, const PoseSample& after) {
  if (before.rows != after.rows) return HUGE_VAL;
  double largest = 0.0;
  for (Eigen::Index row = 0; row < before.pivots.size(); ++row) {
    if (!before.rows[row]) continue;
    const double ratio = after.pivots(row) / before.pivots(row);
    if (!(ratio > 0.0)) return HUGE_VAL;
    largest = std::max(largest, 0.5 * std::abs(std::log(ratio)));
  }
  return largest / (after.t - before.t);
}

/// Whether no pivot falls to zero and rises again between the samples. Its root is straight over a short time: the
/// middle is what the ends say of its time, unless the root has passed zero, or the middle has been brought onto
/// another branch (C53).
bool PoseWatch::stays_independent(const PoseSample& before, const PoseSample& middle, const PoseSample& after,
                                  const std::vector<bool>& rows) {
  constexpr double kStraight = 0.5;  // of the smaller root
  const VecX between = own_pivots(middle, rows).cwiseMax(0.0).cwiseSqrt();
  const VecX at_before = own_pivots(before, rows).cwiseMax(0.0).cwiseSqrt();
  const VecX at_after = own_pivots(after, rows).cwiseMax(0.0).cwiseSqrt();
  const double w = (middle.t - before.t) / (after.t - before.t);
  for (Eigen::Index row = 0; row < between.size(); ++row) {
    if (!rows[row]) continue;
    const double bend = 2.0 * std::abs((1.0 - w) * at_before(row) + w * at_after(row) - between(row));
    const double least = std::min(at_before(row), at_after(row));
    const double vanished = std::sqrt(kVanished * largest_pivots_(row));
    if (bend < kStraight * least && std::min(between(row), least) > vanished) continue;
    weakest_row_ = RowIndex(static_cast<int>(row));
    return false;
  }
  return true;
}

/// Whether the last three samples tell by themselves that no singular pose lies between the last two, as long as
/// the middle one is about halfway.
bool PoseWatch::is_straight_so_far(const PoseSample& now) {
  constexpr double kHalfway = 0.25;
  if (!(before_last_.t < last_.t)) return false;
  const double w = (last_.t - before_last_.t) / (now.t - before_last_.t);
  return std::abs(w - 0.5) <= kHalfway && stays_independent(before_last_, last_, now, now.rows);
}

/// Looks closer and closer where a singular pose may be, by the rows of either sample.
void PoseWatch::bisect(const PoseSample& before, const PoseSample& after, int depth) {
  const PoseSample middle = sample_between(before, after);
  if (stays_independent(before, middle, after, before.rows)) return;
  if (after.rows != before.rows && stays_independent(before, middle, after, after.rows)) return;
  if (depth == 0) refuse(after.t, weakest_row_);
  bisect(before, middle, depth - 1);
  bisect(middle, after, depth - 1);
}

/// Halfway in time: the cubic through both, brought onto the constraints (C54).
PoseWatch::PoseSample PoseWatch::sample_between(const PoseSample& before, const PoseSample& after) {
  const Layout& layout = equations_.layout();
  const double h = after.t - before.t;
  const double t = before.t + 0.5 * h;
  VecX rate_before(layout.n_q());
  VecX rate_after(layout.n_q());
  layout.write_qdot(before.q, before.Y, rate_before);
  layout.write_qdot(after.q, after.Y, rate_after);
  MotionState middle;
  middle.q = 0.5 * (before.q + after.q) + h / 8.0 * (rate_before - rate_after);
  middle.Y = 0.5 * (before.Y + after.Y);
  layout.normalize(middle.q);
  try {
    equations_.update(t, middle.q, middle.Y);
    const RowChoice choice = choose_rows(equations_, generic_rank_);
    if (choice.rank < generic_rank_) refuse(t, weakest_row_);
    dynamics_.use_rows(choice.independent);
    dynamics_.project(dynamics_.solve(Pivots::fresh), t, middle.q, middle.Y);
    equations_.update(t, middle.q, middle.Y);
  } catch (const SingularPose&) {
    throw;
  } catch (const SolverError&) {
    refuse(t, weakest_row_);
  }
  return sample_pose(t, middle);
}

void PoseWatch::explain_stop(const std::string& reason) const {
  constexpr double kNear = 1e-3;  // of the largest that a pivot has been
  if (!may_lose_rank_) return;
  for (Eigen::Index row = 0; row < last_.pivots.size(); ++row) {
    if (!last_.rows[row] || last_.pivots(row) > kNear * largest_pivots_(row)) continue;
    throw SingularPose(fmt::format(
        "cartesian: after t = {:.6g} s the motion comes to a singular pose, where constraints lose rank at {}, and the "
        "integrator does not reach it: {}",
        last_.t, equations_.constraints().name_of(RowIndex(static_cast<int>(row))), reason));
  }
}

void PoseWatch::refuse(double t, RowIndex row) const {
  throw SingularPose(
      fmt::format("cartesian: at t = {:.6g} s the motion passes a singular pose: constraints lose rank at {}; the "
                  "motion may branch "
                  "there, and reactions may be unbounded",
                  t, equations_.constraints().name_of(row)));
}

}  // namespace concord::cartesian
