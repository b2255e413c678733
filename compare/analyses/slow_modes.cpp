#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include "common/decompositions.h"
#include "compare/analyses/eigenmodes.h"

namespace concord::compare::analyses {

namespace {

using Complex = std::complex<double>;

/// (lambda^2 - A - lambda B) x for a unit x: what is open of it, how large its terms are, and what they are made of.
struct Residual {
  Eigen::VectorXcd open;
  double terms = 0.0;
  double sizes = 0.0;

  Residual(const MotionMatrices& matrices, Complex value, const Eigen::VectorXcd& x) {
    const Eigen::VectorXcd pull = matrices.A * x;
    const Eigen::VectorXcd drag = value * (matrices.B * x);
    open = value * value * x - pull - drag;
    terms = std::norm(value) + pull.norm() + drag.norm();
    sizes = std::norm(value) + matrices.A.norm() + std::abs(value) * matrices.B.norm();
  }
  /// As a part of the terms, or of what round-off leaves of them.
  [[nodiscard]] bool is_within(double part, double round_off) const {
    return open.norm() <= part * terms + round_off * sizes;
  }
};

constexpr double kSlow = 1e3;  // times what is resolved of a decay

/// The search takes free rates whose decay is not resolved for steady ones. Modes that are not much faster than such a
/// decay feel it: inverse iteration on all of the equations, at first about the eigenvalue found and then with a Newton
/// step for it, brings such a mode to where it solves them. False where it solves them nowhere nearby, and is left as
/// it was.
bool refine_slow_mode(const MotionMatrices& matrices, Complex& eigenvalue, Eigen::VectorXcd& coordinates) {
  constexpr double kSolved = 1e-9;
  constexpr double kRoundOff = 1e-13;
  constexpr double kNearby = 0.5;
  constexpr double kReal = 1e-6;
  constexpr int kStepsAboutIt = 4;
  constexpr int kSteps = 12;
  Complex value = eigenvalue;
  Eigen::VectorXcd x = coordinates.normalized();
  bool is_solved = Residual(matrices, value, x).is_within(kSolved, kRoundOff);
  if (is_solved) return true;
  for (int step = 0; step < kSteps && !is_solved; ++step) {
    Eigen::MatrixXcd equations = -matrices.A - value * matrices.B;
    equations.diagonal().array() += value * value;
    const Eigen::VectorXcd next = inverse_of(equations) * (2.0 * value * x - matrices.B * x);
    if (!next.allFinite()) return false;
    if (step >= kStepsAboutIt) value -= 1.0 / x.dot(next);
    if (eigenvalue.imag() == 0.0) value.imag(0.0);
    x = next.normalized();
    is_solved = Residual(matrices, value, x).is_within(kSolved, kRoundOff);
  }
  const bool stays_a_pair = eigenvalue.imag() == 0.0 || std::abs(value.imag()) > kReal * std::abs(value);
  if (!is_solved || !stays_a_pair || std::abs(value - eigenvalue) > kNearby * std::abs(eigenvalue)) return false;
  if (value.imag() < 0.0) {  // the other one of its pair
    value = std::conj(value);
    x = x.conjugate().eval();
  }
  eigenvalue = value;
  coordinates = x;
  return true;
}

}  // namespace

void refine_slow_modes(const Chart& chart, const MotionMatrices& matrices, FoundModes& found) {
  constexpr double kOpen = 1e-4;
  constexpr double kRoundOff = 1e-11;
  constexpr double kSame = 1e-6;
  for (Mode& mode : found.moving) {
    if (mode.is_free || std::abs(mode.eigenvalue) >= kSlow * found.resolution) continue;
    Mode refined = mode;
    Eigen::VectorXcd coordinates = mode.coordinates;
    bool is_refined = refine_slow_mode(matrices, refined.eigenvalue, coordinates);
    if (is_refined) set_shape(chart, coordinates, refined);
    is_refined = is_refined && std::ranges::none_of(found.moving, [&](const Mode& other) {
                   const double apart = std::abs(other.eigenvalue - refined.eigenvalue);
                   return &other != &mode && apart <= kSame * std::abs(refined.eigenvalue) &&
                          shape_difference(other, refined) <= kSame;
                 });
    if (is_refined) {
      mode = std::move(refined);
    } else if (!Residual(matrices, mode.eigenvalue, mode.coordinates).is_within(kOpen, kRoundOff)) {
      mode.eigenvalue_resolution = std::abs(mode.eigenvalue);
      mode.shape_resolution = 1.0;
    }
  }
}

}  // namespace concord::compare::analyses
