#include "common/flexible/beam.h"

#include <Spectra/MatOp/SparseSymMatProd.h>
#include <Spectra/SymGEigsShiftSolver.h>
#include <fmt/format.h>

#include <Eigen/CholmodSupport>
#include <Eigen/Eigenvalues>
#include <Eigen/Sparse>
#include <array>
#include <cmath>
#include <stdexcept>

#include "common/decompositions.h"

namespace concord {

namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;
using ShapeRow = Eigen::RowVectorXd;

constexpr std::array kFamilies{BeamFamily::bending_xy, BeamFamily::bending_xz, BeamFamily::torsion, BeamFamily::axial};

const char* name_of(BeamFamily family) {
  switch (family) {
    case BeamFamily::bending_xy:
      return "bending_xy";
    case BeamFamily::bending_xz:
      return "bending_xz";
    case BeamFamily::torsion:
      return "torsion";
    case BeamFamily::axial:
      return "axial";
  }
  throw std::invalid_argument("beam: unknown family of modes");
}

bool is_bending(BeamFamily family) { return family == BeamFamily::bending_xy || family == BeamFamily::bending_xz; }

/// Gauss-Legendre quadrature on [0, 1] with four points: exact up to degree 7, hence for products of two cubics.
struct GaussPoint {
  double xi;
  double weight;
};
std::array<GaussPoint, 4> gauss_points() {
  const double root = 2.0 / 7.0 * std::sqrt(6.0 / 5.0);
  const double inner = std::sqrt(3.0 / 7.0 - root);
  const double outer = std::sqrt(3.0 / 7.0 + root);
  const double inner_weight = (18.0 + std::sqrt(30.0)) / 72.0;
  const double outer_weight = (18.0 - std::sqrt(30.0)) / 72.0;
  return {{{0.5 - 0.5 * outer, outer_weight},
           {0.5 - 0.5 * inner, inner_weight},
           {0.5 + 0.5 * inner, inner_weight},
           {0.5 + 0.5 * outer, outer_weight}}};
}

/// The finite elements of one family on the line 0 <= x <= L. Bending: Hermite cubics, displacement and slope at each
/// node; torsion and axial: linear, one number at each node.
struct Line {
  bool bends = false;
  int elements = 0;
  double width = 0.0;      // of an element, m
  double stiffness = 0.0;  // E I, G J or E A
  double inertia = 0.0;    // per length: of translation, or polar for torsion
  std::vector<int> free;   // numbers that the supports leave free

