#include "compare/random_machines/flexible.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "common/flexible/modal_data.h"
#include "common/reading/modes_file.h"

namespace concord::compare::fuzz {

namespace {

/// A support and the modes that are asked of it: one to three of low frequency.
struct Choice {
  std::string support;
  std::string modes;
  std::string static_modes;  // may be empty
  int count = 0;
};

Choice draw_choice(Random& random) {
  switch (random.below(5)) {
    case 0:
      return {"simply_supported", "{ bending_xy = [1, 2] }", "", 2};
    case 1:
      return {"cantilever", "{ bending_xz = [1], bending_xy = [1] }", "", 2};
    case 2:
      return {"free_free", "{ bending_xy = [1], bending_xz = [1] }", "", 2};
    case 3:
      return {"craig_bampton", "{ bending_xy = [1] }", "{ bending_xy = [1, 2] }", 3};
    default:
      return {"cantilever", "{ bending_xy = [1], torsion = [1] }", "", 2};
  }
}

/// Second moments [m4] and area [m2] of the section, its table, for a beam of this thickness.
struct Section {
  double area = 0.0;
  double smallest_moment = 0.0;
  std::string table;
};

Section draw_section(double thickness, Random& random) {
  const double w = thickness * random.between(0.7, 1.3);
  switch (random.below(4)) {
    case 0:
      return {std::numbers::pi * w * w / 4.0, std::numbers::pi * std::pow(w, 4) / 64.0,
              fmt::format("{{ diameter = {} }}", number_text(w))};
    case 1: {
      const double inner = 0.6 * w;
      return {std::numbers::pi * (w * w - inner * inner) / 4.0,
              std::numbers::pi * (std::pow(w, 4) - std::pow(inner, 4)) / 64.0,
              fmt::format("{{ diameter = {}, inner_diameter = {} }}", number_text(w), number_text(inner))};
    }
    case 2: {
      const double area = w * w;
      const double moment = std::pow(w, 4) / 12.0;
      return {
          area, moment,
          fmt::format("{{ area = {}, second_moment_y = {}, second_moment_z = {}, torsion_constant = {} }}",
                      number_text(area), number_text(1.4 * moment), number_text(moment), number_text(0.8 * moment))};
    }
    default: {
      const double other = w * random.between(1.0, 2.0);
      return {w * other, other * w * w * w / 12.0,
              fmt::format("{{ width_y = {}, width_z = {} }}", number_text(other), number_text(w))};
    }
  }
}

}  // namespace

Flexible draw_beam(double mass, const Units& units, bool is_aligned, Random& random) {
  const double length = units.length * random.between(0.6, 1.5);
  const Choice choice = draw_choice(random);
  const Section section = draw_section(0.1 * length, random);
  const double density = mass / (section.area * length);
  // The lowest frequency of a cantilever is 3.516 / length^2 sqrt(E I / (rho A)).
  const double frequency = units.stiffer * random.log_between(3.0, 30.0) / units.time;
  const double modulus =
      std::pow(frequency * length * length / 3.516, 2) * density * section.area / section.smallest_moment;
  const int elements = 4 + 2 * random.below(3);
  const Vec3 first_end = is_aligned ? Vec3(Vec3::Zero()) : random.vector(0.3 * units.length);
  const Vec4 axes = is_aligned ? Vec4(Vec4::Unit(0)) : random.rotation();
  Flexible flexible;
  flexible.beam = {{"length", number_text(length), true},
                   {"section", section.table, true},
                   {"youngs_modulus", number_text(modulus), true},
                   {"poissons_ratio", "0.3"},
                   {"density", number_text(density), true},
                   {"support", fmt::format("\"{}\"", choice.support), true},
                   {"modes", choice.modes, true},
                   {"elements", fmt::format("{}", elements), true}};
  if (!choice.static_modes.empty()) flexible.beam.push_back({"static_modes", choice.static_modes, true});
  if (!is_aligned) {
    flexible.beam.push_back({"first_end", list_text(first_end), true});
    flexible.beam.push_back({"euler_parameters", list_text(axes), true});
  }
  if (random.chance(0.5))
    flexible.beam.push_back({"damping_ratio", number_text(units.damped * random.between(0.005, 0.1))});
  const Vec3 x = rotation_of(axes).col(0);
  for (int k = 0; k <= elements; ++k) {
    flexible.node_names.push_back(fmt::format("{}", k));
    flexible.nodes.emplace_back(first_end + x * (length * k / elements));
  }
  flexible.a = VecX::Zero(choice.count);
  flexible.adot = VecX::Zero(choice.count);
  return flexible;
}

Flexible draw_modes_file(double mass, const Units& units, Random& random) {
  const int modes = 1 + random.below(3);
  const int points = 6 + random.below(4);
  ModalData data;
  const auto columns = [&](double size) {
    Mat3X all(3, modes);
    for (int c = 0; c < modes; ++c) all.col(c) = random.vector(size);
    return all;
  };
  // Modes of about unit modal mass.
  const double shape = 1.0 / std::sqrt(mass);
  for (int k = 0; k < points; ++k) {
    data.mass_points.push_back(
        {mass / points * random.between(0.5, 1.5), random.vector(0.5 * units.length), columns(shape)});
  }
  data.G = mass_integrals(data.mass_points, modes);
  data.stiffness = MatX::Zero(modes, modes);
  data.damping = MatX::Zero(modes, modes);
  for (int c = 0; c < modes; ++c) {
    const double frequency = units.stiffer * random.log_between(3.0, 30.0) / units.time;
    const double modal_mass =
        data.G(4 + 3 * c, 4 + 3 * c) + data.G(5 + 3 * c, 5 + 3 * c) + data.G(6 + 3 * c, 6 + 3 * c);
    data.stiffness(c, c) = frequency * frequency * modal_mass;
    if (random.chance(0.5))
      data.damping(c, c) = 2.0 * units.damped * random.between(0.005, 0.1) * frequency * modal_mass;
  }
  Flexible flexible;
  for (int k = 0; k < 3; ++k) {
    ModalNode node{fmt::format("node{}", k), random.vector(0.5 * units.length), columns(shape),
                   columns(shape / units.length)};
    flexible.node_names.push_back(node.name);
    flexible.nodes.push_back(node.s0_L);
    data.nodes.push_back(std::move(node));
  }
  flexible.modes_file = format_modes(data, random.chance(0.5) ? InertiaForm::mass_points : InertiaForm::integrals);
  flexible.a = VecX::Zero(modes);
  flexible.adot = VecX::Zero(modes);
  return flexible;
}

}  // namespace concord::compare::fuzz
