#include "compare/audit/beam_shapes.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "common/flexible/beam.h"

namespace concord::compare {

namespace {

/// One family of a beam's motions. Numbers of a node: displacement, and in bending the slope times the element's width.
struct ShapeFamily {
  BeamFamily family;
  bool bends;
  double rigidity;  // EI, GJ, EA
  double inertia;   // per length
};

std::array<ShapeFamily, 4> families_of(const BeamSpecification& beam) {
  const double line = beam.density * beam.area;
  const double polar = beam.density * (beam.second_moment_y + beam.second_moment_z);
  return {{{BeamFamily::bending_xy, true, beam.youngs_modulus * beam.second_moment_z, line},
           {BeamFamily::bending_xz, true, beam.youngs_modulus * beam.second_moment_y, line},
           {BeamFamily::torsion, false, beam.shear_modulus * beam.torsion_constant, polar},
           {BeamFamily::axial, false, beam.youngs_modulus * beam.area, line}}};
}

/// Stiffness and consistent mass of a line of equal elements.
struct LineMatrices {
  MatX K;
  MatX M;
  double rate2 = 0.0;  // EI / (rho A L^4), GJ / (rho I_p L^2), ...: the size of the slowest eigenvalue
};

LineMatrices assemble_line(const ShapeFamily& of, int elements, double h) {
  const int own = of.bends ? 2 : 1;
  MatX k(2 * own, 2 * own);
  MatX m(2 * own, 2 * own);
  if (of.bends) {
    k << 12, 6, -12, 6, 6, 4, -6, 2, -12, -6, 12, -6, 6, 2, -6, 4;
    m << 156, 22, 54, -13, 22, 4, 13, -3, 54, 13, 156, -22, -13, -3, -22, 4;
    k *= of.rigidity / (h * h * h);
    m *= of.inertia * h / 420.0;
  } else {
    k << 1, -1, -1, 1;
    m << 2, 1, 1, 2;
    k *= of.rigidity / h;
    m *= of.inertia * h / 6.0;
  }
  const Eigen::Index n = own * (elements + 1);
  const double length = h * elements;
  LineMatrices line{MatX::Zero(n, n), MatX::Zero(n, n),
                    of.rigidity / of.inertia / std::pow(length, of.bends ? 4.0 : 2.0)};
  for (int e = 0; e < elements; ++e) {
    line.K.block(own * e, own * e, 2 * own, 2 * own) += k;
    line.M.block(own * e, own * e, 2 * own, 2 * own) += m;
  }
  return line;
}

/// Which numbers the supports leave free, as data/format/bodies.md says of each support.
std::vector<Eigen::Index> free_numbers(const ShapeFamily& of, BeamSupport support, Eigen::Index n) {
  std::vector<Eigen::Index> free;
  const Eigen::Index own = of.bends ? 2 : 1;
  for (Eigen::Index k = 0; k < n; ++k) {
    const bool at_first = k < own;
    const bool at_last = k >= n - own;
    const bool is_slope = of.bends && k % own == 1;
    bool is_held = false;
    if (support == BeamSupport::cantilever) is_held = at_first;
    if (support == BeamSupport::craig_bampton) is_held = at_first || at_last;
    if (support == BeamSupport::simply_supported) {
      is_held = !is_slope && (at_first || (at_last && of.family != BeamFamily::axial));
    }
    if (!is_held) free.push_back(k);
  }
  return free;
}

/// Free vibrations of the line, by rising frequency, rigid ones left out. Of the inverse problem, whose largest
/// eigenvalues belong to the slowest modes; a line that is held nowhere is held by its mass.
MatX vibrations(const LineMatrices& line, const std::vector<Eigen::Index>& free, int rigid) {
  const MatX K = line.K(free, free);
  const MatX M = line.M(free, free);
  const double shift = rigid > 0 ? 10.0 * line.rate2 : 0.0;
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatX> solved(M, K + shift * M);
  MatX shapes = MatX::Zero(line.K.rows(), K.cols() - rigid);
  for (Eigen::Index k = 0; k < shapes.cols(); ++k) {
    const VecX of_free = solved.eigenvectors().col(K.cols() - 1 - rigid - k);
    for (std::size_t f = 0; f < free.size(); ++f) shapes(free[f], k) = of_free(static_cast<Eigen::Index>(f));
  }
  return shapes;
}

/// The line at rest with one number of its last end moved by one and nothing else held but its ends.
VecX static_shape(const LineMatrices& line, const std::vector<Eigen::Index>& free, Eigen::Index moved) {
  VecX shape = VecX::Unit(line.K.rows(), moved);
  if (free.empty()) return shape;
  const VecX inside = line.K(free, free).ldlt().solve(-line.K(free, Eigen::all).col(moved));
  for (std::size_t f = 0; f < free.size(); ++f) shape(free[f]) = inside(static_cast<Eigen::Index>(f));
  return shape;
}

/// The numbers of the line in the modes of a body, a column each.
MatX numbers_of(const ModalData& modal, const ShapeFamily& of, double h) {
  const BeamSpecification& beam = *modal.beam;
  const Eigen::Index own = of.bends ? 2 : 1;
  MatX numbers(own * (beam.elements + 1), modal.nodes.front().Psi_t_L.cols());
  for (int k = 0; k <= beam.elements; ++k) {
    const ModalNode& node = modal.nodes[static_cast<std::size_t>(k)];
    const Mat3X moved = beam.axes.transpose() * node.Psi_t_L;
    const Mat3X turned = beam.axes.transpose() * node.Psi_r_L;
    switch (of.family) {
      case BeamFamily::bending_xy:
        numbers.middleRows<2>(own * k) << moved.row(1), h * turned.row(2);
        break;
      case BeamFamily::bending_xz:
        numbers.middleRows<2>(own * k) << moved.row(2), -h * turned.row(1);
        break;
      case BeamFamily::torsion:
        numbers.row(k) = turned.row(0);
        break;
      case BeamFamily::axial:
        numbers.row(k) = moved.row(0);
        break;
    }
  }
  return numbers;
}

/// The stated shapes of a family, a column each; too few where a mode does not exist.
MatX stated_shapes(const BeamSpecification& beam, const ShapeFamily& of, const LineMatrices& line) {
  const std::vector<Eigen::Index> free = free_numbers(of, beam.support, line.K.rows());
  const int rigid = beam.support == BeamSupport::free_free ? (of.bends ? 2 : 1) : 0;
  std::vector<VecX> shapes;
  MatX vibrating;
  for (const BeamMode& mode : beam.modes) {
    if (mode.family != of.family) continue;
    if (mode.is_static) {
      const Eigen::Index last_node = line.K.rows() - (of.bends ? 2 : 1);
      shapes.push_back(static_shape(line, free, last_node + mode.number - 1));
      continue;
    }
    if (vibrating.size() == 0) vibrating = vibrations(line, free, rigid);
    if (mode.number <= vibrating.cols()) shapes.emplace_back(vibrating.col(mode.number - 1));
  }
  MatX columns(line.K.rows(), static_cast<Eigen::Index>(shapes.size()));
  for (std::size_t k = 0; k < shapes.size(); ++k) columns.col(static_cast<Eigen::Index>(k)) = shapes[k];
  return columns;
}

/// The largest entry; infinite if one is no number.
double largest_of(const MatX& entries) {
  if (!entries.allFinite()) return std::numeric_limits<double>::infinity();
  return entries.size() > 0 ? entries.cwiseAbs().maxCoeff() : 0.0;
}

}  // namespace

ShapeMisfit compute_misfit_of_shapes(const ModalData& modal) {
  const BeamSpecification& beam = *modal.beam;
  const double h = beam.length / beam.elements;
  const auto m = static_cast<Eigen::Index>(beam.modes.size());
  MatX modal_mass = MatX::Zero(m, m);
  MatX beyond = MatX::Zero(4, m);
  for (const ShapeFamily& of : families_of(beam)) {
    const MatX numbers = numbers_of(modal, of, h);
    if (numbers.isZero(0.0)) continue;
    const LineMatrices line = assemble_line(of, beam.elements, h);
    modal_mass += numbers.transpose() * line.M * numbers;
    const MatX stated = stated_shapes(beam, of, line);
    MatX rest = numbers;
    if (stated.cols() > 0) {
      const VecX sizes = (stated.transpose() * line.M * stated).diagonal().cwiseSqrt().cwiseInverse();
      const MatX scaled = stated * sizes.asDiagonal();
      rest -= scaled * (scaled.transpose() * line.M * scaled).ldlt().solve(scaled.transpose() * line.M * numbers);
    }
    beyond.row(static_cast<Eigen::Index>(of.family)) =
        (rest.transpose() * line.M * rest).diagonal().cwiseAbs().cwiseSqrt();
  }
  return {largest_of(beyond), largest_of(modal_mass - MatX::Identity(m, m))};
}

}  // namespace concord::compare