  [[nodiscard]] int per_node() const { return bends ? 2 : 1; }
  [[nodiscard]] int size() const { return per_node() * (elements + 1); }
  [[nodiscard]] double length() const { return width * elements; }
};

/// Displacement (or twist) at xi in [0, 1] of an element, from the numbers at its two nodes.
ShapeRow interpolation(const Line& line, double xi) {
  if (!line.bends) return ShapeRow{{1.0 - xi, xi}};
  const double back = 1.0 - xi;
  return ShapeRow{{back * back * (1.0 + 2.0 * xi), line.width * xi * back * back, xi * xi * (3.0 - 2.0 * xi),
                   -line.width * xi * xi * back}};
}

/// Strain at xi: curvature, twist per length or stretch.
ShapeRow strain(const Line& line, double xi) {
  const double h = line.width;
  if (!line.bends) return ShapeRow{{-1.0 / h, 1.0 / h}};
  return ShapeRow{
      {(12.0 * xi - 6.0) / (h * h), (6.0 * xi - 4.0) / h, (6.0 - 12.0 * xi) / (h * h), (6.0 * xi - 2.0) / h}};
}

/// integral of factor * rows(x)^T rows(x) over the line, for `rows` one of the two functions above (S6).
SparseMatrix assemble(const Line& line, ShapeRow (*rows)(const Line&, double), double factor) {
  const int n = 2 * line.per_node();
  MatX element = MatX::Zero(n, n);
  for (const GaussPoint& point : gauss_points()) {
    const ShapeRow row = rows(line, point.xi);
    element += factor * line.width * point.weight * row.transpose() * row;
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (int e = 0; e < line.elements; ++e) {
    const int first = e * line.per_node();
    for (int r = 0; r < n; ++r) {
      for (int c = 0; c < n; ++c) entries.emplace_back(first + r, first + c, element(r, c));
    }
  }
  SparseMatrix assembled(line.size(), line.size());
  assembled.setFromTriplets(entries.begin(), entries.end());
  return assembled;
}

/// The same integral for the columns of `shapes`. Strains are formed first: far less round-off than shapes^T K shapes.
MatX reduce(const Line& line, ShapeRow (*rows)(const Line&, double), double factor, const MatX& shapes) {
  MatX reduced = MatX::Zero(shapes.cols(), shapes.cols());
  const int n = 2 * line.per_node();
  for (int e = 0; e < line.elements; ++e) {
    for (const GaussPoint& point : gauss_points()) {
      const ShapeRow row = rows(line, point.xi) * shapes.middleRows(e * line.per_node(), n);
      reduced += factor * line.width * point.weight * row.transpose() * row;
    }
  }
  return reduced;
}

/// Which numbers of the first and of the last node the supports hold: all, the displacement or twist only, or none.
enum class Hold { none, displacement, all };
struct Holds {
  Hold first;
  Hold last;
};

Holds holds(BeamSupport support, BeamFamily family) {
  switch (support) {
    case BeamSupport::simply_supported:
      return {Hold::displacement, family == BeamFamily::axial ? Hold::none : Hold::displacement};
    case BeamSupport::cantilever:
      return {Hold::all, Hold::none};
    case BeamSupport::free_free:
      return {Hold::none, Hold::none};
    case BeamSupport::craig_bampton:
      return {Hold::all, Hold::all};
  }
  throw std::invalid_argument("beam: unknown support");
}

std::vector<int> free_numbers(const Line& line, const Holds& held) {
  const auto is_held = [&](Hold hold, int number) {
    return hold == Hold::all || (hold == Hold::displacement && number == 0);
  };
  std::vector<int> free;
  for (int k = 0; k < line.size(); ++k) {
    const int node = k / line.per_node();
    const int number = k % line.per_node();
    const bool at_first = node == 0 && is_held(held.first, number);
    const bool at_last = node == line.elements && is_held(held.last, number);
    if (!at_first && !at_last) free.push_back(k);
  }
  return free;
}

Line make_line(const BeamSpecification& beam, BeamFamily family) {
  Line line;
  line.bends = is_bending(family);
  line.elements = beam.elements;
  line.width = beam.length / beam.elements;
  line.inertia = beam.density * beam.area;
  switch (family) {
    case BeamFamily::bending_xy:
      line.stiffness = beam.youngs_modulus * beam.second_moment_z;
      break;
    case BeamFamily::bending_xz:
      line.stiffness = beam.youngs_modulus * beam.second_moment_y;
      break;
    case BeamFamily::torsion:
      line.stiffness = beam.shear_modulus * beam.torsion_constant;
      line.inertia = beam.density * (beam.second_moment_y + beam.second_moment_z);
      break;
    case BeamFamily::axial:
      line.stiffness = beam.youngs_modulus * beam.area;
      break;
  }
  if (!(line.stiffness > 0.0 && line.inertia > 0.0)) {
    throw std::invalid_argument(
        fmt::format("beam: family {} has stiffness {:g} and inertia per length {:g}; both must be positive: give the "
                    "section and the material that it needs",
                    name_of(family), line.stiffness, line.inertia));
  }
  line.free = free_numbers(line, holds(beam.support, family));
  return line;
}

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

/// (K - sigma M)^-1 by CHOLMOD, followed by the projection that takes rigid shapes away: the operator of Spectra's
/// shift-and-invert mode.
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
      throw std::runtime_error("beam: CHOLMOD cannot factorize the shifted stiffness of a family of modes");
    }
  }

  void perform_op(const double* in, double* out) const {
    Eigen::Map<VecX> result(out, rows());
    result = solve(Eigen::Map<const VecX>(in, rows()));
  }

  [[nodiscard]] MatX solve(const MatX& right) const {
    const MatX result = factorization_.solve(right);
    return result - rigid_ * (M_rigid_.transpose() * result);
  }

 private:
  SparseMatrix K_;
  SparseMatrix M_;
  MatX rigid_;
  MatX M_rigid_;
  Eigen::CholmodSimplicialLLT<SparseMatrix> factorization_;
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

