#include "common/reading/force_element_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "common/reading/attachment_reader.h"
#include "common/reading/driver_reader.h"
#include "common/reading/force_law_reader.h"
#include "common/reading/model_checks.h"
#include "common/reading/spelling.h"
#include "common/reading/toml_document.h"

namespace concord {

namespace {

LoadAxes read_load_axes(const TableReader& table) {
  static const std::vector<std::string> kNames{"global", "body", "follower"};
  const auto name = table.text("axes");
  if (!name) return LoadAxes::global;
  const auto found = std::find(kNames.begin(), kNames.end(), *name);
  if (found == kNames.end()) {
    table.complain("axes", fmt::format("unknown axes '{}': {}", *name, suggestion(*name, kNames, "axes")));
    return LoadAxes::global;
  }
  return static_cast<LoadAxes>(found - kNames.begin());
}

/// What force elements refer to.
struct Surroundings {
  const std::vector<BodyReading>& bodies;
  const std::vector<RoadReading>& roads;
};

std::optional<Load> read(std::type_identity<Load> /*kind*/, const TableReader& table, const Surroundings& around) {
  if (!table.has("force") && !table.has("torque")) table.complain("exerts nothing: give a 'force' or a 'torque'");
  Load load;
  load.axes = read_load_axes(table);
  load.force = table.vector3("force").value_or(Vec3::Zero());
  load.torque = table.vector3("torque").value_or(Vec3::Zero());
  if (auto law = read_law_or_number(table, "law")) load.law = std::move(*law);
  const auto at = read_attachment(table, around.bodies);
  if (!at) return std::nullopt;
  if (at->body == kGround) table.complain("body", "a load on ground moves nothing: name a moving body");
  load.at = *at;
  return load;
}

/// A line spring has a free length: zero would be a rare wish, and a frequent slip.
void require_free_length(const TableReader& table) {
  if (table.has("free") || (!table.has("stiffness") && !table.has("spring_table"))) return;
  table.complain("missing key 'free': the length [m] at which the spring rests");
}

std::optional<LineSpring> read(std::type_identity<LineSpring> /*kind*/, const TableReader& table,
                               const Surroundings& around) {
  require_free_length(table);
  ForceLaw law = read_force_law(table);
  const auto ends = read_ends(table, around.bodies);
  if (!ends) return std::nullopt;
  return LineSpring{*ends, std::move(law)};
}

std::optional<TurnSpring> read(std::type_identity<TurnSpring> /*kind*/, const TableReader& table,
                               const Surroundings& around) {
  ForceLaw law = read_force_law(table);
  const auto ends = read_ends(table, around.bodies);
  if (!ends) return std::nullopt;
  return TurnSpring{*ends, std::move(law)};
}

/// Six numbers, the diagonal, or six rows of six; symmetric. Zero if missing or after a complaint.
Mat6 read_symmetric(const TableReader& table, std::string_view key) {
  if (!table.has(key)) return Mat6::Zero();
  const toml::array* list = table.node(key)->as_array();
  const bool has_rows = list != nullptr && !list->empty() && list->front().is_array();
  if (!has_rows) {
    const auto diagonal = table.vector(key, 6);
    return diagonal ? Mat6(diagonal->asDiagonal()) : Mat6(Mat6::Zero());
  }
  const auto matrix = table.matrix(key, 6, 6);
  if (!matrix) return Mat6::Zero();
  if (const auto complaint = complaint_about_symmetry(*matrix)) {
    table.complain(key, fmt::format("'{}' must be symmetric, but {}", key, *complaint));
    return Mat6::Zero();
  }
  return *matrix;
}

std::optional<Bushing> read(std::type_identity<Bushing> /*kind*/, const TableReader& table,
                            const Surroundings& around) {
  if (!table.has("stiffness") && !table.has("damping") && !table.has("preload")) {
    table.complain("exerts nothing: give a 'stiffness', a 'damping' or a 'preload'");
  }
  Bushing bushing;
  bushing.stiffness = read_symmetric(table, "stiffness");
  bushing.damping = read_symmetric(table, "damping");
  if (const auto complaint = complaint_about_semidefiniteness(bushing.damping)) {
    table.complain("damping", fmt::format("'damping' must not give energy, but {}", *complaint));
  }
  if (const auto preload = table.vector("preload", 6)) bushing.preload = *preload;
  const auto ends = read_ends(table, around.bodies);
  if (!ends) return std::nullopt;
  bushing.ends = *ends;
  return bushing;
}

/// The road that the tire names; nothing if it is not known or could not be read.
std::shared_ptr<const Road> find_road(const TableReader& table, const std::vector<RoadReading>& roads) {
  const auto name = table.text("road");
  if (!name) return nullptr;
  const FileReading& reading = table.reading();
  std::vector<std::string> names;
  for (const RoadReading& one : roads) {
    if (one.name == reading.name_in_model("road", *name)) return one.road;
    names.push_back(reading.name_in_file("road", one.name));
  }
  table.complain("road", fmt::format("unknown road '{}': {}", *name, suggestion(*name, names, "roads")));
  return nullptr;
}

std::optional<Tire> read(std::type_identity<Tire> /*kind*/, const TableReader& table, const Surroundings& around) {
  const bool complete =
      table.require({"road", "radius", "stiffness", "slip_stiffness", "cornering_stiffness", "friction"});
  Tire tire;
  tire.radius = table.positive_number("radius").value_or(0.0);
  tire.stiffness = table.positive_number("stiffness").value_or(0.0);
  tire.damping = table.number_not_negative("damping").value_or(0.0);
  tire.slip_stiffness = table.number_not_negative("slip_stiffness").value_or(0.0);
  tire.cornering_stiffness = table.number_not_negative("cornering_stiffness").value_or(0.0);
  tire.friction = table.number_not_negative("friction").value_or(0.0);
  tire.speed_scale = table.positive_number("speed_scale").value_or(tire.speed_scale);
  tire.road = find_road(table, around.roads);
  const auto wheel = read_attachment(table, around.bodies);
  if (!complete || !tire.road || !wheel) return std::nullopt;
  if (wheel->body == kGround) table.complain("body", "ground has no tire: it is the road; name a moving body");
  tire.wheel = *wheel;
  return tire;
}

/// A kind of elements: its table, the keys of that, by the quantities that its page states, and who reads it.
struct ElementKind {
  std::string_view key;
  KnownKeys known;
  std::optional<AnyElement> (*read)(const TableReader&, const Surroundings&);
};

/// Adds the keys of each quantity that an element visits it with.
struct KeysOfQuantities {
  KnownKeys& keys;

