#include "common/flexible/beam_modes.h"

#include <Spectra/MatOp/SparseSymMatProd.h>
#include <Spectra/SymGEigsShiftSolver.h>
#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "common/decompositions.h"
#include "common/products.h"

namespace concord::beams {

namespace {

/// Rows and columns of `full` that are free.
SparseMatrix restrict_to(const std::vector<int>& free, const SparseMatrix& full) {
  SparseMatrix select(full.rows(), static_cast<Eigen::Index>(free.size()));
  for (std::size_t k = 0; k < free.size(); ++k) select.insert(free[k], static_cast<int>(k)) = 1.0;
  return select.transpose() * full * select;
}

/// Motions without strain: a line that nothing holds has one, or two if it bends. Columns orthonormal in the mass M.
MatX rigid_shapes(const Line& line, const SparseMatrix& M) {
  if (static_cast<int>(line.free.size()) < line.size()) return {M.rows(), 0};
  MatX shapes = MatX::Zero(line.size(), line.per_node());
  for (int node = 0; node <= line.elements; ++node) {
    shapes(line.per_node() * node, 0) = 1.0;
    if (!line.bends) continue;
    shapes(2 * node, 1) = line.width * node - 0.5 * line.length();
    shapes(2 * node + 1, 1) = 1.0;
  }
  for (auto column : shapes.colwise()) column /= std::sqrt(column.dot(M * column));
  return shapes;
}

/// (K - sigma M)^-1 by a sparse Cholesky factorization, followed by the projection that takes rigid shapes away: the
/// operator of Spectra's shift-and-invert mode.
class ShiftedInverse {
 public:
  using Scalar = double;

  ShiftedInverse(const SparseMatrix& K, const SparseMatrix& M, const MatX& rigid)
      : K_(K), M_(M), rigid_(rigid), M_rigid_(M * rigid) {}

  [[nodiscard]] Eigen::Index rows() const { return K_.rows(); }
  [[nodiscard]] Eigen::Index cols() const { return K_.cols(); }

  void set_shift(double sigma) {
    factorization_.compute(K_ - sigma * M_);
    if (factorization_.info() != Eigen::Success) {
      throw std::runtime_error("beam: the shifted stiffness of a family of modes cannot be factorized");
    }
  }

  void perform_op(const double* in, double* out) const {
    Eigen::Map<VecX> result(out, rows());
    result = solve(Eigen::Map<const VecX>(in, rows()));
  }

  [[nodiscard]] MatX solve(const MatX& right) const {
    const MatX result = factorization_.solve(right);
    return result - product(rigid_, transposed_product(M_rigid_, result));
  }

