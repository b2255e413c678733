#include "compare/analyses/eigenmodes.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/decompositions.h"
#include "common/products.h"
#include "compare/quantities/agreement.h"
#include "compare/states/draws.h"

namespace concord::compare::analyses {

namespace {

using Complex = std::complex<double>;

constexpr double kStray = 1e-6;

struct Eigenpairs {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors;  // of the coordinates
};

/// Orthonormal coordinates of the motions that meet no stiffness, and of all others.
struct Motions {
  MatX free;
  MatX held;

  explicit Motions(const StiffnessSplit& split) {
    const MatX& directions = split.free_directions();
    const Eigen::Index n = directions.rows();
    MatX all = MatX::Identity(n, n);
    if (directions.cols() > 0) all = orthogonal_completion(directions);
    free = all.leftCols(directions.cols());
    held = all.rightCols(n - directions.cols());
  }
};

/// lambda^2 = an eigenvalue of A: exact pairs where nothing is damped. Free motions are taken out of the problem: their
/// eigenvalues are zero, and of what round-off left in their place nothing reaches the others.
Eigenpairs undamped_pairs(const MatX& A, const Motions& motions) {
  const Eigen::Index n = motions.held.cols();
  if (n == 0) return {};
  const MatX pull = product(A, motions.held);
  const GeneralEigenpairs solution = eigenpairs(transposed_product(motions.held, pull));
  const Eigen::MatrixXcd& vectors = solution.vectors;
  Eigenpairs pairs{Eigen::VectorXcd(2 * n), Eigen::MatrixXcd(A.rows(), 2 * n)};
  for (Eigen::Index k = 0; k < n; ++k) {
    const Complex square = solution.values(k);
    const Complex root = std::sqrt(square);
    pairs.values(2 * k) = root;
    pairs.values(2 * k + 1) = -root;
    Eigen::VectorXcd shape = motions.held * vectors.col(k);
    if (square != 0.0) shape += motions.free * (motions.free.transpose() * (pull * vectors.col(k))) / square;
    pairs.vectors.col(2 * k) = pairs.vectors.col(2 * k + 1) = shape;
  }
  return pairs;
}

/// The first-order form of a damped machine without the places along free motions, on which nothing depends: rows are
/// coordinates of held motions in a unit of time in which its parts have one size, then rates of free and held ones.
class FirstOrder {
 public:
  FirstOrder(const MatX& A, const MatX& B, double frequency, const Motions& motions)
      : motions_(motions), frequency_(frequency), all_(A.rows(), A.rows()), pull_(product(A, motions.held)), B_(B) {
    const Eigen::Index n = A.rows();
    const Eigen::Index held = motions.held.cols();
    all_ << motions.free, motions.held;
    matrix_ = MatX::Zero(held + n, held + n);
    matrix_.topRightCorner(held, held).diagonal().setConstant(frequency);
    matrix_.bottomLeftCorner(n, held) = transposed_product(all_, pull_) / frequency;
    matrix_.bottomRightCorner(n, n) = congruence(all_, B);
  }

  /// Orthonormal rates of free motions that no damping holds either: they move on for ever, while the held ones stand
  /// where the damping of the free ones pushes them. `resolution` [1/s]: of a decay.
  [[nodiscard]] MatX undamped_free(double resolution) const {
    const Eigen::Index n = B_.rows();
    const Eigen::Index free = motions_.free.cols();
    if (free == 0) return {n, 0};
    MatX unreached = MatX::Identity(n, n);  // by the held ones
    if (pull_.cols() > 0) unreached = orthogonal_completion(pull_);
    const Eigen::JacobiSVD<MatX> decay(transposed_product(unreached.rightCols(free), product(B_, motions_.free)),
                                       Eigen::ComputeFullV);
    const Eigen::Index kept = (decay.singularValues().array() > resolution).count();
    return product(motions_.free, decay.matrixV().rightCols(free - kept));
  }