  template <class Quantity>
  void operator()(const Quantity& quantity) const {
    keys.push_back(quantity.name);
  }
  template <class Law>
  void operator()(const elements::LawOverCoordinate<Law>& /*law*/) const {
    keys = with_force_law(std::move(keys));
  }
};

template <class Kind>
ElementKind element_kind() {
  const Kind any{};
  KnownKeys own{"name"};
  Kind::each_quantity(any, KeysOfQuantities{own});
  KnownKeys keys = Kind::ends_of(any).size() == 2 ? with_ends(std::move(own)) : with_attachment(std::move(own));
  return {Kind::kKey, std::move(keys), [](const TableReader& table, const Surroundings& around) {
            std::optional<Kind> found = read(std::type_identity<Kind>{}, table, around);
            return found ? std::optional<AnyElement>(std::move(*found)) : std::nullopt;
          }};
}

template <class... Kinds>
std::vector<ElementKind> kinds_of(std::type_identity<std::variant<Kinds...>> /*all*/) {
  return {element_kind<Kinds>()...};
}

const std::vector<ElementKind>& element_kinds() {
  static const std::vector<ElementKind> kKinds = kinds_of(std::type_identity<AnyElement>{});
  return kKinds;
}

void read_elements_of(const ElementKind& kind, const TableReader& document, const Surroundings& around,
                      std::vector<ForceElement>& elements) {
  for (const toml::table* found : document.tables(kind.key)) {
    const TableReader table(*found, title_with_name(*found, kind.key), kind.known, document.reading());
    ForceElement element;
    element.name = table.name();
    element.where = table.where();
    if (auto what = kind.read(table, around)) {
      element.what = std::move(*what);
      elements.push_back(std::move(element));
    }
  }
}

}  // namespace

const KnownKeys& force_element_keys() { return element_keys(); }

std::vector<ForceElement> read_force_elements(const TableReader& document, const std::vector<BodyReading>& bodies,
                                              const std::vector<RoadReading>& roads) {
  std::vector<ForceElement> elements;
  for (const ElementKind& kind : element_kinds()) read_elements_of(kind, document, {bodies, roads}, elements);
  std::stable_sort(elements.begin(), elements.end(), [](const ForceElement& a, const ForceElement& b) {
    return std::pair(a.where.line, a.where.column) < std::pair(b.where.line, b.where.column);
  });
  return elements;
}

}  // namespace concord