 private:
  SparseMatrix K_;
  SparseMatrix M_;
  MatX rigid_;
  MatX M_rigid_;
  Eigen::SimplicialLLT<SparseMatrix> factorization_;
};

/// The `wanted` lowest elastic modes of a large problem, columns in order of frequency.
MatX few_modes(ShiftedInverse& inverse, const SparseMatrix& M, int wanted, double sigma) {
  using Mass = Spectra::SparseSymMatProd<double>;
  Mass mass(M);
  const int basis = std::min(static_cast<int>(M.rows()), 2 * wanted + 20);
  Spectra::SymGEigsShiftSolver<ShiftedInverse, Mass, Spectra::GEigsMode::ShiftInvert> solver(inverse, mass, wanted,
                                                                                             basis, sigma);
  solver.init();
  solver.compute(Spectra::SortRule::LargestMagn, 1000, 1e-13, Spectra::SortRule::SmallestAlge);
  if (solver.info() != Spectra::CompInfo::Successful) {
    throw std::runtime_error("beam: Spectra's Lanczos iteration for the modes did not converge");
  }
  return solver.eigenvectors();
}

/// The same where most modes are wanted: the dense problem M x = mu (K - sigma M) x, largest mu first.
MatX most_modes(const SparseMatrix& K, const SparseMatrix& M, int wanted, double sigma, Eigen::Index n_rigid) {
  const auto solution = symmetric_eigenpairs(MatX(M), MatX(K - sigma * M));
  if (!solution) throw std::runtime_error("beam: the stiffness with its shift is not positive definite");
  return solution->vectors.rowwise().reverse().middleCols(n_rigid, wanted);
}

/// The line in units of its own length, stiffness and inertia. The eigensolvers have thresholds with units: of a beam
/// of half a millimetre the second shape was wrong by 3 %.
Line in_own_units(const Line& line) {
  Line unit = line;
  unit.width = 1.0 / line.elements;
  unit.stiffness = 1.0;
  unit.inertia = 1.0;
  return unit;
}

/// The `wanted` lowest elastic modes of the line as numbers at all its nodes, in order of frequency.
MatX normal_modes(const Line& line, int wanted) {
  const Line unit = in_own_units(line);
  const SparseMatrix K = restrict_to(line.free, assemble(unit, strain, unit.stiffness));
  const SparseMatrix M = restrict_to(line.free, assemble(unit, interpolation, unit.inertia));
  const MatX rigid = rigid_shapes(unit, M);
  constexpr double sigma = -1.0;  // of the size of the lowest eigenvalue; K - sigma M is positive definite
  MatX at_free;
  if (3 * wanted + 20 < M.rows()) {
    ShiftedInverse inverse(K, M, rigid);
    at_free = few_modes(inverse, M, wanted, sigma);
  } else {
    at_free = most_modes(K, M, wanted, sigma, rigid.cols());
  }
  MatX shapes = MatX::Zero(line.size(), wanted);
  for (std::size_t k = 0; k < line.free.size(); ++k) shapes.row(line.free[k]) = at_free.row(static_cast<int>(k));
  for (int slope = 1; line.bends && slope < line.size(); slope += 2) shapes.row(slope) *= unit.width / line.width;
  return shapes;
}

void check_exists(const BeamSpecification& beam, const Line& line, const BeamMode& mode) {
  const int n_rigid = static_cast<int>(line.free.size()) == line.size() ? line.per_node() : 0;
  const int available = mode.is_static ? (beam.support == BeamSupport::craig_bampton ? line.per_node() : 0)
                                       : static_cast<int>(line.free.size()) - n_rigid;
  if (mode.number < 1 || mode.number > available) {
    throw std::invalid_argument(
        fmt::format("beam: {}{} mode {} does not exist: with these supports and {} elements there are {}",
                    mode.is_static ? "static " : "", name_of(mode.family), mode.number, beam.elements, available));
  }
}

bool same(const BeamMode& a, const BeamMode& b) {
  return a.family == b.family && a.number == b.number && a.is_static == b.is_static;
}

/// The chosen modes of a family as they come, not yet orthogonal.
MatX chosen_shapes(const Line& line, const std::vector<BeamMode>& chosen) {
  int highest = 0;
  for (const BeamMode& mode : chosen) highest = std::max(highest, mode.is_static ? 0 : mode.number);
  const MatX normal = highest > 0 ? normal_modes(line, highest) : MatX(line.size(), 0);
  MatX shapes(line.size(), static_cast<Eigen::Index>(chosen.size()));
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    if (chosen[k].is_static) {
      shapes.col(column) = static_shape(line, chosen[k].number);
    } else {
      shapes.col(column) = normal.col(chosen[k].number - 1);
    }
  }
  return shapes;
}

/// Makes the largest displacement of each shape positive; of several that are equal but for round-off, the first.
void fix_signs(const Line& line, MatX& shapes) {
  for (auto shape : shapes.colwise()) {
    const double enough = 0.999 * shape(Eigen::seqN(0, line.elements + 1, line.per_node())).cwiseAbs().maxCoeff();
    int first = 0;
    while (std::abs(shape(first)) < enough) first += line.per_node();
    if (shape(first) < 0.0) shape = -shape;
  }
}

/// Orthogonal in mass and stiffness, unit modal mass, in order of frequency (S8).
void orthogonalize(FamilyModes& modes) {
  for (auto shape : modes.shapes.colwise()) shape /= shape.norm();
  const MatX mass = reduce(modes.line, interpolation, modes.line.inertia, modes.shapes);
  const MatX stiffness = reduce(modes.line, strain, modes.line.stiffness, modes.shapes);
  const auto solution = symmetric_eigenpairs(stiffness, mass);
  if (!solution) throw std::runtime_error("beam: the chosen modes are not independent");
  modes.shapes = product(modes.shapes, solution->vectors);
  modes.frequencies = solution->values.cwiseSqrt();
  fix_signs(modes.line, modes.shapes);
}

}  // namespace

FamilyModes make_family(const BeamSpecification& beam, BeamFamily family) {
  FamilyModes modes;
  std::vector<BeamMode> chosen;
  for (std::size_t k = 0; k < beam.modes.size(); ++k) {
    if (beam.modes[k].family != family) continue;
    modes.columns.push_back(static_cast<int>(k));
    chosen.push_back(beam.modes[k]);
  }
  if (chosen.empty()) return modes;
  modes.line = make_line(beam, family);
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    check_exists(beam, modes.line, chosen[k]);
    for (std::size_t other = 0; other < k; ++other) {
      if (same(chosen[k], chosen[other])) {
        throw std::invalid_argument(fmt::format("beam: {} mode {} is chosen twice", name_of(family), chosen[k].number));
      }
    }
  }
  modes.shapes = chosen_shapes(modes.line, chosen);
  orthogonalize(modes);
  return modes;
}

}  // namespace concord::beams
