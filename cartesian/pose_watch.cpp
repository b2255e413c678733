#include "cartesian/pose_watch.h"

#include <amd.h>
#include <fmt/format.h>
#include <klu.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "cartesian/row_choice.h"
#include "common/error.h"

namespace concord::cartesian {

namespace {

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

/// Pivots of J_b M_b^-1 J_a^T by eliminating, in a fixed order without exchanges, first the inertias and then the rows
/// of [M_b J_a^T; J_b 0]; memory is laid out once. The inertias only weigh directions, so that a small part of the
/// machine's largest is added to each: a thin rod has none about its axis.
class PoseWatch::Overlap {
 public:
  /// `matrix`: that of the equations with its numbers, from which the largest inertia is taken.
  Overlap(const Equations& equations, const SparseLu& matrix)
      : matrix_(matrix), first_row_(equations.layout().n_Y()), values_(matrix_.row_indices().size(), 0.0) {
    klu_defaults(&common_);
    common_.btf = 0;
    common_.scale = 0;
    common_.tol = 0.0;  // always the diagonal
    const std::vector<int> rows = order_rows(equations);
    order_.resize(matrix_.size());
    std::iota(order_.begin(), order_.end(), 0);
    for (std::size_t k = 0; k < rows.size(); ++k) order_[first_row_ + k] = first_row_ + rows[k];
    symbolic_ = klu_analyze_given(matrix_.size(), starts(), indices(), order_.data(), order_.data(), &common_);
    if (symbolic_ == nullptr) throw SolverError("cartesian: klu_analyze_given failed");
    take_share_of_inertia(equations.units());
  }
  ~Overlap() {
    if (numeric_ != nullptr) klu_free_numeric(&numeric_, &common_);
    klu_free_symbolic(&symbolic_, &common_);
  }
  Overlap(const Overlap&) = delete;
  Overlap& operator=(const Overlap&) = delete;

