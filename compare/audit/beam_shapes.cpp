#include "compare/audit/beam_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "common/decompositions.h"
#include "common/error.h"
#include "common/flexible/beam.h"
#include "common/products.h"

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

/// Shapes by rising frequency, and the eigenvalues of the inverse problem.
struct Vibrations {
  MatX shapes;
  VecX mu;
};

/// Free vibrations of the line, by rising frequency, rigid ones left out. Of the inverse problem, whose largest
/// eigenvalues belong to the slowest modes; a line that is held nowhere is held by its mass.
Vibrations vibrations(const LineMatrices& line, const std::vector<Eigen::Index>& free, int rigid) {
  const MatX K = line.K(free, free);
  const MatX M = line.M(free, free);
  const double shift = rigid > 0 ? 100.0 * line.rate2 : 0.0;
  const std::optional<SymmetricEigenpairs> solved = symmetric_eigenpairs(M, K + shift * M);
  if (!solved) throw SolverError("audit: the stiffness of a beam's line is not positive definite");
  Vibrations found{MatX::Zero(line.K.rows(), K.cols() - rigid), VecX(K.cols() - rigid)};
  for (Eigen::Index k = 0; k < found.mu.size(); ++k) {
    const Eigen::Index own = K.cols() - 1 - rigid - k;
    found.mu(k) = solved->values(own);
    for (std::size_t f = 0; f < free.size(); ++f) {
      found.shapes(free[f], k) = solved->vectors(static_cast<Eigen::Index>(f), own);
    }
  }
  return found;
}

/// The line at rest with one number of its last end moved by one and nothing else held but its ends.
VecX static_shape(const LineMatrices& line, const std::vector<Eigen::Index>& free, Eigen::Index moved) {
  VecX shape = VecX::Unit(line.K.rows(), moved);
  if (free.empty()) return shape;
  const VecX inside = solve_square(line.K(free, free), -line.K(free, Eigen::all).col(moved));
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

/// How far an eigensolver may turn a shape, of modal mass 1, into those that are not stated: round-off of the largest
/// eigenvalue over the distance to theirs. The two highest modes of a free beam have nearly one frequency.
double doubt_of(const VecX& mu, const std::vector<bool>& is_stated, Eigen::Index k) {
  constexpr double kTimes = 1e3;
  double gap = std::numeric_limits<double>::infinity();
  for (Eigen::Index j = 0; j < mu.size(); ++j) {
    if (!is_stated[static_cast<std::size_t>(j)]) gap = std::min(gap, std::abs(mu(k) - mu(j)));
  }
  return kTimes * std::numeric_limits<double>::epsilon() * mu(0) / gap;
}

/// The stated shapes of a family, a column each, and the doubt of the least known one; too few where a mode does not
/// exist.
struct StatedShapes {
  MatX columns;
  double doubt = 0.0;
};
StatedShapes stated_shapes(const BeamSpecification& beam, const ShapeFamily& of, const LineMatrices& line) {
  const std::vector<Eigen::Index> free = free_numbers(of, beam.support, line.K.rows());
  const int rigid = beam.support == BeamSupport::free_free ? (of.bends ? 2 : 1) : 0;
  std::vector<VecX> shapes;
  std::vector<Eigen::Index> numbers;  // of vibrations, from 0
  for (const BeamMode& mode : beam.modes) {
    if (mode.family != of.family) continue;
    if (mode.is_static) {
      const Eigen::Index last_node = line.K.rows() - (of.bends ? 2 : 1);
      shapes.push_back(static_shape(line, free, last_node + mode.number - 1));
    } else {
      numbers.push_back(mode.number - 1);
    }
  }
  StatedShapes stated;
  if (!numbers.empty()) {
    const Vibrations all = vibrations(line, free, rigid);
    std::vector<bool> is_stated(static_cast<std::size_t>(all.mu.size()), false);
    for (const Eigen::Index number : numbers) {
      if (number >= all.mu.size()) continue;
      shapes.emplace_back(all.shapes.col(number));
      is_stated[static_cast<std::size_t>(number)] = true;
    }
    for (const Eigen::Index number : numbers) {
      if (number < all.mu.size()) stated.doubt = std::max(stated.doubt, doubt_of(all.mu, is_stated, number));
    }
  }
  stated.columns.resize(line.K.rows(), static_cast<Eigen::Index>(shapes.size()));
  for (std::size_t k = 0; k < shapes.size(); ++k) stated.columns.col(static_cast<Eigen::Index>(k)) = shapes[k];
  return stated;
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
    modal_mass += congruence(numbers, line.M);
    const StatedShapes stated = stated_shapes(beam, of, line);
    MatX rest = numbers;
    if (stated.columns.cols() > 0) {
      const VecX sizes = diagonal_of_congruence(stated.columns, line.M).cwiseSqrt().cwiseInverse();
      const MatX scaled = stated.columns * sizes.asDiagonal();
      const MatX M_numbers = product(line.M, numbers);
      rest -= product(scaled, solve_square(congruence(scaled, line.M), transposed_product(scaled, M_numbers)));
    }
    const VecX squares = diagonal_of_congruence(rest, line.M);
    beyond.row(static_cast<Eigen::Index>(of.family)) =
        (squares.cwiseAbs().cwiseSqrt().array() - stated.doubt).cwiseMax(0.0);
  }
  return {largest_of(beyond), largest_of(modal_mass - MatX::Identity(m, m))};
}

}  // namespace concord::compare
