#include "compare/resolution/jumps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/error.h"
#include "compare/states/states.h"

namespace concord::compare {

namespace {

/// Chance puts no more samples on a jump.
constexpr std::size_t kMostSamples = 20;

/// What is known of the quantities that differ in one sample.
struct Difference {
  std::size_t sample;
  std::vector<Eigen::Index> rows;
  std::array<VecX, 2> values;  // of all rows
};

/// Looks for jumps about samples. `enough`: what would not matter in each row.
class JumpSearch {
 public:
  JumpSearch(const QuantityLayout& layout, const std::array<Solver*, 2>& solvers, VecX enough)
      : layout_(layout), solvers_(solvers), enough_(std::move(enough)) {}

  [[nodiscard]] bool is_at_jump(const Sample& sample, const Difference& difference) const {
    const double length = layout_.model().length_scale();
    double speed = 0.0;
    for (const BodyState& body : sample.state.bodies) {
      speed = std::max({speed, body.v.norm(), length * body.omega.norm()});
    }
    if (!(speed > 0.0)) return false;
    for (const double part : {1e-13, 1e-12, 1e-11, 1e-10, 1e-9}) {
      const double h = part * length / speed;
      const auto before = agreed_at(sample, -h, difference.rows);
      const auto after = agreed_at(sample, h, difference.rows);
      if (!before || !after) continue;
      const auto is_of_a_side = [&](const VecX& values) {
        return is_same(values, *before, difference.rows) || is_same(values, *after, difference.rows);
      };
      if (!is_of_a_side(difference.values[0]) || !is_of_a_side(difference.values[1])) continue;
      if (is_same(*before, *after, difference.rows)) continue;
      if (stays(sample, -kFarther * h, *before, difference.rows) &&
          stays(sample, kFarther * h, *after, difference.rows))
        return true;
    }
    return false;
  }

 private:
  static constexpr double kFarther = 3.0;

  /// A side of a jump is the same a little farther away; round-off of places in a stiff machine is another one each
  /// time.
  [[nodiscard]] bool stays(const Sample& sample, double h, const VecX& side,
                           const std::vector<Eigen::Index>& rows) const {
    const auto farther = agreed_at(sample, h, rows);
    return farther && is_same(*farther, side, rows);
  }

  /// What both solvers give h seconds on; nothing where they do not agree, or the machine does not close.
  [[nodiscard]] std::optional<VecX> agreed_at(const Sample& sample, double h,
                                              const std::vector<Eigen::Index>& rows) const {
    const auto state = solvers_[0]->close(predict(layout_.model(), sample, h));
    if (!state) return std::nullopt;
    VecX one = layout_.observe(*state, solvers_[0]->evaluate(*state));
    const VecX other = layout_.observe(*state, solvers_[1]->evaluate(*state));
    return is_same(one, other, rows) ? std::optional(std::move(one)) : std::nullopt;
  }

  [[nodiscard]] bool is_same(const VecX& one, const VecX& other, const std::vector<Eigen::Index>& rows) const {
    return std::all_of(rows.begin(), rows.end(),
                       [&](Eigen::Index row) { return std::abs(one(row) - other(row)) <= enough_(row); });
  }

  const QuantityLayout& layout_;
  const std::array<Solver*, 2>& solvers_;
  VecX enough_;
};

/// The samples in which quantities differ by more than `enough` and than is resolved; none if they are too many.
std::vector<Difference> find_candidates(const Series& series, const VecX& enough, const MatX& resolution) {
  std::vector<Difference> found;
  for (Eigen::Index k = 0; k < series.values[0].cols(); ++k) {
    Difference one{static_cast<std::size_t>(k), {}, {series.values[0].col(k), series.values[1].col(k)}};
    for (Eigen::Index row = 0; row < enough.size(); ++row) {
      const double difference = std::abs(one.values[0](row) - one.values[1](row));
      const bool is_explained = difference <= kWithinResolution * resolution(row, k);
      if (enough(row) > 0.0 && difference > enough(row) && !is_explained) one.rows.push_back(row);
    }
    if (!one.rows.empty()) found.push_back(std::move(one));
    if (found.size() > kMostSamples) return {};
  }
  return found;
}

}  // namespace

std::vector<double> widen_at_jumps(const QuantityLayout& layout, const std::array<Solver*, 2>& solvers,
                                   const Series& series, const std::vector<Measured>& measured,
                                   const std::function<Sample(std::size_t)>& sample_of, double need, MatX& resolution) {
  VecX enough(series.values[0].rows());
  for (Eigen::Index row = 0; row < enough.size(); ++row) {
    enough(row) = std::pow(10.0, -need) * measured[static_cast<std::size_t>(row)].scale;
  }
  const JumpSearch search(layout, solvers, enough);
  std::vector<double> times;
  for (const Difference& one : find_candidates(series, enough, resolution)) {
    try {
      if (!search.is_at_jump(sample_of(one.sample), one)) continue;
    } catch (const SolverError&) {
      continue;  // a state that one of the solvers does not accept
    }
    const auto k = static_cast<Eigen::Index>(one.sample);
    for (const Eigen::Index row : one.rows) resolution(row, k) = std::abs(one.values[0](row) - one.values[1](row));
    times.push_back(series.times[one.sample]);
  }
  return times;
}

std::string note_on_jumps(const std::vector<double>& times, Check check) {
  return fmt::format(
      "{}: a force jumps at t = {:.6g} s, where a sample is, and each solver stands on a side of its own: what jumps "
      "is "
      "not judged there",
      name_of(check), fmt::join(times, ", "));
}

}  // namespace concord::compare