  /// All eigenpairs but those of `steady`, what undamped_free() found.
  [[nodiscard]] Eigenpairs pairs_without(const MatX& steady) const {
    const Eigen::Index size = matrix_.rows();
    const Eigen::Index left = size - steady.cols();
    if (left == 0) return {};
    MatX split = MatX::Identity(size, size);
    if (steady.cols() > 0) split = orthogonal_completion(states_of(steady));
    const MatX zeros = split.leftCols(steady.cols());
    const MatX others = split.rightCols(left);
    const MatX flow = product(matrix_, others);
    const GeneralEigenpairs solution = eigenpairs(transposed_product(others, flow));
    const Eigen::MatrixXcd& vectors = solution.vectors;
    Eigenpairs pairs{solution.values, Eigen::MatrixXcd(B_.rows(), left)};
    for (Eigen::Index k = 0; k < left; ++k) {
      const Complex value = pairs.values(k);
      Eigen::VectorXcd vector = others * vectors.col(k);
      if (value != 0.0) vector += zeros * (zeros.transpose() * (flow * vectors.col(k))) / value;
      pairs.vectors.col(k) = shape_of_state(vector, value);
    }
    return pairs;
  }

 private:
  /// The first-order states in which free motions go on at the rates `steady`.
  [[nodiscard]] MatX states_of(const MatX& steady) const {
    const Eigen::Index held = motions_.held.cols();
    MatX states = MatX::Zero(matrix_.rows(), steady.cols());
    if (held > 0) states.topRows(held) = -frequency_ * least_squares(pull_, product(B_, steady));
    states.middleRows(held, motions_.free.cols()) = transposed_product(motions_.free, steady);
    return states;
  }

  /// Coordinates, or rates where those are larger.
  [[nodiscard]] Eigen::VectorXcd shape_of_state(const Eigen::VectorXcd& state, const Complex& value) const {
    const Eigen::Index held = motions_.held.cols();
    Eigen::VectorXcd rates = all_ * state.tail(B_.rows());
    if (value == 0.0) return rates;
    const Eigen::VectorXcd coordinates =
        motions_.held * state.head(held) +
        motions_.free * state.segment(held, motions_.free.cols()) * (frequency_ / value);
    return coordinates.norm() > rates.norm() ? coordinates : rates;
  }

