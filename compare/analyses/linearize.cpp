#include "compare/analyses/linearize.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "compare/analyses/chart.h"
#include "compare/analyses/statics.h"

namespace concord::compare::analyses {

namespace {

using Complex = std::complex<double>;

constexpr double kRateStep = 0.02;  // of the machine's largest rate
constexpr double kLeastRateStep = 1e-7;
constexpr double kNegligible = 1e-9;  // of the largest; eigenvalues go with its root
constexpr double kStray = 1e-6;
constexpr double kNoDamping = 1e-11;  // of the largest frequency

/// Derivatives of the chart's accelerations with respect to its rates.
MatX damping_matrix(Chart& chart, Solver& solver, double rate) {
  MatX B(chart.n(), chart.n());
  const VecX now = chart.rates_at_origin();
  for (int k = 0; k < chart.n(); ++k) {
    const auto along = [&](double step) -> std::optional<VecX> {
      const auto state = chart.at(VecX::Zero(chart.n()), now + step * VecX::Unit(chart.n(), k));
      if (!state) return std::nullopt;
      return chart.accelerations(*state, solver.evaluate(*state));
    };
    const auto column = derivative_at_zero(along, kRateStep * rate, kLeastRateStep * rate, rate);
    if (!column) {
      throw SolverError(
          fmt::format("{}: no closed states with other speeds at t = {:.6g} s", solver.name(), chart.origin().t));
    }
    B.col(k) = *column;
  }
  return B;
}

struct Eigenpairs {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors;  // of the coordinates
  VecX condition;
};

/// |x| |y| / |y^H x| with the left eigenvectors y, the rows of the inverse; where eigenvectors coincide, what is left
/// of round-off bounds it.
VecX conditions_of(const Eigen::MatrixXcd& vectors) {
  constexpr double kMost = 1e8;
  const Eigen::MatrixXcd inverse = vectors.partialPivLu().inverse();
  VecX conditions(vectors.cols());
  for (Eigen::Index k = 0; k < vectors.cols(); ++k) {
    const double condition = vectors.col(k).norm() * inverse.row(k).norm();
    conditions(k) = condition <= kMost ? std::max(condition, 1.0) : kMost;
  }
  return conditions;
}

/// lambda^2 = an eigenvalue of A: exact pairs where nothing is damped.
Eigenpairs undamped_pairs(const MatX& A) {
  const Eigen::EigenSolver<MatX> solution(A);
  const Eigen::MatrixXcd vectors = solution.eigenvectors();
  const Eigen::Index n = A.rows();
  const VecX conditions = conditions_of(vectors);
  Eigenpairs pairs{Eigen::VectorXcd(2 * n), Eigen::MatrixXcd(n, 2 * n), VecX(2 * n)};
  for (Eigen::Index k = 0; k < n; ++k) {
    const Complex root = std::sqrt(solution.eigenvalues()(k));
    pairs.values(2 * k) = root;
    pairs.values(2 * k + 1) = -root;
    pairs.condition(2 * k) = pairs.condition(2 * k + 1) = conditions(k);
    pairs.vectors.col(2 * k) = pairs.vectors.col(2 * k + 1) = vectors.col(k);
  }
  return pairs;
}

/// Of the first-order form, in the unit of time in which its two parts have one size.
Eigenpairs damped_pairs(const MatX& A, const MatX& B, double frequency) {
  const Eigen::Index n = A.rows();
  MatX first_order = MatX::Zero(2 * n, 2 * n);
  first_order.topRightCorner(n, n).diagonal().setConstant(frequency);
  first_order.bottomLeftCorner(n, n) = A / frequency;
  first_order.bottomRightCorner(n, n) = B;
  const Eigen::EigenSolver<MatX> solution(first_order);
  const Eigen::MatrixXcd vectors = solution.eigenvectors();
  Eigenpairs pairs{solution.eigenvalues(), Eigen::MatrixXcd(n, 2 * n), conditions_of(vectors)};
  for (Eigen::Index k = 0; k < 2 * n; ++k) {
    const auto coordinates = vectors.col(k).head(n);
    const auto rates = vectors.col(k).tail(n);
    pairs.vectors.col(k) = coordinates.norm() > rates.norm() ? coordinates : rates;
  }
  return pairs;
}

/// Without damping an eigenvalue is real or imaginary; equal ones stray by the root of the round-off.
void settle_on_an_axis(Complex& eigenvalue) {
  const double negligible = kStray * std::abs(eigenvalue);
  if (std::abs(eigenvalue.real()) <= negligible) eigenvalue.real(0.0);
  if (std::abs(eigenvalue.imag()) <= negligible) eigenvalue.imag(0.0);
}

/// The velocities of a mode, of unit norm, turned so that the largest one is real.
Eigen::VectorXcd shape_of(const Chart& chart, const Eigen::VectorXcd& coordinates) {
  Eigen::VectorXcd shape(chart.basis().rows());
  shape.real() = chart.velocities(coordinates.real());
  shape.imag() = chart.velocities(coordinates.imag());
  Eigen::Index largest = 0;
  shape.cwiseAbs().maxCoeff(&largest);
  return shape * (std::conj(shape(largest)) / std::abs(shape(largest)) / shape.norm());
}

bool comes_first(const Mode& a, const Mode& b) {
  const double sizes[] = {std::abs(a.eigenvalue), std::abs(b.eigenvalue)};
  if (std::abs(sizes[0] - sizes[1]) > 1e-9 * std::max(sizes[0], sizes[1])) return sizes[0] < sizes[1];
  return a.eigenvalue.real() < b.eigenvalue.real();
}

}  // namespace

double Mode::frequency() const { return std::abs(eigenvalue) / (2.0 * std::numbers::pi); }

double Mode::damping_ratio() const { return is_free ? 0.0 : 0.0 - eigenvalue.real() / std::abs(eigenvalue); }

Linearization linearize(const Model& model, Solver& solver, const State& state) {
  Chart chart(model, solver, state);
  Linearization result;
  result.state = state;
  if (chart.n() == 0) return result;
  const VecX rates = chart.rates_at_origin();
  const double reference = reference_acceleration(model, solver.evaluate(state));
  result.A = stiffness_matrix(chart, solver, rates, reference);
  const StiffnessSplit split(chart, result.A, reference);
  result.resolution = std::sqrt(kNegligible * std::max(split.largest(), reference));
  const double frequency = std::max({std::sqrt(result.A.norm()), rates.norm(), result.resolution, 1e-300});
  result.B = damping_matrix(chart, solver, std::max({std::sqrt(reference), rates.norm(), result.resolution, 1e-3}));
  const bool is_undamped = result.B.norm() <= kNoDamping * frequency;
  const Eigenpairs pairs = is_undamped ? undamped_pairs(result.A) : damped_pairs(result.A, result.B, frequency);
  for (Eigen::Index k = 0; k < pairs.values.size(); ++k) {
    Mode mode;
    mode.eigenvalue = pairs.values(k);
    mode.condition = pairs.condition(k);
    mode.is_free = std::abs(mode.eigenvalue) <= result.resolution;
    if (mode.is_free) mode.eigenvalue = 0.0;
    if (is_undamped) settle_on_an_axis(mode.eigenvalue);
    if (mode.eigenvalue.imag() < 0.0) continue;  // the other one of its pair is there
    mode.shape = shape_of(chart, pairs.vectors.col(k));
    mode.motion = describe_motion(model, state, mode.shape.real());
    result.modes.push_back(std::move(mode));
  }
  std::stable_sort(result.modes.begin(), result.modes.end(), comes_first);
  return result;
}

}  // namespace concord::compare::analyses
