#include "relative/start/start_advice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/error.h"
#include "relative/rank/closing.h"
#include "relative/rank/row_rank.h"

namespace concord::relative {

void come_nearest(const ScaledClosure& scaled, Coordinates& coordinates, Closure& closure,
                  const std::vector<int>& columns) {
  constexpr int kMostTries = 400;
  constexpr double kFarthest = 0.5;  // rad, or of the length
  constexpr double kLeastDamping = 1e-3;
  constexpr double kMostDamping = 1e6;
  constexpr double kStands = 1e-12;
  const auto sum_at = [&](Coordinates& at) {
    if (try_to_measure(scaled, at, closure) == HUGE_VAL) return HUGE_VAL;
    return closure.position_residual().cwiseQuotient(closure.row_units().head(closure.n_position_rows())).squaredNorm();
  };
  double sum = sum_at(coordinates);
  double damping = kLeastDamping;
  for (int iteration = 0; iteration < kMostTries && sum < HUGE_VAL && damping < kMostDamping; ++iteration) {
    VecX step = smallest_step(scaled, closure, columns, closure.position_residual(), damping);
    const double farthest = largest_entry(step);
    if (farthest < kStands) break;
    step = step.cwiseProduct(scaled.size().speeds().head(step.size())) * std::min(1.0, kFarthest / farthest);
    Coordinates reached = coordinates;
    scaled.advance(reached.q, step);
    const double sum_reached = sum_at(reached);
    if (sum_reached < sum) {
      sum = sum_reached;
      coordinates = std::move(reached);
      damping = std::max(0.25 * damping, kLeastDamping);
    } else {
      damping *= 4.0;
      sum_at(coordinates);
    }
  }
  sum_at(coordinates);
}

namespace {

JointGap gap_of(const Kinematics& kinematics, const CutJoint& cut) {
  const Vec6& error = cut.measure.position_residual();
  return {error.head<3>(), error.tail<3>(), kinematics.point(cut.joint, Side::parent).A};
}

double size_of(const JointGap& gap, double length) {
  return std::max(gap.apart_C.norm() / length, gap.turned_C.norm());
}

/// Columns of a word in the masks that no driver prescribes.
std::vector<int> free_columns_of(const ScaledClosure& scaled, const StartWord& word) {
  const Equations& equations = scaled.equations();
  const joints::JointType& type = *equations.model().joints[word.joint].type;
  const int first = equations.topology().joints[JointIndex(word.joint)].first_u + first_u(type, word.word);
  std::vector<int> columns;
  for (int c = first; c < first + n_u(type.permits[word.word]); ++c) {
    if (equations.driven()[c] == 0) columns.push_back(c);
  }
  return columns;
}

/// Directions that stay free where these are prescribed, modes not counted.
int freedom_with(const ScaledClosure& scaled, const Coordinates& closed, const PrescribedMask& prescribed,
                 ClosureRows rows) {
  Closure closure(scaled.equations().kinematics(), prescribed);
  Coordinates copy = closed;
  measure(scaled, copy, closure);
  const std::vector<int> columns = scaled.moving_columns(prescribed, Modes::kept);
  const int n_rows = rows == ClosureRows::of_positions ? closure.n_position_rows() : closure.n_rows();
  return static_cast<int>(columns.size()) - RowRank(scaled.rows(closure, columns).topRows(n_rows)).rank();
}

}  // namespace

std::string words_of_open_loop(const ScaledClosure& scaled, const Coordinates& guess,
                               const PrescribedMask& prescribed) {
  constexpr double kClosedBeside = 1e-6;
  constexpr double kRoundOff = 1e-12;  // rad, or of the length: this search closes the loops
  const Equations& equations = scaled.equations();
  Closure closure(equations.kinematics(), prescribed);
  const std::vector<int> columns = scaled.moving_columns(prescribed, Modes::kept);
  Coordinates nearest = guess;
  come_nearest(scaled, nearest, closure, columns);
  const double length = scaled.size().length();
  const CutJoint* worst = nullptr;
  std::vector<double> sizes;
  for (const CutJoint& cut : closure.cuts()) {
    sizes.push_back(size_of(gap_of(equations.kinematics(), cut), length));
    if (sizes.back() >= *std::max_element(sizes.begin(), sizes.end())) worst = &cut;
  }
  if (worst == nullptr) return "";
  const double largest = *std::max_element(sizes.begin(), sizes.end());
  if (largest <= kRoundOff) return "";
  for (const SpeedConstraint& constraint : closure.speed_constraints()) {
    if (!constraint.is_coupling()) continue;
    if (largest_entry(closure.position_residual().segment(constraint.first_row, constraint.n_rows)) > largest)
      return "";
  }
  const bool others_close =
      std::count_if(sizes.begin(), sizes.end(), [&](double size) { return size > kClosedBeside * largest; }) == 1;
  return fmt::format("{} joint '{}', at which the loop is cut, is left open {}by {}",
                     others_close ? "where the other joints are closed," : "of the loops,",
                     equations.model().joints[worst->joint].name, others_close ? "" : "most, ",
                     words_of(gap_of(equations.kinematics(), *worst), length));
}

std::vector<StartWord> words_to_keep(const ScaledClosure& scaled, const Coordinates& closed, ClosureRows rows,
                                     StartRole WordStart::*role) {
  constexpr int kMostNamed = 12;  // longer lists are not read
  constexpr int kMostTried = 200;
  const Model& model = scaled.equations().model();
  std::vector<StartWord> candidates = start_words(model);
  std::stable_partition(candidates.begin(), candidates.end(), [&](const StartWord& word) {
    return model.joints[word.joint].start[word.word].*role == StartRole::keep;
  });
  PrescribedMask prescribed = scaled.equations().driven();
  int freedom = freedom_with(scaled, closed, prescribed, rows);
  if (freedom > kMostNamed) return {};
  std::vector<StartWord> chosen;
  int tried = 0;
  for (const StartWord& word : candidates) {
    if (freedom == 0 || ++tried > kMostTried) break;
    const std::vector<int> columns = free_columns_of(scaled, word);
    if (columns.empty() || std::ssize(columns) > freedom) continue;
    PrescribedMask with = prescribed;
    for (const int c : columns) with[c] = 1;
    const int left = freedom_with(scaled, closed, with, rows);
    if (freedom - left < std::ssize(columns)) continue;
    prescribed = std::move(with);
    freedom = left;
    chosen.push_back(word);
  }
  if (freedom > 0) chosen.clear();
  return chosen;
}

}  // namespace concord::relative
