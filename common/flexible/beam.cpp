#include "common/flexible/beam.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/flexible/beam_line.h"
#include "common/flexible/beam_modes.h"

namespace concord {

namespace {

using beams::FamilyModes;
using beams::GaussPoint;
using beams::kFamilies;
using beams::ShapeRow;

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
    const ShapeRow values =
        beams::interpolation(family.line, xi) * family.shapes.middleRows(element * per_node, 2 * per_node);
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
    for (const GaussPoint& gauss : beams::gauss_points()) {
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
    modes.families[f] = beams::make_family(beam, kFamilies[f]);
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
  data.beam = std::make_shared<const BeamSpecification>(beam);
  return data;
}

}  // namespace concord