/// The `wanted` lowest elastic modes of the line as numbers at all its nodes, in order of frequency.
MatX normal_modes(const Line& line, int wanted) {
  const SparseMatrix K = restrict_to(line.free, assemble(line, strain, line.stiffness));
  const SparseMatrix M = restrict_to(line.free, assemble(line, interpolation, line.inertia));
  const MatX rigid = rigid_shapes(line, M);
  // A shift of the size of the lowest eigenvalue, on the side where K - sigma M stays positive definite.
  const double sigma = -line.stiffness / (line.inertia * std::pow(line.length(), line.bends ? 4 : 2));
  MatX at_free;
  if (3 * wanted + 20 < M.rows()) {
    ShiftedInverse inverse(K, M, rigid);
    at_free = few_modes(inverse, M, wanted, sigma);
  } else {
    at_free = most_modes(K, M, wanted, sigma, rigid.cols());
  }
  MatX shapes = MatX::Zero(line.size(), wanted);
  for (std::size_t k = 0; k < line.free.size(); ++k) shapes.row(line.free[k]) = at_free.row(static_cast<int>(k));
  return shapes;
}

/// The shape that a unit displacement of the free end gives to the line, its first end clamped: number 1 displacement
/// or twist, number 2 slope. Exact: no load between the ends leaves a cubic, or a straight line (S7).
VecX static_shape(const Line& line, int number) {
  VecX shape(line.size());
  const double L = line.length();
  for (int node = 0; node <= line.elements; ++node) {
    const double xi = static_cast<double>(node) / line.elements;
    if (!line.bends) {
      shape(node) = xi;
    } else if (number == 1) {
      shape.segment<2>(2 * node) << xi * xi * (3.0 - 2.0 * xi), 6.0 * xi * (1.0 - xi) / L;
    } else {
      shape.segment<2>(2 * node) << L * xi * xi * (xi - 1.0), xi * (3.0 * xi - 2.0);
    }
  }
  return shape;
}

/// Modes of one family after orthogonalization: numbers at all nodes, one column each, and frequencies [rad/s].
struct FamilyModes {
  Line line;
  MatX shapes;
  VecX frequencies;
  std::vector<int> columns;  // which modes of the beam they are
};

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
  modes.shapes *= solution->vectors;
  modes.frequencies = solution->values.cwiseSqrt();
  fix_signs(modes.line, modes.shapes);
}

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

/// Motion of one section in the beam's axes, one column for each mode: translation of its centre and rotation (twist,
/// and the slopes of bending).
struct SectionMotion {
  Mat3X translation;
  Mat3X rotation;
};

/// Adds one mode's value at a section to the direction in which its family moves it.
void add_value(BeamFamily family, double value, int column, SectionMotion& motion) {
  switch (family) {
    case BeamFamily::bending_xy:
      motion.translation(1, column) = value;
      break;
    case BeamFamily::bending_xz:
      motion.translation(2, column) = value;
      break;
    case BeamFamily::torsion:
      motion.rotation(0, column) = value;
      break;
    case BeamFamily::axial:
      motion.translation(0, column) = value;
      break;
  }
}

/// The section's rotation in bending: a slope of y turns it about +z, a slope of z about -y.
void add_slope(BeamFamily family, double slope, int column, SectionMotion& motion) {
  if (family == BeamFamily::bending_xy) motion.rotation(2, column) = slope;
  if (family == BeamFamily::bending_xz) motion.rotation(1, column) = -slope;
}

/// All modes of the beam, families side by side.
struct BeamModes {
  std::array<FamilyModes, kFamilies.size()> families;
  int count = 0;
};

SectionMotion still(int count) { return {Mat3X::Zero(3, count), Mat3X::Zero(3, count)}; }

SectionMotion at_node(const BeamModes& modes, int node) {
  SectionMotion motion = still(modes.count);
  for (std::size_t f = 0; f < kFamilies.size(); ++f) {
    const FamilyModes& family = modes.families[f];
    for (std::size_t k = 0; k < family.columns.size(); ++k) {
      const auto shape = family.shapes.col(static_cast<Eigen::Index>(k));
      const int first = family.line.per_node() * node;
      add_value(kFamilies[f], shape(first), family.columns[k], motion);
      if (family.line.bends) add_slope(kFamilies[f], shape(first + 1), family.columns[k], motion);
    }
  }
  return motion;
}

