#include "common/reading/absent_words.h"

#include <algorithm>
#include <vector>

#include "common/reading/spelling.h"

namespace concord {

namespace {

struct Absence {
  std::vector<std::string_view> words;
  std::string_view instead;
};

const std::vector<Absence>& absences() {
  static const std::vector<Absence> kAbsences{
      {{"friction", "dry_friction", "coulomb", "coulomb_friction", "stiction", "frictionloss", "friction_coefficient",
        "mu"},
       "concord has no dry friction but that of a [[tire]] on its road: state a resistance of the joint by 'damping' "
       "or 'damper_table' in its 'spring', or leave it out"},
      {{"force", "torque", "force_law", "formula", "expression", "function", "equation"},
       "concord has no force by an expression of place and speed: a [[load]] is a force over time, and 'spring' of a "
       "joint, or a [[line_spring]], pushes by 'spring_table' (of the place), 'damper_table' (of the speed) and "
       "'actuator' (of time)"},
      {{"motor", "servo", "control", "controller", "feedback"},
       "concord has no motor with a control: 'drive' of a joint prescribes the motion, 'actuator' in its 'spring' the "
       "force over time"},
      {{"gear", "gear_ratio", "belt", "pulley", "chain", "rack", "rack_and_pinion", "worm", "transmission"},
       "concord has no gear or belt with a place: a [[coupling]] relates joint coordinates, and its force acts on "
       "these alone, on no bearing"},
      {{"rope", "cable", "tendon", "string"},
       "concord has no rope: a [[line_spring]] pulls along the line between two points, 'spring_table' says how, and a "
       "joint of type 'distance' keeps them apart"},
      {{"contact", "collision", "collide", "restitution", "impact", "geom"},
       "concord has no contact between bodies: 'lower_stop' and 'upper_stop' in the 'spring' of a joint limit a "
       "coordinate, a [[tire]] stands on a [[road]]"},
      {{"limit", "range", "stop", "lower_limit", "upper_limit"},
       "concord has no rigid limits of a coordinate: 'lower_stop' and 'upper_stop' in the 'spring' of a joint resist "
       "beyond a place"},
      {{"massless"},
       "concord has no massless bodies: a joint of type 'distance', 'revolute_spherical' or 'universal_spherical' "
       "stands for a link without mass; give any other body a mass"},
      {{"mesh", "visual", "geometry", "shape"},
       "concord reads no shapes: state 'mass', 'center_of_mass' and 'inertia' of the body"},
      {{"unit", "length_unit", "mass_unit", "angle_unit"},
       "concord has no choice of units: numbers are in SI units and radians, angles also as \"30 deg\""}};
  return kAbsences;
}

}  // namespace

std::string_view what_is_absent(std::string_view word) {
  for (const Absence& one : absences()) {
    const bool is_meant = std::any_of(one.words.begin(), one.words.end(),
                                      [&](std::string_view absent) { return is_same_but_for_number(word, absent); });
    if (is_meant) return one.instead;
  }
  return {};
}

}  // namespace concord
