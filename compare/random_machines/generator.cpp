#include "compare/random_machines/generator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/joints/catalogue.h"
#include "common/joints/named_coordinates.h"
#include "compare/joint_check/poses.h"
#include "compare/random_machines/elements.h"
#include "compare/random_machines/laws.h"
#include "compare/random_machines/part_drawing.h"
#include "compare/random_machines/placing.h"
#include "compare/random_machines/random.h"
#include "compare/random_machines/recipe.h"

namespace concord::compare::fuzz {

namespace {

constexpr std::array kMixed{Style::generic, Style::loops,    Style::ordinary,  Style::forces,
                            Style::generic, Style::flexible, Style::redundant, Style::wide};

class Drawing {
 public:
  Drawing(std::uint64_t seed, std::uint64_t number, Style style)
      : random_(seed, number), number_(number), choice_(random_.bits()), recipe_(draw_recipe(style, random_)) {}

  Machine draw() {
    draw_units();
    draw_ground();
    const int most_bodies = recipe_.bodies;
    for (int i = 1; i <= most_bodies; ++i) add_body(i);
    for (int k = 0; k < recipe_.loops; ++k) add_loop();
    add_couplings();
    for (int k = 0; k < recipe_.elements; ++k) add_element();
    name_cut_joint();
    finish();
    return std::move(machine_);
  }

 private:
  void draw_units() {
    const bool wide = recipe_.is_wide;
    units_.length = wide ? random_.log_between(1e-3, 1e3) : random_.log_between(0.1, 2.0);
    units_.mass = wide ? random_.log_between(1e-5, 1e5) : random_.log_between(0.1, 20.0);
    const double g = random_.chance(0.1) ? random_.between(0.0, 3.0) : 9.81;
    units_.time = std::sqrt(units_.length / std::max(g, 1.0));
    if (recipe_.is_aligned) units_.length = rounded(units_.length);
    machine_.name = fmt::format("fuzz_{}", number_);
    machine_.length = units_.length;
    machine_.until = rounded(units_.time * random_.between(0.1, 0.3));
    machine_.is_redundant = recipe_.has_twin || recipe_.is_planar;
    machine_.is_regular = !recipe_.is_aligned;
    if (recipe_.is_aligned) {
      machine_.gravity = -9.81 * Vec3::Unit(1 + random_.below(2));
    } else {
      machine_.gravity = g * rotation_of(random_.rotation()).col(0);
    }
  }

  void draw_ground() {
    machine_.bodies.emplace_back();
    machine_.bodies.front().name = "ground";
  }

  void add_body(int i) {
    machine_.bodies.push_back(parts_.draw_body(i));
    const auto& all = joints::catalogue();
    // The first joint walks along the catalogue, so that no type is left out for long.
    const bool takes_turn = i == 1 && !recipe_.is_planar;
    const joints::JointType* type = takes_turn ? all[number_ % all.size()] : parts_.draw_type();
    JointPlan joint = parts_.draw_joint(type, machine_.joints.size() + 1);
    const int inner = random_.chance(0.6) ? i - 1 : random_.below(i);
    const bool is_reversed = random_.chance(0.3);
    const End inner_end = draw_end_on(inner);
    const End outer_end = draw_end_on(i);
    joint.ends = is_reversed ? std::array{outer_end, inner_end} : std::array{inner_end, outer_end};
    add_to_coordinates(joint);
    machine_.joints.push_back(std::move(joint));
    if (!place(machine_, choice_).ok()) undo_laws();
  }

  End draw_end_on(int i) { return parts_.draw_end(i, machine_.bodies[i]); }

  /// Drivers and springs.
  void add_to_coordinates(JointPlan& joint) {
    for (const joint_check::Coordinate& one : joint_check::coordinates_of(*joint.type)) {
      CoordinatePlan& plan = joint.coordinates[named_place(*joint.type, one)];
      const double reach = one.is_turn ? 1.0 : units_.length;
      const Units units = draw_units_between(joint.ends);
      const double force = units.force() * (one.is_turn ? units.length : 1.0);
      if (random_.chance(recipe_.driven)) {
        LawPlan law = draw_law(joint.q(one.q), reach, units_.time, random_);
        plan.law = law.law;
        plan.drive = law.entries;
      }
      if (random_.chance(recipe_.sprung)) {
        plan.spring = draw_force_law(joint.q(one.q), reach, force, units, false, random_);
      }
    }
  }

