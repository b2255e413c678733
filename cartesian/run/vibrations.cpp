#include "cartesian/run/vibrations.h"

#include <algorithm>
#include <cmath>

#include "common/decompositions.h"
#include "common/products.h"

namespace concord::cartesian {

Vibrations::Vibrations(const Equations& equations) {
  const Layout& layout = equations.layout();
  for (const BodyIndex i : layout.moving_bodies()) {
    for (int k = 0; k < layout.n_modes(i); ++k) {
      in_q_.push_back(layout.first_q(i) + 7 + k);
      in_Y_.push_back(layout.first_Y(i) + 6 + k);
    }
  }
  const auto n = static_cast<Eigen::Index>(in_q_.size());
  stiffness_ = damping_ = compliance_ = MatX::Zero(n, n);
  E_ = inverse_E_ = MatX::Identity(n, n);
  lambda_ = twice_delta_ = unit_ = VecX::Zero(n);
  force_ = acceleration_ = VecX::Zero(layout.n_Y());
  Eigen::Index at = 0;
  for (const BodyIndex i : layout.moving_bodies()) {
    const int m = layout.n_modes(i);
    stiffness_.block(at, at, m, m) = equations.inertia(i).stiffness();
    damping_.block(at, at, m, m) = equations.inertia(i).damping();
    unit_.segment(at, m) = equations.inertia(i).modal_mass().diagonal().cwiseSqrt().cwiseInverse();
    at += m;
  }
}

void Vibrations::measure_compliance(Dynamics& dynamics) {
  for (Eigen::Index k = 0; k < size(); ++k) {
    force_.setZero();
    force_(in_Y_[k]) = 1.0;
    dynamics.accelerate(force_, acceleration_);
    compliance_.col(k) = acceleration_(in_Y_);
  }
  compliance_ = 0.5 * (compliance_ + compliance_.transpose()).eval();
}

/// With P = R R^T the vibrations are those of R^T K R, which is symmetric: E = R V (C56). Modes that joints lock have
/// no compliance; they are given next to none.
void Vibrations::renew(Dynamics& dynamics) {
  constexpr double kLocked = 1e-4;
  ++version_;
  if (size() == 0) return;
  measure_compliance(dynamics);
  const SymmetricEigenpairs of_P =
      symmetric_eigenpairs(unit_.cwiseInverse().asDiagonal() * compliance_ * unit_.cwiseInverse().asDiagonal());
  const VecX root = of_P.values.cwiseMax(kLocked).cwiseSqrt();
  const MatX R = unit_.asDiagonal() * of_P.vectors * root.asDiagonal();
  const SymmetricEigenpairs of_K = symmetric_eigenpairs(congruence(R, stiffness_));
  E_ = product(R, of_K.vectors);
  const MatX inverse_R =
      root.cwiseInverse().asDiagonal() * of_P.vectors.transpose() * unit_.cwiseInverse().asDiagonal();
  inverse_E_ = transposed_product(of_K.vectors, inverse_R);
  lambda_ = of_K.values;
  twice_delta_ = diagonal_of_congruence(E_, damping_);
  const VecX delta = 0.5 * twice_delta_.cwiseAbs();
  const VecX beyond = (delta.cwiseAbs2() - lambda_).cwiseMax(0.0).cwiseSqrt();  // of overdamped ones
  fastest_ = lambda_.cwiseAbs().cwiseSqrt().cwiseMax(delta + beyond).maxCoeff();
}

Response response(double lambda, double twice_delta, double t) {
  constexpr double kShort = 1e-4;
  const double delta = 0.5 * twice_delta;
  const double square = lambda - delta * delta;
  const double z = square * t * t;
  if (std::abs(z) < kShort) {
    const double decay = std::exp(-delta * t);
    const double place = t * (1.0 - z / 6.0 * (1.0 - z / 20.0 * (1.0 - z / 42.0)));
    const double cosine = 1.0 - z / 2.0 * (1.0 - z / 12.0 * (1.0 - z / 30.0));
    return {decay * place, decay * (cosine - delta * place)};
  }
  if (square > 0.0) {
    const double omega = std::sqrt(square);
    const double decay = std::exp(-delta * t);
    const double place = std::sin(omega * t) / omega;
    return {decay * place, decay * (std::cos(omega * t) - delta * place)};
  }
  // exp(-fast t) and exp(-slow t), of which the rate without cancellation is found first
  const double apart = std::copysign(std::sqrt(-square), delta);
  const double fast = delta + apart;
  const double slow = lambda / fast;
  const double of_fast = std::exp(-fast * t);
  const double of_slow = std::exp(-slow * t);
  return {0.5 * (of_slow - of_fast) / apart, 0.5 * (fast * of_fast - slow * of_slow) / apart};
}

}  // namespace concord::cartesian