  /// By constraint row: the pivots, negative where the overlap is lost; zero for rows that take no part, and all zero
  /// where a pivot vanishes.
  VecX pivots(const std::vector<double>& a, const std::vector<double>& b, const std::vector<bool>& rows) {
    fill(a, b, rows);
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

  void take_share_of_inertia(const VecX& units) {
    constexpr double kShare = 1e-6;
    double largest = 0.0;
    for_each_inertia(
        [&](int place, int k) { largest = std::max(largest, matrix_.values()[k] * units(place) * units(place)); });
    added_ = kShare * largest * units.array().square().inverse();
  }

  /// Calls visit(place, k) for the diagonal entries of M and their places among the values.
  template <class Visit>
  void for_each_inertia(const Visit& visit) const {
    for (int column = 0; column < first_row_; ++column) {
      for (int k = matrix_.column_starts()[column]; k < matrix_.column_starts()[column + 1]; ++k) {
        if (matrix_.row_indices()[k] == column) visit(column, k);
      }
    }
  }

  int* starts() { return const_cast<int*>(matrix_.column_starts().data()); }  // KLU reads them only
  int* indices() { return const_cast<int*>(matrix_.row_indices().data()); }

  void fill(const std::vector<double>& a, const std::vector<double>& b, const std::vector<bool>& rows) {
    const auto takes_part = [&](int place) { return place < first_row_ || rows[place - first_row_]; };
    for (int column = 0; column < matrix_.size(); ++column) {
      for (int k = matrix_.column_starts()[column]; k < matrix_.column_starts()[column + 1]; ++k) {
        const int row = matrix_.row_indices()[k];
        if (takes_part(row) && takes_part(column)) {
          values_[k] = column >= first_row_ ? a[k] : b[k];
        } else {
          values_[k] = row == column ? -1.0 : 0.0;
        }
      }
    }
    for_each_inertia([this](int place, int k) { values_[k] += added_(place); });
  }

  const SparseLu& matrix_;
  int first_row_;
  std::vector<int> order_;
  std::vector<double> values_;
  VecX added_;  // to the inertias
  klu_common common_{};
  klu_symbolic* symbolic_ = nullptr;
  klu_numeric* numeric_ = nullptr;
};

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

PoseWatch::PoseWatch(Dynamics& dynamics, int generic_rank, double t, const MotionState& start)
    : dynamics_(dynamics),
      equations_(dynamics.equations()),
      generic_rank_(generic_rank),
      may_lose_rank_(may_lose_rank(equations_.model())) {
  if (!may_lose_rank_) return;
  equations_.update(t, start.q, start.Y);
  overlap_ = std::make_unique<Overlap>(equations_, dynamics_.fill_matrix());
  last_ = sample_pose(t, start);
  chosen_pivots_ = largest_pivots_ = last_.pivots;
}

PoseWatch::~PoseWatch() = default;

/// At the last update of the equations, with the rows in use.
PoseWatch::PoseSample PoseWatch::sample_pose(double t, const MotionState& motion) {
  const SparseLu& matrix = dynamics_.fill_matrix();
  PoseSample at{t, motion.q, motion.Y, {matrix.values(), matrix.values() + matrix.row_indices().size()}, {}, {}};
  at.rows = dynamics_.active_rows();
  at.pivots = overlap_->pivots(at.values, at.values, at.rows);
  return at;
}

/// Rows chosen anew at a pose, which are in use from then on.
void PoseWatch::choose(PoseSample& at) {
  const RowChoice choice = choose_rows(equations_, generic_rank_);
  if (choice.rank < generic_rank_) refuse(at.t, weakest_row_);
  dynamics_.use_rows(choice.independent);
  at.rows = choice.independent;
  at.pivots = overlap_->pivots(at.values, at.values, at.rows);
}

bool PoseWatch::follow(double t, const MotionState& motion) {
  constexpr int kDepth = 16;
  constexpr double kLittle = 0.1;  // pivots that change so little from step to step cannot vanish in between
  if (!may_lose_rank_ || t <= last_.t) return false;
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
  bisect(last_, now, changes_little, kDepth);
  rate_ = rate;
  dynamics_.use_rows(now.rows);
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

/// Closed poses this near to a singular one are known to the root of round-off only: on which side they stand is open.
void PoseWatch::refuse_vanished(const PoseSample& now) {
  constexpr double kVanished = 1e-13;  // of the largest that a pivot has been; the root of that is the distance
  largest_pivots_ = largest_pivots_.cwiseMax(now.pivots);
  for (Eigen::Index row = 0; row < now.pivots.size(); ++row) {
    if (now.rows[row] && !(now.pivots(row) > kVanished * largest_pivots_(row)))
      refuse(now.t, RowIndex(static_cast<int>(row)));
  }
}

VecX PoseWatch::own_pivots(const PoseSample& at, const std::vector<bool>& rows) {
  return at.rows == rows ? at.pivots : overlap_->pivots(at.values, at.values, rows);
}

/// Whether the rows at one pose certainly change into those at the other without losing rank in between (C53).
bool PoseWatch::is_continuous(const PoseSample& before, const PoseSample& after, const std::vector<bool>& rows) {
  // What the rows permit turns by less than about 25 degrees; where a motion changes to another branch it turns at
  // once, however near the poses are.
  constexpr double kOverlap = 0.9;
  const VecX between = overlap_->pivots(before.values, after.values, rows);
  const VecX at_before = own_pivots(before, rows);
  const VecX at_after = own_pivots(after, rows);
  for (Eigen::Index row = 0; row < between.size(); ++row) {
    if (!rows[row]) continue;
    const double geometric_mean = std::sqrt(at_before(row)) * std::sqrt(at_after(row));
    if (at_before(row) > 0.0 && at_after(row) > 0.0 && between(row) >= kOverlap * geometric_mean) continue;
    weakest_row_ = RowIndex(static_cast<int>(row));
    return false;
  }
  return true;
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

/// Whether no pivot falls to zero and rises again between the samples. Its root is straight over a short time: from the
/// middle and either end the other end is predicted, with the other sign where the root has passed zero.
bool PoseWatch::stays_independent(const PoseSample& before, const PoseSample& middle, const PoseSample& after,
                                  const std::vector<bool>& rows) {
  constexpr double kPredicted = 0.5;  // of the root at an end
  const VecX between = own_pivots(middle, rows).cwiseMax(0.0).cwiseSqrt();
  const VecX at_before = own_pivots(before, rows).cwiseMax(0.0).cwiseSqrt();
  const VecX at_after = own_pivots(after, rows).cwiseMax(0.0).cwiseSqrt();
  for (Eigen::Index row = 0; row < between.size(); ++row) {
    if (!rows[row]) continue;
    const double from_before = 2.0 * between(row) - at_before(row);
    const double from_after = 2.0 * between(row) - at_after(row);
    if (from_before > kPredicted * at_after(row) && from_after > kPredicted * at_before(row)) continue;
    weakest_row_ = RowIndex(static_cast<int>(row));
    return false;
  }
  return true;
}

/// Looks closer and closer where a singular pose may be, by the rows of either sample.
void PoseWatch::bisect(const PoseSample& before, const PoseSample& after, bool changes_little, int depth) {
  std::optional<PoseSample> middle;
  for (const PoseSample* own : {&before, &after}) {
    if (own == &after && after.rows == before.rows) break;
    if (!is_continuous(before, after, own->rows)) continue;
    if (changes_little) return;
    if (!middle) middle = sample_between(before, after);
    if (stays_independent(before, *middle, after, own->rows)) return;
  }
  if (depth == 0) refuse(after.t, weakest_row_);
  if (!middle) middle = sample_between(before, after);
  bisect(before, *middle, false, depth - 1);
  bisect(*middle, after, false, depth - 1);
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
    const RowChoice choice = choose_rows_beside(equations_, generic_rank_);
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