  /// Units of what acts between two ends: forces are of the size of the lighter body's inertia forces, so that nothing
  /// is hurled away.
  [[nodiscard]] Units draw_units_between(const std::array<End, 2>& ends) {
    Units units = units_;
    units.mass = std::numeric_limits<double>::max();
    for (const End& end : ends) {
      if (end.body != 0) units.mass = std::min(units.mass, machine_.bodies[end.body].mass);
    }
    if (recipe_.is_stiff) {
      units.stiffer = random_.log_between(1.0, 1e3);
      units.damped = random_.log_between(1.0, 1e3);
    }
    return units;
  }

  static std::size_t named_place(const joints::JointType& type, const joint_check::Coordinate& one) {
    const std::vector<NamedCoordinate> named = named_coordinates(type);
    const auto found = std::find_if(named.begin(), named.end(), [&](const NamedCoordinate& name) {
      return name.word == one.word && name.component == one.component;
    });
    return static_cast<std::size_t>(found - named.begin());
  }

  void undo_laws() {
    for (CoordinatePlan& plan : machine_.joints.back().coordinates) {
      plan.drive.clear();
      plan.law.reset();
    }
  }

  /// A joint that closes a loop, of types drawn until one fits; none if none does.
  void add_loop() {
    constexpr int kMostTries = 12;
    for (int tries = 0; tries < kMostTries; ++tries) {
      machine_.joints.push_back(recipe_.has_twin ? draw_twin() : draw_closing_joint(tries));
      if (moves_enough() && place(machine_, choice_).ok()) return;
      machine_.joints.pop_back();
    }
    machine_.is_redundant = machine_.is_redundant && recipe_.is_planar;
  }

  /// The first one in turn of the catalogue, then any: types of which fewer fit get their chance.
  JointPlan draw_closing_joint(int tries) {
    const auto& all = joints::catalogue();
    const bool takes_turn = tries < 3 && !recipe_.is_planar;
    JointPlan joint = parts_.draw_joint(takes_turn ? all[(number_ / 3) % all.size()] : parts_.draw_type(),
                                        machine_.joints.size() + 1);
    joint.closes_loop = true;
    const int count = static_cast<int>(machine_.bodies.size());
    const int one = recipe_.is_planar ? 0 : random_.below(count);
    const int other = recipe_.is_planar ? count - 1 : (one + 1 + random_.below(count - 1)) % count;
    joint.ends[0] = draw_end_on(one);
    joint.ends[1] = draw_end_on(other);
    return joint;
  }

  /// The same joint a second time, further along an axis along which that changes nothing.
  JointPlan draw_twin() {
    const int k = random_.below(static_cast<int>(machine_.joints.size()));
    JointPlan twin = machine_.joints[k];
    twin.name = fmt::format("joint{}", machine_.joints.size() + 1);
    twin.closes_loop = true;
    for (CoordinatePlan& plan : twin.coordinates) plan = {};
    const Vec3 shift = units_.length * random_.between(0.2, 0.8) * Vec3::UnitZ();
    End& parent = twin.ends[0];
    parent.point += rotation_of(parent.p) * shift;
    return twin;
  }

  /// Of a twin: whether all its words go along or about z, so that the two joints move together.
  static bool moves_along_z(const joints::JointType& type) {
    return std::all_of(type.permits.begin(), type.permits.end(), [](const joints::Permit& word) {
      const joints::StatedCoordinates all = stated_coordinates(word);
      return all.size() > 0 && std::all_of(all.begin(), all.end(), [](const auto& one) { return one.axis == Axis::z; });
    });
  }

  /// A machine that nothing can move is drawn now and then only.
  [[nodiscard]] bool moves_enough() {
    const JointPlan& last = machine_.joints.back();
    if (recipe_.has_twin) return moves_along_z(*last.type) && !is_driven(last);
    int freedom = 0;
    for (const JointPlan& joint : machine_.joints)
      freedom += joint.closes_loop ? joint.type->n_u() - 6 : joint.type->n_u();
    return recipe_.is_planar || freedom > 0 || (freedom == 0 && random_.chance(0.1));
  }

