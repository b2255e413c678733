#pragma once

#include <Eigen/Sparse>
#include <array>
#include <vector>

#include "common/flexible/beam.h"

/// One decoupled family of a beam's motions as finite elements on a line: bending in a plane, torsion, or stretch.
namespace concord::beams {

using SparseMatrix = Eigen::SparseMatrix<double>;
using ShapeRow = Eigen::RowVectorXd;

inline constexpr std::array kFamilies{BeamFamily::bending_xy, BeamFamily::bending_xz, BeamFamily::torsion,
                                      BeamFamily::axial};

/// "bending_xy", "torsion" ...
const char* name_of(BeamFamily family);

/// Gauss-Legendre quadrature on [0, 1] with four points: exact up to degree 7, hence for products of two cubics.
struct GaussPoint {
  double xi;
  double weight;
};
std::array<GaussPoint, 4> gauss_points();

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

/// The line of a family with the beam's section and supports. Throws std::invalid_argument if its stiffness or inertia
/// is not positive.
Line make_line(const BeamSpecification& beam, BeamFamily family);

/// Displacement (or twist) at xi in [0, 1] of an element, from the numbers at its two nodes.
ShapeRow interpolation(const Line& line, double xi);

/// Strain at xi: curvature, twist per length or stretch.
ShapeRow strain(const Line& line, double xi);

/// integral of factor * rows(x)^T rows(x) over the line, for `rows` one of the two functions above (S6).
SparseMatrix assemble(const Line& line, ShapeRow (*rows)(const Line&, double), double factor);

/// The same integral for the columns of `shapes`. Strains are formed first: far less round-off than shapes^T K shapes.
MatX reduce(const Line& line, ShapeRow (*rows)(const Line&, double), double factor, const MatX& shapes);

/// The shape that a unit displacement of the free end gives to the line, its first end clamped: number 1 displacement
/// or twist, number 2 slope. Exact: no load between the ends leaves a cubic, or a straight line (S7).
VecX static_shape(const Line& line, int number);

}  // namespace concord::beams
