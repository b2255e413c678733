#include "common/flexible/modal_data.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "common/decompositions.h"

namespace concord {

namespace {

/// Square roots of the diagonal, 1 where it vanishes: dividing rows and columns by them makes G free of units.
VecX scales_of(const MatX& G) {
  return G.diagonal().unaryExpr([](double d) { return d > 0.0 ? std::sqrt(d) : 1.0; });
}

/// L with L L^T = G and as many columns as G has rank.
MatX factor(const MatX& G) {
  const VecX scales = scales_of(G);
  const SymmetricEigenpairs spectrum = symmetric_eigenpairs(without_units(G));
  const double round_off = static_cast<double>(G.rows()) * std::numeric_limits<double>::epsilon();
  const double largest = spectrum.values.maxCoeff();
  if (spectrum.values.minCoeff() < -1e3 * round_off * largest) {
    throw std::invalid_argument("mass integrals are not positive semidefinite: no distribution of mass has them");
  }
  const auto kept = (spectrum.values.array() > round_off * largest).count();
  const VecX roots = spectrum.values.tail(kept).cwiseSqrt();
  return scales.asDiagonal() * spectrum.vectors.rightCols(kept) * roots.asDiagonal();
}

/// Turns the columns of L among themselves (L Q, Q orthogonal: L L^T stays) so that the first row has equal entries.
/// The reflection that swaps the unit vectors along the first row and along [1 ... 1] does it.
void equalize_first_row(MatX& L) {
  const VecX first = L.row(0).transpose().normalized();
  const VecX equal = VecX::Constant(L.cols(), 1.0 / std::sqrt(static_cast<double>(L.cols())));
  const VecX mirror = first - equal;
  const double length2 = mirror.squaredNorm();
  if (length2 > 0.0) L -= (L * mirror) * (2.0 / length2 * mirror).transpose();
}

}  // namespace

MatX without_units(const MatX& G) {
  const VecX inverse_scales = scales_of(G).cwiseInverse();
  return inverse_scales.asDiagonal() * G * inverse_scales.asDiagonal();
}

VecX largest_displacements(const ModalData& modal) {
  VecX largest = VecX::Zero(modal.n_modes());
  for (const MassPoint& point : modal.mass_points) {
    largest = largest.cwiseMax(point.Psi_t_L.colwise().norm().transpose());
  }
  return largest;
}

MatX mass_integrals(const std::vector<MassPoint>& points, int n_modes) {
  const int size = 4 + 3 * n_modes;
  MatX G = MatX::Zero(size, size);
  VecX w(size);
  w(0) = 1.0;
  for (const MassPoint& point : points) {
    w.segment<3>(1) = point.s0_L;
    for (int mode = 0; mode < n_modes; ++mode) w.segment<3>(4 + 3 * mode) = point.Psi_t_L.col(mode);
    G.selfadjointView<Eigen::Lower>().rankUpdate(w, point.mass);
  }
  return G.selfadjointView<Eigen::Lower>();
}

std::vector<MassPoint> equivalent_mass_points(const MatX& G) {
  const auto n_modes = (G.rows() - 4) / 3;
  MatX L = factor(G);
  equalize_first_row(L);
  const double mass = G(0, 0) / static_cast<double>(L.cols());
  L /= std::sqrt(mass);
  std::vector<MassPoint> points;
  for (const auto& w : L.colwise()) {
    points.push_back({mass, w.segment<3>(1), w.tail(3 * n_modes).reshaped(3, n_modes)});
  }
  return points;
}

}  // namespace concord
