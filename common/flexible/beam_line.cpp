#include "common/flexible/beam_line.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace concord::beams {

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

ShapeRow interpolation(const Line& line, double xi) {
  if (!line.bends) return ShapeRow{{1.0 - xi, xi}};
  const double back = 1.0 - xi;
  return ShapeRow{{back * back * (1.0 + 2.0 * xi), line.width * xi * back * back, xi * xi * (3.0 - 2.0 * xi),
                   -line.width * xi * xi * back}};
}

ShapeRow strain(const Line& line, double xi) {
  const double h = line.width;
  if (!line.bends) return ShapeRow{{-1.0 / h, 1.0 / h}};
  return ShapeRow{
      {(12.0 * xi - 6.0) / (h * h), (6.0 * xi - 4.0) / h, (6.0 - 12.0 * xi) / (h * h), (6.0 * xi - 2.0) / h}};
}

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

namespace {

bool is_bending(BeamFamily family) { return family == BeamFamily::bending_xy || family == BeamFamily::bending_xz; }

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

}  // namespace

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

}  // namespace concord::beams