/// At xi in [0, 1] of an element, without the slopes: they move no mass.
SectionMotion in_element(const BeamModes& modes, int element, double xi) {
  SectionMotion motion = still(modes.count);
  for (std::size_t f = 0; f < kFamilies.size(); ++f) {
    const FamilyModes& family = modes.families[f];
    if (family.columns.empty()) continue;
    const int per_node = family.line.per_node();
    const ShapeRow values = interpolation(family.line, xi) * family.shapes.middleRows(element * per_node, 2 * per_node);
    for (std::size_t k = 0; k < family.columns.size(); ++k) {
      add_value(kFamilies[f], values(static_cast<Eigen::Index>(k)), family.columns[k], motion);
    }
  }
  return motion;
}

/// The mass of a section at the four points (+-k_y, +-k_z), k its radii of gyration: its own second moments (S9).
void add_section(const BeamSpecification& beam, double x, double mass, const SectionMotion& motion,
                 std::vector<MassPoint>& points) {
  const double k_y = std::sqrt(beam.second_moment_z / beam.area);
  const double k_z = std::sqrt(beam.second_moment_y / beam.area);
  for (const double y : {-k_y, k_y}) {
    for (const double z : {-k_z, k_z}) {
      const Mat3X twisted = motion.rotation.colwise().cross(Vec3(0.0, y, z)) + motion.translation;
      points.push_back({0.25 * mass, beam.first_end_L + beam.axes * Vec3(x, y, z), beam.axes * twisted});
    }
  }
}

std::vector<MassPoint> make_mass_points(const BeamSpecification& beam, const BeamModes& modes) {
  std::vector<MassPoint> points;
  const double width = beam.length / beam.elements;
  for (int element = 0; element < beam.elements; ++element) {
    for (const GaussPoint& gauss : gauss_points()) {
      const double mass = beam.density * beam.area * width * gauss.weight;
      add_section(beam, width * (element + gauss.xi), mass, in_element(modes, element, gauss.xi), points);
    }
  }
  return points;
}

std::vector<ModalNode> make_nodes(const BeamSpecification& beam, const BeamModes& modes) {
  std::vector<ModalNode> nodes;
  const auto add = [&](std::string name, int node) {
    const SectionMotion motion = at_node(modes, node);
    const Vec3 place(beam.length * node / beam.elements, 0.0, 0.0);
    nodes.push_back({std::move(name), beam.first_end_L + beam.axes * place, beam.axes * motion.translation,
                     beam.axes * motion.rotation});
  };
  for (int node = 0; node <= beam.elements; ++node) add(std::to_string(node), node);
  add("first", 0);
  add("last", beam.elements);
  return nodes;
}

void check(const BeamSpecification& beam) {
  if (beam.elements < 1) {
    throw std::invalid_argument(fmt::format("beam: {} elements; at least 1 is needed", beam.elements));
  }
  if (!(beam.length > 0.0 && beam.area > 0.0 && beam.density > 0.0)) {
    throw std::invalid_argument(
        fmt::format("beam: length {:g} m, area {:g} m2, density {:g} kg/m3; all must be positive", beam.length,
                    beam.area, beam.density));
  }
}

}  // namespace

ModalData make_beam(const BeamSpecification& beam) {
  check(beam);
  BeamModes modes;
  modes.count = static_cast<int>(beam.modes.size());
  ModalData data;
  data.frequencies = VecX::Zero(modes.count);
  for (std::size_t f = 0; f < kFamilies.size(); ++f) {
    modes.families[f] = make_family(beam, kFamilies[f]);
    const FamilyModes& family = modes.families[f];
    for (std::size_t k = 0; k < family.columns.size(); ++k) {
      data.frequencies(family.columns[k]) = family.frequencies(static_cast<Eigen::Index>(k));
    }
  }
  data.stiffness = data.frequencies.cwiseAbs2().asDiagonal();
  data.damping = (2.0 * beam.damping_ratio * data.frequencies).asDiagonal();
  data.nodes = make_nodes(beam, modes);
  data.mass_points = make_mass_points(beam, modes);
  data.G = mass_integrals(data.mass_points, modes.count);
  return data;
}

}  // namespace concord
