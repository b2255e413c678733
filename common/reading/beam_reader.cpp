#include "common/reading/beam_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "common/reading/magnitude.h"
#include "common/reading/orientation_reader.h"
#include "common/reading/spelling.h"

namespace concord {

namespace {

constexpr int kMostElements = 10000;
/// A higher mode costs more than it is worth; so do many modes of many elements, whose integrals are formed.
constexpr double kHighestMode = 200.0;
constexpr double kMostWork = 2e7;

struct FamilyWord {
  std::string_view name;
  BeamFamily family;
};
constexpr std::array<FamilyWord, 4> kFamilyWords{{{"bending_xy", BeamFamily::bending_xy},
                                                  {"bending_xz", BeamFamily::bending_xz},
                                                  {"torsion", BeamFamily::torsion},
                                                  {"axial", BeamFamily::axial}}};

struct SupportWord {
  std::string_view name;
  BeamSupport support;
};
constexpr std::array<SupportWord, 4> kSupportWords{{{"simply_supported", BeamSupport::simply_supported},
                                                    {"cantilever", BeamSupport::cantilever},
                                                    {"free_free", BeamSupport::free_free},
                                                    {"craig_bampton", BeamSupport::craig_bampton}}};

struct Section {
  double area = 0.0;
  double second_moment_y = 0.0;
  double second_moment_z = 0.0;
  double torsion_constant = 0.0;
};

/// A round bar, or a tube.
std::optional<Section> read_round(const TableReader& table) {
  const auto outer = table.positive_number("diameter");
  const auto inner = table.has("inner_diameter") ? table.number_not_negative("inner_diameter") : 0.0;
  if (!outer || !inner) return std::nullopt;
  if (*inner >= *outer) {
    table.complain("inner_diameter",
                   fmt::format("'inner_diameter' must be less than 'diameter' = {} m, found {} m", *outer, *inner));
    return std::nullopt;
  }
  const double moment = std::numbers::pi / 64.0 * (std::pow(*outer, 4) - std::pow(*inner, 4));
  return Section{.area = std::numbers::pi / 4.0 * (*outer * *outer - *inner * *inner),
                 .second_moment_y = moment,
                 .second_moment_z = moment,
                 .torsion_constant = 2.0 * moment};
}

/// A rectangle. Torsion constant: a b^3 (1/3 - 0.21 b/a (1 - b^4 / (12 a^4))), a >= b, within 0.5 % of Saint-Venant's
/// series (Roark's Formulas for Stress and Strain, table of torsion constants).
std::optional<Section> read_rectangle(const TableReader& table) {
  if (!table.require({"width_y", "width_z"})) return std::nullopt;
  const auto y = table.positive_number("width_y");
  const auto z = table.positive_number("width_z");
  if (!y || !z) return std::nullopt;
  const double a = std::max(*y, *z);
  const double b = std::min(*y, *z);
  return Section{
      .area = *y * *z,
      .second_moment_y = *y * std::pow(*z, 3) / 12.0,
      .second_moment_z = *z * std::pow(*y, 3) / 12.0,
      .torsion_constant = a * std::pow(b, 3) * (1.0 / 3.0 - 0.21 * b / a * (1.0 - std::pow(b / a, 4) / 12.0))};
}

std::optional<Section> read_properties(const TableReader& table) {
  if (!table.require({"area", "second_moment_y", "second_moment_z", "torsion_constant"})) return std::nullopt;
  const auto area = table.positive_number("area");
  const auto moment_y = table.positive_number("second_moment_y");
  const auto moment_z = table.positive_number("second_moment_z");
  const auto torsion = table.positive_number("torsion_constant");
  if (!area || !moment_y || !moment_z || !torsion) return std::nullopt;
  return Section{*area, *moment_y, *moment_z, *torsion};
}

std::optional<Section> read_section(const TableReader& beam) {
  const toml::table* found = beam.table("section");
  if (found == nullptr) return std::nullopt;
  struct Form {
    std::string_view key;
    KnownKeys keys;
    std::optional<Section> (*read)(const TableReader&);
  };
  static const std::array<Form, 3> kForms{
      Form{"diameter", {"diameter", "inner_diameter"}, read_round},
      Form{"width_y", {"width_y", "width_z"}, read_rectangle},
      Form{"area", {"area", "second_moment_y", "second_moment_z", "torsion_constant"}, read_properties}};
  for (const Form& form : kForms) {
    if (!found->contains(form.key)) continue;
    return form.read(TableReader(*found, beam.title() + ", section", form.keys, beam.reading()));
  }
  beam.complain("section",
                "a section is { diameter }, { diameter, inner_diameter }, { width_y, width_z }, or { area, "
                "second_moment_y, second_moment_z, torsion_constant }");
  return std::nullopt;
}

/// Complains if what follows from sizes of the beam has no usable size; true if all is well.
bool check_sizes(const TableReader& reader, const BeamSpecification& beam) {
  struct Size {
    std::string_view key;
    std::string_view name;
    double value;
  };
  const double L = beam.length;
  const double width = L / beam.elements;
  const double mass = beam.density * beam.area * L;
  const double E = beam.youngs_modulus;
  const Size sizes[] = {{"section", "area", beam.area},
                        {"section", "second moment of area about y", beam.second_moment_y},
                        {"section", "second moment of area about z", beam.second_moment_z},
                        {"section", "torsion constant", beam.torsion_constant},
                        {"density", "mass", mass},
                        {"density", "mass times the square of its length", mass * L * L},
                        {"density", "polar moment of inertia", beam.density * L * beam.second_moment_y},
                        {"density", "polar moment of inertia", beam.density * L * beam.second_moment_z},
                        {"youngs_modulus", "axial stiffness", E * beam.area / width},
                        {"youngs_modulus", "bending stiffness", E * beam.second_moment_y / width / width / width},
                        {"youngs_modulus", "bending stiffness", E * beam.second_moment_z / width / width / width},
                        {"youngs_modulus", "bending stiffness", E * beam.second_moment_y / L / L / L},
                        {"youngs_modulus", "bending stiffness", E * beam.second_moment_z / L / L / L},
                        {"youngs_modulus", "square of a frequency", E / beam.density / L / L},
                        {"youngs_modulus", "torsional stiffness", beam.shear_modulus * beam.torsion_constant / width}};
  for (const Size& size : sizes) {
    if (has_usable_size(size.value)) continue;
    reader.complain(size.key, fmt::format("the {} that follows {}", size.name, complaint_about_size(size.value)));
    return false;
  }
  return true;
}

/// Modes of `modes` or `static_modes`, families in the order of BeamFamily.
std::optional<std::vector<BeamMode>> read_modes(const TableReader& beam, std::string_view key, bool is_static) {
  std::vector<BeamMode> modes;
  if (!beam.has(key)) return modes;
  const toml::table* found = beam.table(key);
  if (found == nullptr) return std::nullopt;
  KnownKeys names;
  for (const FamilyWord& word : kFamilyWords) names.push_back(word.name);
  const TableReader table(*found, fmt::format("{}, {}", beam.title(), key), names, beam.reading());
  bool readable = true;
  for (const auto& [name, family] : kFamilyWords) {
    if (!table.has(name)) continue;
    const auto numbers = table.numbers(name);
    readable = readable && numbers.has_value();
    for (const double number : numbers.value_or(std::vector<double>{})) {
      if (number != std::floor(number) || number < 1.0) {
        table.complain(name, fmt::format("modes are numbered 1, 2, 3, ...; found {}", number));
        readable = false;
      } else if (number > kHighestMode) {
        table.complain(name, fmt::format("modes are numbered up to {}; found {}", kHighestMode, number));
        readable = false;
      } else {
        modes.push_back({family, static_cast<int>(number), is_static});
      }
    }
  }
  if (!readable) return std::nullopt;
  return modes;
}

std::optional<BeamSupport> read_support(const TableReader& beam) {
  const auto name = beam.text("support");
  if (!name) return std::nullopt;
  std::vector<std::string> names;
  for (const SupportWord& word : kSupportWords) {
    if (word.name == *name) return word.support;
    names.emplace_back(word.name);
  }
  beam.complain("support", fmt::format("unknown support '{}': {}", *name, suggestion(*name, names, "supports")));
  return std::nullopt;
}

/// Shear modulus from `shear_modulus` or from Poisson's ratio; 0 if neither is said (torsion modes need it).
std::optional<double> read_shear_modulus(const TableReader& beam, double youngs_modulus) {
  if (beam.has("shear_modulus") && beam.has("poissons_ratio")) {
    beam.require_one_of({"shear_modulus", "poissons_ratio"});
    return std::nullopt;
  }
  if (beam.has("shear_modulus")) return beam.positive_number("shear_modulus");
  if (!beam.has("poissons_ratio")) return 0.0;
  const auto ratio = beam.number("poissons_ratio");
  if (!ratio) return std::nullopt;
  if (*ratio <= -1.0 || *ratio > 0.5) {
    beam.complain("poissons_ratio", fmt::format("'poissons_ratio' must be above -1 and at most 0.5, found {}", *ratio));
    return std::nullopt;
  }
  return youngs_modulus / (2.0 * (1.0 + *ratio));
}

/// All but its modes.
BeamSpecification read_specification(const TableReader& reader) {
  BeamSpecification beam;
  beam.first_end_L = reader.vector3("first_end").value_or(beam.first_end_L);
  beam.axes = read_orientation(reader).value_or(beam.axes);
  beam.length = reader.positive_number("length").value_or(beam.length);
  beam.elements = reader.count("elements", 1, kMostElements).value_or(beam.elements);
  beam.youngs_modulus = reader.positive_number("youngs_modulus").value_or(1.0);
  beam.shear_modulus = read_shear_modulus(reader, beam.youngs_modulus).value_or(0.0);
  beam.density = reader.positive_number("density").value_or(1.0);
  beam.support = read_support(reader).value_or(beam.support);
  beam.damping_ratio = reader.number_not_negative("damping_ratio").value_or(0.0);
  const Section section = read_section(reader).value_or(Section{});
  beam.area = section.area;
  beam.second_moment_y = section.second_moment_y;
  beam.second_moment_z = section.second_moment_z;
  beam.torsion_constant = section.torsion_constant;
  return beam;
}

/// A beam without modes is complained of if nothing else is wrong: there were `complaints_before` before it was read.
void read_chosen_modes(const TableReader& reader, std::size_t complaints_before, BeamSpecification& beam) {
  const auto modes = read_modes(reader, "modes", false);
  const auto static_modes = read_modes(reader, "static_modes", true);
  if (modes) beam.modes = *modes;
  if (static_modes) beam.modes.insert(beam.modes.end(), static_modes->begin(), static_modes->end());
  if (modes && static_modes && beam.modes.empty() && reader.reading().complaints.size() == complaints_before) {
    reader.complain("a beam needs modes: give 'modes' or 'static_modes', or make the body rigid");
  }
}

void check_work(const TableReader& reader, const BeamSpecification& beam) {
  const double work = beam.elements * std::pow(static_cast<double>(beam.modes.size()), 2);
  if (work > kMostWork) {
    reader.complain(
        "elements",
        fmt::format("elements times the square of the number of modes, {:g}, must be at most {:g}", work, kMostWork));
  }
}

}  // namespace

std::optional<ModalData> read_beam(const toml::table& table, const std::string& body, FileReading& reading) {
  const TableReader reader(
      table, body + ", beam",
      with_orientation({"first_end", "length", "elements", "section", "youngs_modulus", "shear_modulus",
                        "poissons_ratio", "density", "support", "modes", "static_modes", "damping_ratio"}),
      reading);
  const std::size_t complaints_before = reading.complaints.size();
  reader.require({"length", "section", "youngs_modulus", "density", "support"});
  BeamSpecification beam = read_specification(reader);
  read_chosen_modes(reader, complaints_before, beam);
  check_work(reader, beam);
  // The beam is made only of what was read without a fault.
  if (reading.complaints.size() != complaints_before) return std::nullopt;
  if (!check_sizes(reader, beam)) return std::nullopt;
  const SourceLocation modes_place = reader.where(reader.has("modes") ? "modes" : "static_modes");
  try {
    ModalData data = make_beam(beam);
    if (are_bounded(data.G) && are_bounded(data.stiffness) && are_bounded(data.damping)) return data;
    reader.complain(fmt::format("the modal matrices go beyond {}", kLargestSize));
  } catch (const std::invalid_argument& error) {
    reading.complain(modes_place, fmt::format("{}, {}", body, error.what()));
  } catch (const std::runtime_error& error) {
    reading.complain(modes_place, fmt::format("{}, {}", body, error.what()));
  }
  return std::nullopt;
}

}  // namespace concord
