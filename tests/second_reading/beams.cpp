#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "common/flexible/beam.h"
#include "tests/second_reading/bodies.h"
#include "tests/second_reading/places.h"

namespace concord::second_reading {

namespace {

struct StatedSection {
  double area, second_moment_y, second_moment_z, torsion_constant;
};

/// As the page of bodies gives it for a rectangle with the sides a >= b.
double torsion_of_rectangle(double one_side, double other_side) {
  const double a = std::max(one_side, other_side);
  const double b = std::min(one_side, other_side);
  return a * std::pow(b, 3) * (1.0 / 3.0 - 0.21 * b / a * (1.0 - std::pow(b / a, 4) / 12.0));
}

StatedSection section_of(const StatedTable& section) {
  if (const auto outer = section.number("diameter")) {
    const double inner = section.number("inner_diameter").value_or(0.0);
    const double area = std::numbers::pi / 4.0 * (*outer * *outer - inner * inner);
    const double moment = area / 16.0 * (*outer * *outer + inner * inner);
    return {area, moment, moment, 2.0 * moment};
  }
  if (const auto width_y = section.number("width_y")) {
    const double y = *width_y;
    const double z = section.number("width_z").value();
    return {y * z, y * z * z * z / 12.0, z * y * y * y / 12.0, torsion_of_rectangle(y, z)};
  }
  return {section.number("area").value(), section.number("second_moment_y").value(),
          section.number("second_moment_z").value(), section.number("torsion_constant").value()};
}

void hold_section(const BeamSpecification& beam, const StatedTable& table) {
  const auto section = table.table("section");
  if (!section) throw std::runtime_error("no section");
  const StatedSection stated = section_of(*section);
  Ledger& ledger = table.ledger();
  ledger.number(section->entry("area"), beam.area, stated.area);
  ledger.number(section->entry("second_moment_y"), beam.second_moment_y, stated.second_moment_y);
  ledger.number(section->entry("second_moment_z"), beam.second_moment_z, stated.second_moment_z);
  ledger.number(section->entry("torsion_constant"), beam.torsion_constant, stated.torsion_constant);
}

std::string name_of(BeamSupport support) {
  switch (support) {
    case BeamSupport::simply_supported:
      return "simply_supported";
    case BeamSupport::cantilever:
      return "cantilever";
    case BeamSupport::free_free:
      return "free_free";
    case BeamSupport::craig_bampton:
      return "craig_bampton";
  }
  return "";
}

using NamedFamilies = std::vector<std::pair<std::string, BeamFamily>>;
const NamedFamilies& families() {
  static const NamedFamilies all{{"bending_xy", BeamFamily::bending_xy},
                                 {"bending_xz", BeamFamily::bending_xz},
                                 {"torsion", BeamFamily::torsion},
                                 {"axial", BeamFamily::axial}};
  return all;
}

/// The numbers of the chosen modes of a family: as lists of them, in their order.
void hold_chosen_modes(const BeamSpecification& beam, const StatedTable& table, const std::string& key) {
  const auto chosen = table.table(key);
  const bool is_static = key == "static_modes";
  for (const auto& [name, family] : families()) {
    std::vector<double> read;
    for (const BeamMode& mode : beam.modes) {
      if (mode.family == family && mode.is_static == is_static) read.push_back(mode.number);
    }
    const auto stated = chosen ? chosen->numbers(name) : std::nullopt;
    const Entry entry = chosen ? chosen->entry(name) : table.entry(key);
    table.ledger().numbers(entry, column_of(read), column_of(stated.value_or(std::vector<double>())));
  }
}

/// Modal coordinates stand in the order of the families, the static ones last.
void hold_order_of_modes(const BeamSpecification& beam, const StatedTable& table) {
  const auto place = [](const BeamMode& mode) { return (mode.is_static ? 4 : 0) + static_cast<int>(mode.family); };
  bool rises = true;
  for (std::size_t k = 1; k < beam.modes.size(); ++k) rises = rises && place(beam.modes[k - 1]) <= place(beam.modes[k]);
  table.ledger().word(table.entry("modes"), rises ? "in order" : "not in order", "in order");
}

}  // namespace

void hold_beam(const ModalData& modal, const StatedTable& table) {
  const BeamSpecification& beam = *modal.beam;
  Ledger& ledger = table.ledger();
  table.hold_vector("first_end", beam.first_end_L);
  hold_frame(ledger, table.entry("frame"), beam.axes, frame_of(table).value_or(StatedFrame{}));
  table.hold_number("length", beam.length);
  table.hold_number("elements", beam.elements, 20);
  hold_section(beam, table);
  table.hold_number("youngs_modulus", beam.youngs_modulus);
  table.hold_number("density", beam.density);
  if (const auto ratio = table.number("poissons_ratio")) {
    ledger.number(table.entry("poissons_ratio"), beam.shear_modulus,
                  table.number("youngs_modulus").value() / (2.0 * (1.0 + *ratio)));
  } else {
    table.hold_number("shear_modulus", beam.shear_modulus, 0.0);
  }
  table.hold_word("support", name_of(beam.support), "");
  table.hold_number("damping_ratio", beam.damping_ratio, 0.0);
  hold_chosen_modes(beam, table, "modes");
  hold_chosen_modes(beam, table, "static_modes");
  hold_order_of_modes(beam, table);
  ledger.number(table.entry("modes"), modal.n_modes(), static_cast<double>(beam.modes.size()));
}

}  // namespace concord::second_reading
