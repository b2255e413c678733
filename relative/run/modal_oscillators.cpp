#include "relative/run/modal_oscillators.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/decompositions.h"

namespace concord::relative {

namespace {

/// Eigenvectors of S as columns, of complex pairs the real and the imaginary part, and the real parts of the
/// eigenvalues; the unit vectors and the diagonal of S where these nearly depend on each other.
std::pair<MatX, VecX> real_eigenpairs(const MatX& S) {
  constexpr double kDependent = 1e6;
  const GeneralEigenpairs found = eigenpairs(S);
  MatX V = found.vectors.real();
  for (Eigen::Index k = 0; k < S.cols(); ++k) {
    if (found.values(k).imag() < 0.0) V.col(k) = found.vectors.col(k).imag();
    if (V.col(k).norm() > 0.0) V.col(k).normalize();
  }
  const VecX sigma = singular_values(V);
  if (V.allFinite() && sigma.maxCoeff() < kDependent * sigma.minCoeff()) return {V, found.values.real()};
  return {MatX::Identity(S.rows(), S.cols()), S.diagonal()};
}

}  // namespace

Propagator propagator(double s, double d, double tau) {
  constexpr double kSmall = 1e-4;
  const double c = 0.5 * d;
  const double square = c * c - s;
  double even = 0.0;  // exp(-c tau) cosh(r tau) - 1
  double odd = 0.0;   // exp(-c tau) sinh(r tau) / r
  if (square < 0.0) {
    const double w = std::sqrt(-square);
    const double decay = std::exp(-c * tau);
    const double half = std::sin(0.5 * w * tau);
    even = std::expm1(-c * tau) * std::cos(w * tau) - 2.0 * half * half;
    odd = decay * std::sin(w * tau) / w;
  } else {
    const double r = std::sqrt(square);
    const double x = r * tau;
    const double grown = std::exp(x - c * tau);
    even = 0.5 * (std::expm1(x - c * tau) + std::expm1(-x - c * tau));
    odd = std::abs(x) < kSmall ? std::exp(-c * tau) * tau * (1.0 + x * x / 6.0)
                               : -grown * std::expm1(-2.0 * x) / (2.0 * r);
  }
  const double xx = even + c * odd;
  const double vv = even - c * odd;
  return {1.0 + xx, odd, -s * odd, 1.0 + vv, xx, vv};
}

ModalOscillators::ModalOscillators(std::vector<int> a, std::vector<int> adot, VecX sizes)
    : a_(std::move(a)), adot_(std::move(adot)), sizes_(std::move(sizes)) {
  const Eigen::Index m = size();
  V_ = inverse_ = MatX::Identity(m, m);
  stiffness_ = damping_ = modal_ = single_ = VecX::Zero(m);
}

void ModalOscillators::set(const MatX& S, const MatX& D) {  // (R82)
  if (size() == 0) return;
  const auto [V, values] = real_eigenpairs(sizes_.cwiseInverse().asDiagonal() * S * sizes_.asDiagonal());
  V_ = sizes_.asDiagonal() * V;
  inverse_ = solve_square(V, MatX::Identity(size(), size())) * sizes_.cwiseInverse().asDiagonal();
  stiffness_ = values;
  damping_ = (inverse_ * D * V_).diagonal();
}

double ModalOscillators::fastest() const {
  if (size() == 0) return 0.0;
  return (stiffness_.cwiseAbs().cwiseSqrt() + damping_.cwiseAbs()).maxCoeff();
}

void ModalOscillators::gather(const Eigen::Ref<const VecX>& y, Eigen::Ref<VecX> z) const {
  const Eigen::Index m = size();
  for (Eigen::Index k = 0; k < m; ++k) {
    z(k) = y(a_[k]);
    z(m + k) = y(adot_[k]);
  }
}

void ModalOscillators::add(const Eigen::Ref<const VecX>& z, Eigen::Ref<VecX> y) const {
  const Eigen::Index m = size();
  for (Eigen::Index k = 0; k < m; ++k) {
    y(a_[k]) += z(k);
    y(adot_[k]) += z(m + k);
  }
}

void ModalOscillators::scatter(const VecX& x, const VecX& v, Eigen::Ref<VecX> y) const {
  modal_.noalias() = V_ * x;
  for (Eigen::Index k = 0; k < size(); ++k) y(a_[k]) = modal_(k);
  modal_.noalias() = V_ * v;
  for (Eigen::Index k = 0; k < size(); ++k) y(adot_[k]) = modal_(k);
}

void ModalOscillators::remainder(const Eigen::Ref<const VecX>& z, const Eigen::Ref<const VecX>& ydot,
                                 Eigen::Ref<VecX> g) const {  // (R82)
  const Eigen::Index m = size();
  for (Eigen::Index k = 0; k < m; ++k) modal_(k) = ydot(adot_[k]);
  to_oscillators(modal_, g);
  to_oscillators(z.head(m), single_);
  g += stiffness_.cwiseProduct(single_);
  to_oscillators(z.tail(m), single_);
  g += damping_.cwiseProduct(single_);
}

}  // namespace concord::relative