  static bool is_driven(const JointPlan& joint) {
    return std::any_of(joint.coordinates.begin(), joint.coordinates.end(),
                       [](const CoordinatePlan& plan) { return plan.law.has_value(); });
  }

  void add_couplings() {
    if (!random_.chance(recipe_.coupled)) return;
    std::vector<TermPlan> all;
    for (int k = 0; k < static_cast<int>(machine_.joints.size()); ++k) {
      const joints::JointType& type = *machine_.joints[k].type;
      for (const joint_check::Coordinate& one : joint_check::coordinates_of(type)) {
        const double unit = one.is_turn ? 1.0 : units_.length;
        const double factor = random_.between(0.3, 2.0) * (random_.chance(0.5) ? 1.0 : -1.0) / unit;
        all.push_back({k, static_cast<int>(named_place(type, one)), factor});
      }
    }
    const int wanted = 2 + random_.below(2);
    if (static_cast<int>(all.size()) < wanted) return;
    CouplingPlan coupling{"coupling", {}, 0.0};
    for (int k = 0; k < wanted; ++k) {
      const int taken = random_.below(static_cast<int>(all.size()));
      coupling.terms.push_back(all[taken]);
      all.erase(all.begin() + taken);
    }
    machine_.couplings.push_back(coupling);
    if (!place(machine_, choice_).ok()) machine_.couplings.pop_back();
  }

  void add_element() {
    const auto count = static_cast<int>(element_keys().size());
    const int kind =
        machine_.elements.empty() ? static_cast<int>(number_ % element_keys().size()) : random_.below(count);
    const int one = random_.below(static_cast<int>(machine_.bodies.size()));
    const int outer = 1 + random_.below(static_cast<int>(machine_.bodies.size()) - 1);
    const int other = one != outer ? one : 0;
    Ends ends;
    ends.parent = draw_end_on(random_.chance(0.5) ? other : outer);
    ends.child = draw_end_on(ends.parent.body == other ? outer : other);
    ends.alone = draw_end_on(outer);
    const std::string_view table = element_keys()[static_cast<std::size_t>(kind)];
    const bool is_alone = table == "load" || table == "tire";
    const Units units =
        draw_units_between(is_alone ? std::array{ends.alone, ends.alone} : std::array{ends.parent, ends.child});
    ElementPlan element = draw_element(kind, ends, poses_of(machine_), units, random_);
    element.name = fmt::format("element{}", machine_.elements.size() + 1);
    machine_.elements.push_back(std::move(element));
  }

  void name_cut_joint() {
    const bool has_loop = machine_.joints.size() >= machine_.bodies.size();
    if (has_loop && random_.chance(0.4))
      machine_.joints.back().named_as_cut = machine_.joints.size() == machine_.bodies.size();
  }

  /// Every part was accepted only where the machine could be placed; without parts it always can.
  void finish() {
    const Placing placing = place(machine_, choice_);
    if (placing.ok()) return;
    while (machine_.joints.size() >= machine_.bodies.size()) machine_.joints.pop_back();
    machine_.couplings.clear();
    machine_.is_redundant = true;
    machine_.is_regular = false;
    place(machine_, choice_);
  }

  Random random_;
  std::uint64_t number_;
  std::uint64_t choice_;
  Recipe recipe_;
  Units units_;
  PartDrawing parts_{recipe_, units_, random_};
  Machine machine_;
};

}  // namespace

const std::vector<std::string>& style_names() {
  static const std::vector<std::string> names{"mixed",    "generic", "ordinary", "loops", "redundant",
                                              "flexible", "forces",  "wide",     "stiff"};
  return names;
}

Machine draw_machine(std::uint64_t seed, std::uint64_t number, Style style) {
  if (style == Style::mixed) {
    // Against the walk along the catalogue, so that every type meets every style.
    const std::uint64_t turn = number + number / joints::catalogue().size();
    style = kMixed[turn % kMixed.size()];
  }
  return Drawing(seed, number, style).draw();
}

}  // namespace concord::compare::fuzz
