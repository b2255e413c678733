#include "compare/analyses/linearize.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/decompositions.h"
#include "common/error.h"
#include "compare/analyses/deviations.h"
#include "compare/analyses/kinematics.h"
#include "compare/analyses/statics.h"
#include "compare/analyses/stiffness.h"
#include "compare/verdict/chart.h"
#include "compare/verdict/motion_names.h"

namespace concord::compare::analyses {

namespace {

using Complex = std::complex<double>;

constexpr double kRateStep = 0.02;  // of the machine's largest rate
constexpr double kLeastRateStep = 1e-7;
constexpr double kStray = 1e-6;
constexpr double kNoDamping = 1e-11;  // of the largest frequency

/// Derivatives of the accelerations of deviations with respect to their rates.
MatX damping_matrix(Deviations& deviations, const Solver& solver, double rate) {
  const Chart& chart = deviations.chart();
  const VecX none = VecX::Zero(chart.n());
  MatX B(chart.n(), chart.n());
  for (int k = 0; k < chart.n(); ++k) {
    const auto along = [&](double step) { return deviations.accelerations_at(none, step * VecX::Unit(chart.n(), k)); };
    const auto column = derivative_at_zero(along, kRateStep * rate, kLeastRateStep * rate, rate);
    if (!column) {
      throw SingularPose(fmt::format(
          "{}: at t = {:.6g} s no closed states with another speed along {} are found: is the pose singular?",
          solver.name(), chart.origin().t, chart.describe(VecX::Unit(chart.n(), k))));
    }
    B.col(k) = column->value;
  }
  return B;
}

struct Eigenpairs {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors;  // of the coordinates
  VecX condition;
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

/// |x| |y| / |y^H x| with the left eigenvectors y, the rows of the inverse; where eigenvectors coincide, what is left
/// of round-off bounds it.
VecX conditions_of(const Eigen::MatrixXcd& vectors) {
  constexpr double kMost = 1e8;
  const Eigen::MatrixXcd inverse = inverse_of(vectors);
  VecX conditions(vectors.cols());
  for (Eigen::Index k = 0; k < vectors.cols(); ++k) {
    const double condition = vectors.col(k).norm() * inverse.row(k).norm();
    conditions(k) = condition <= kMost ? std::max(condition, 1.0) : kMost;
  }
  return conditions;
}

/// Round-off of the fastest square (1e-15 of it) reaches the root of a far smaller one, divided by twice that root: the
/// slowest, which only this resolves, move by so much more.
double condition_of_root(double root, double fastest) {
  constexpr double kFarSlower = 3e-5;
  constexpr double kRoundOff = 1e-3;  // of what derivatives are good to
  if (root == 0.0 || root >= kFarSlower * fastest) return 1.0;
  return kRoundOff * fastest / (2.0 * root);
}

/// lambda^2 = an eigenvalue of A: exact pairs where nothing is damped. Free motions are taken out of the problem: their
/// eigenvalues are zero, and of what round-off left in their place nothing reaches the others.
Eigenpairs undamped_pairs(const MatX& A, const Motions& motions) {
  const Eigen::Index n = motions.held.cols();
  if (n == 0) return {};
  const MatX pull = A * motions.held;
  const GeneralEigenpairs solution = eigenpairs(motions.held.transpose() * pull);
  const Eigen::MatrixXcd& vectors = solution.vectors;
  const VecX conditions = conditions_of(vectors);
  const double fastest = std::sqrt(solution.values.cwiseAbs().maxCoeff());
  Eigenpairs pairs{Eigen::VectorXcd(2 * n), Eigen::MatrixXcd(A.rows(), 2 * n), VecX(2 * n)};
  for (Eigen::Index k = 0; k < n; ++k) {
    const Complex square = solution.values(k);
    const Complex root = std::sqrt(square);
    pairs.values(2 * k) = root;
    pairs.values(2 * k + 1) = -root;
    pairs.condition(2 * k) = pairs.condition(2 * k + 1) = conditions(k) * condition_of_root(std::abs(root), fastest);
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
      : motions_(motions), frequency_(frequency), all_(A.rows(), A.rows()), pull_(A * motions.held), B_(B) {
    const Eigen::Index n = A.rows();
    const Eigen::Index held = motions.held.cols();
    all_ << motions.free, motions.held;
    matrix_ = MatX::Zero(held + n, held + n);
    matrix_.topRightCorner(held, held).diagonal().setConstant(frequency);
    matrix_.bottomLeftCorner(n, held) = all_.transpose() * pull_ / frequency;
    matrix_.bottomRightCorner(n, n) = all_.transpose() * B * all_;
  }

  /// Orthonormal rates of free motions that no damping holds either: they move on for ever, while the held ones stand
  /// where the damping of the free ones pushes them. `resolution` [1/s]: of a decay.
  [[nodiscard]] MatX undamped_free(double resolution) const {
    const Eigen::Index n = B_.rows();
    const Eigen::Index free = motions_.free.cols();
    if (free == 0) return {n, 0};
    MatX unreached = MatX::Identity(n, n);  // by the held ones
    if (pull_.cols() > 0) unreached = orthogonal_completion(pull_);
    const Eigen::JacobiSVD<MatX> decay(MatX(unreached.rightCols(free).transpose() * B_ * motions_.free),
                                       Eigen::ComputeFullV);
    const Eigen::Index kept = (decay.singularValues().array() > resolution).count();
    return motions_.free * decay.matrixV().rightCols(free - kept);
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
    const MatX flow = matrix_ * others;
    const GeneralEigenpairs solution = eigenpairs(others.transpose() * flow);
    const Eigen::MatrixXcd& vectors = solution.vectors;
    Eigenpairs pairs{solution.values, Eigen::MatrixXcd(B_.rows(), left), conditions_of(vectors)};
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
    if (held > 0) states.topRows(held) = -frequency_ * least_squares(pull_, B_ * steady);
    states.middleRows(held, motions_.free.cols()) = motions_.free.transpose() * steady;
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

/// The velocities of a mode, in SI units and in those of the machine.
void set_shape(const Chart& chart, const Eigen::VectorXcd& coordinates, Mode& mode) {
  Eigen::VectorXcd velocities(chart.basis().rows());
  velocities.real() = chart.velocities(coordinates.real());
  velocities.imag() = chart.velocities(coordinates.imag());
  mode.shape = normalized_shape(velocities);
  mode.scaled_shape = normalized_shape(chart.basis() * coordinates);
}

bool comes_first(const Mode& a, const Mode& b) {
  const double sizes[] = {std::abs(a.eigenvalue), std::abs(b.eigenvalue)};
  if (std::abs(sizes[0] - sizes[1]) > 1e-9 * std::max(sizes[0], sizes[1])) return sizes[0] < sizes[1];
  return a.eigenvalue.real() < b.eigenvalue.real();
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

ModePairs pair_modes(const Linearization& one, const Linearization& other) {
  struct Candidate {
    double distance;
    std::size_t k;
    std::size_t partner;
  };
  const double resolution = std::max(one.resolution, other.resolution);
  std::vector<Candidate> candidates;
  for (std::size_t k = 0; k < one.modes.size(); ++k) {
    for (std::size_t partner = 0; partner < other.modes.size(); ++partner) {
      candidates.push_back({distance_between(one.modes[k], other.modes[partner], resolution), k, partner});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
  std::array<std::vector<bool>, 2> taken{std::vector<bool>(one.modes.size()), std::vector<bool>(other.modes.size())};
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

double Mode::frequency() const { return std::abs(eigenvalue) / (2.0 * std::numbers::pi); }

double Mode::damping_ratio() const { return is_free ? 0.0 : 0.0 - eigenvalue.real() / std::abs(eigenvalue); }

namespace {

/// Accelerations that velocities and forces cause [1/s2].
double size_of_accelerations(const Model& model, Solver& solver, const State& state, double speed) {
  return std::max(reference_acceleration(model, solver.evaluate(state)), speed * speed);
}

/// The rate at which derivatives with respect to rates are taken: the machine's largest, else that of its motions in
/// which modes follow statically, else that of its modes. If it has none, no force depends on a time of its own, and
/// any will do.
double typical_rate(double reference, const StiffnessSplit& split, const MatX& A) {
  for (const double square : {std::max(reference, split.largest()), A.norm()}) {
    if (square > 0.0) return std::sqrt(square);
  }
  return 1.0;
}

void add_free_modes(const Model& model, const Chart& chart, const MatX& directions, std::vector<Mode>& modes) {
  if (directions.cols() == 0) return;
  MatX motions(chart.basis().rows(), directions.cols());
  for (Eigen::Index k = 0; k < directions.cols(); ++k) motions.col(k) = chart.velocities(directions.col(k));
  motions = separate_motions(model, chart.origin(), std::move(motions));
  for (const auto& motion : motions.colwise()) {
    Mode mode;
    mode.is_free = true;
    set_shape(chart, (chart.coordinates_of(motion)).cast<Complex>(), mode);
    mode.motion = describe_motion(model, chart.origin(), motion);
    modes.push_back(std::move(mode));
  }
}

void add_modes(const Model& model, const Chart& chart, const Eigenpairs& pairs, bool is_undamped,
               Linearization& result) {
  for (Eigen::Index k = 0; k < pairs.values.size(); ++k) {
    Mode mode;
    mode.eigenvalue = pairs.values(k);
    mode.condition = pairs.condition(k);
    mode.is_free = std::abs(mode.eigenvalue) <= result.resolution;
    if (mode.is_free) mode.eigenvalue = 0.0;
    if (is_undamped) settle_on_an_axis(mode.eigenvalue);
    if (mode.eigenvalue.imag() < 0.0) continue;  // the other one of its pair is there
    set_shape(chart, pairs.vectors.col(k), mode);
    mode.motion = describe_motion(model, chart.origin(), mode.shape.real());
    result.modes.push_back(std::move(mode));
  }
}

}  // namespace

Linearization linearize(const Model& model, Solver& solver, const State& state) {
  Linearization result;
  result.state = state;
  Deviations deviations(model, solver, state);
  const Chart& chart = deviations.chart();
  if (chart.n() == 0) return result;
  const VecX none = VecX::Zero(chart.n());
  const double reference = size_of_accelerations(model, solver, state, deviations.speed());
  result.directions = deviations.directions();
  result.rate = deviations.speed();
  if (reference > 0.0) result.unsteadiness = deviations.accelerations().norm() / reference;
  const auto held = [&](const VecX& delta) { return deviations.accelerations_at(delta, none); };
  const Stiffness stiffness = stiffness_matrix(chart, solver, held, reference);
  result.A = stiffness.J;
  const StiffnessSplit split(chart, stiffness, reference, none);
  result.resolution = std::sqrt(split.least());
  const double rate = typical_rate(reference, split, result.A);
  const double frequency = std::max(std::sqrt(result.A.norm()), rate);
  result.B = damping_matrix(deviations, solver, rate);
  const Motions motions(split);
  const bool is_undamped = result.B.norm() <= kNoDamping * frequency;
  add_free_modes(model, chart, motions.free, result.modes);
  if (is_undamped) {
    add_free_modes(model, chart, motions.free, result.modes);  // its rates
    add_modes(model, chart, undamped_pairs(result.A, motions), true, result);
  } else {
    const FirstOrder first_order(result.A, result.B, frequency, motions);
    const MatX steady = first_order.undamped_free(result.resolution);
    add_free_modes(model, chart, steady, result.modes);
    add_modes(model, chart, first_order.pairs_without(steady), false, result);
  }
  std::stable_sort(result.modes.begin(), result.modes.end(), comes_first);
  return result;
}

Steadiness steadiness_of(const Model& model, Solver& solver, const Linearization& found) {
  constexpr double kAccelerates = 1e-8;
  constexpr double kMovesBy = 1e-4;  // rad, or of the length: the prediction errs by its square
  Steadiness steadiness;
  steadiness.accelerates = found.unsteadiness > kAccelerates;
  if (steadiness.accelerates || found.rate <= found.resolution) return steadiness;
  const Sample now{found.state, solver.evaluate(found.state), 0.0};
  const auto later = solver.close(predict(model, now, kMovesBy / found.rate));
  if (!later) return steadiness;
  const Linearization there = linearize(model, solver, *later);
  if (there.directions.cols() != found.directions.cols()) return steadiness;
  const MatX to_here = least_squares(found.directions, there.directions);
  const MatX from_here = least_squares(there.directions, found.directions);
  double fastest = found.rate;
  for (const Mode& mode : found.modes) fastest = std::max(fastest, std::abs(mode.eigenvalue));
  steadiness.change = std::max((to_here * there.A * from_here - found.A).norm() / (fastest * fastest),
                               (to_here * there.B * from_here - found.B).norm() / fastest) /
                      kMovesBy;
  return steadiness;
}

}  // namespace concord::compare::analyses