  const Motions& motions_;
  double frequency_;
  MatX all_;
  MatX pull_;
  const MatX& B_;
  MatX matrix_;
};

/// Without damping an eigenvalue is real or imaginary; equal ones stray by the root of the round-off.
void settle_on_an_axis(Complex& eigenvalue) {
  const double negligible = kStray * std::abs(eigenvalue);
  if (std::abs(eigenvalue.real()) <= negligible) eigenvalue.real(0.0);
  if (std::abs(eigenvalue.imag()) <= negligible) eigenvalue.imag(0.0);
}

/// Turned so that the largest velocity is real, of unit norm.
Eigen::VectorXcd normalized_shape(const Eigen::VectorXcd& velocities) {
  Eigen::Index largest = 0;
  velocities.cwiseAbs().maxCoeff(&largest);
  return velocities * (std::conj(velocities(largest)) / std::abs(velocities(largest)) / velocities.norm());
}

/// How far two modes are from being one: 0 to about 1 by their eigenvalues, relative to the larger one or what is
/// resolved, and a tenth as much by their shapes, 1 - MAC.
double distance_between(const Mode& one, const Mode& other, double resolution) {
  constexpr double kShape = 0.1;
  const double size = std::max({std::abs(one.eigenvalue), std::abs(other.eigenvalue), resolution});
  const double by_value = size > 0.0 ? std::abs(one.eigenvalue - other.eigenvalue) / size : 0.0;
  return by_value + kShape * (1.0 - std::norm(other.scaled_shape.dot(one.scaled_shape)));
}

}  // namespace

void set_shape(const Chart& chart, const Eigen::VectorXcd& coordinates, Mode& mode) {
  Eigen::VectorXcd velocities(chart.basis().rows());
  velocities.real() = chart.velocities(coordinates.real());
  velocities.imag() = chart.velocities(coordinates.imag());
  mode.shape = normalized_shape(velocities);
  mode.scaled_shape = normalized_shape(chart.basis() * coordinates);
  mode.coordinates = coordinates.normalized();
}

ModePairs pair_modes(const std::vector<Mode>& one, const std::vector<Mode>& other, double resolution) {
  struct Candidate {
    double distance;
    std::size_t k;
    std::size_t partner;
  };
  std::vector<Candidate> candidates;
  for (std::size_t k = 0; k < one.size(); ++k) {
    for (std::size_t partner = 0; partner < other.size(); ++partner) {
      candidates.push_back({distance_between(one[k], other[partner], resolution), k, partner});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
  std::array<std::vector<bool>, 2> taken{std::vector<bool>(one.size()), std::vector<bool>(other.size())};
  ModePairs pairs;
  for (const Candidate& candidate : candidates) {
    if (taken[0][candidate.k] || taken[1][candidate.partner]) continue;
    taken[0][candidate.k] = taken[1][candidate.partner] = true;
    pairs.both.emplace_back(candidate.k, candidate.partner);
  }
  std::sort(pairs.both.begin(), pairs.both.end());
  for (std::size_t who = 0; who < 2; ++who) {
    for (std::size_t k = 0; k < taken[who].size(); ++k) {
      if (!taken[who][k]) pairs.alone[who].push_back(k);
    }
  }
  return pairs;
}

double shape_difference(const Mode& one, const Mode& other) {
  const Complex along = other.scaled_shape.dot(one.scaled_shape);
  return (one.scaled_shape - along * other.scaled_shape).norm();
}

int FoundModes::count_free() const {
  const auto moving_free = std::count_if(moving.begin(), moving.end(), [](const Mode& mode) { return mode.is_free; });
  return static_cast<int>(moving_free + free_places.cols() + free_rates.cols());
}

FoundModes find_modes(const ModeSearch& search, const MotionMatrices& matrices, const MotionMatrices& errors) {
  const StiffnessSplit split(search.chart, {matrices.A, errors.A}, search.scale, VecX::Zero(search.chart.n()),
                             search.strictness);
  const Motions motions(split);
  FoundModes found;
  found.resolution = std::sqrt(split.least());
  found.free_places = found.free_rates = motions.free;
  found.slowest = found.resolution;
  Eigenpairs pairs;
  if (search.is_undamped) {
    pairs = undamped_pairs(matrices.A, motions);
  } else {
    const FirstOrder first_order(matrices.A, matrices.B, search.frequency, motions);
    found.free_rates = first_order.undamped_free(found.resolution);
    pairs = first_order.pairs_without(found.free_rates);
    // Fast rotors and strong dampers follow a stiffness slowly, at the rate stiffness / B.
    found.slowest = split.least() / std::max(found.resolution, matrices.B.norm());
  }
  for (Eigen::Index k = 0; k < pairs.values.size(); ++k) {
    Mode mode;
    mode.eigenvalue = pairs.values(k);
    mode.is_free = std::abs(mode.eigenvalue) <= found.slowest;
    if (mode.is_free) mode.eigenvalue = 0.0;
    if (search.is_undamped) settle_on_an_axis(mode.eigenvalue);
    if (mode.eigenvalue.imag() < 0.0) continue;  // the other one of its pair is there
    set_shape(search.chart, pairs.vectors.col(k), mode);
    found.moving.push_back(std::move(mode));
  }
  if (found.free_rates.cols() > 0 && !search.is_undamped) refine_slow_modes(search.chart, matrices, found);
  return found;
}

namespace {

/// Entries that happen to be right by luck may be as wrong as their row and their column say: what an acceleration
/// misses, times what a difference step makes of it.
MatX without_luck(const MatX& error, const MatX& values) {
  constexpr double kRoundOff = 4.0 * std::numeric_limits<double>::epsilon();
  const MatX sizes = error.cwiseAbs();
  const double mean = sizes.size() > 0 ? sizes.mean() : 0.0;
  MatX likely = sizes;
  if (mean > 0.0) likely = likely.cwiseMax(sizes.rowwise().mean() * (sizes.colwise().mean() / mean));
  return likely + kRoundOff * values.cwiseAbs();
}

/// How far modes are from those found otherwise is what is open of them; one that has no partner there is not resolved.
void take_as_resolution(const FoundModes& other, std::vector<Mode>& modes) {
  const ModePairs pairs = pair_modes(modes, other.moving, other.slowest);
  for (const auto& [k, partner] : pairs.both) {
    Mode& mode = modes[k];
    const Mode& moved = other.moving[partner];
    mode.eigenvalue_resolution = std::max(mode.eigenvalue_resolution, std::abs(mode.eigenvalue - moved.eigenvalue));
    mode.shape_resolution = std::max(mode.shape_resolution, shape_difference(mode, moved));
  }
  for (const std::size_t k : pairs.alone[0]) {
    modes[k].eigenvalue_resolution = std::abs(modes[k].eigenvalue);
    modes[k].shape_resolution = 1.0;
  }
}

MatX drawn_from(const MatX& values, const MatX& error, Draws& draws) {
  MatX drawn = values;
  for (Eigen::Index column = 0; column < values.cols(); ++column) {
    for (Eigen::Index row = 0; row < values.rows(); ++row) drawn(row, column) += error(row, column) * draws.next();
  }
  return drawn;
}

}  // namespace

void measure_mode_resolution(const ModeSearch& search, const MotionMatrices& matrices, const MotionMatrices& errors,
                             std::vector<Mode>& modes) {
  constexpr int kModeDraws = 16;
  constexpr std::uint64_t kModeSeed = 19970704;
  const MatX of_A = without_luck(errors.A, matrices.A);
  const MatX of_B = without_luck(errors.B, matrices.B);
  Draws draws(kModeSeed);
  for (int draw = 0; draw < kModeDraws; ++draw) {
    MotionMatrices drawn{drawn_from(matrices.A, of_A, draws), matrices.B};
    if (!search.is_undamped) drawn.B = drawn_from(matrices.B, of_B, draws);
    take_as_resolution(find_modes(search, drawn, errors), modes);
  }
}

std::array<int, 2> weigh_decisions_on_free(ModeSearch search, const MotionMatrices& matrices,
                                           const MotionMatrices& errors, FoundModes& found) {
  const int decided = found.count_free();
  std::array<int, 2> range{decided, decided};
  for (const double strictness : {1.0 / 30.0, 30.0}) {
    search.strictness = strictness;
    const FoundModes other = find_modes(search, matrices, errors);
    const int count = other.count_free();
    if (count == decided) continue;
    range = {std::min(range[0], count), std::max(range[1], count)};
    take_as_resolution(other, found.moving);
  }
  return range;
}

void split_unresolved_pairs(std::vector<Mode>& modes) {
  const std::size_t n_found = modes.size();
  for (std::size_t k = 0; k < n_found; ++k) {
    const double imaginary = modes[k].eigenvalue.imag();
    const bool is_resolved = imaginary > kWithinResolution * modes[k].eigenvalue_resolution;
    const bool is_known = modes[k].eigenvalue_resolution < std::abs(modes[k].eigenvalue);
    if (!modes[k].oscillates() || is_resolved || !is_known) continue;
    if (imaginary >= std::abs(modes[k].eigenvalue.real())) continue;
    modes[k].eigenvalue.imag(0.0);
    modes[k].is_half_of_unresolved_pair = true;
    modes.push_back(modes[k]);
  }
}

}  // namespace concord::compare::analyses
