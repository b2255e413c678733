#pragma once

#include <ostream>
#include <string>
#include <vector>

/// A valid model, and edits of it that break it, each with every word of what the reader must say.
namespace concord {

inline const std::string kSoundModel = R"~(format = 1
gravity = [0, -9.81, 0]

[parameters]
L = 0.3
half = "L/2"

[run]
until = 1

[[body]]
name = "crank"
mass = 0.36
center_of_mass = ["half", 0, 0]
inertia = [1e-4, 7e-4, 7e-4]

[[body]]
name = "rod"
[body.beam]
length = "L"
elements = 4
section = { diameter = 0.006 }
youngs_modulus = 2e11
density = 7870
support = "simply_supported"
modes = { bending_xy = [1, 2] }

[[joint]]
name = "A"
type = "revolute"
parent = { body = "ground", x = [0, 1, 0], z = [1, 0, 0] }
child = "crank"
start.turn_z = { keep = "30 deg", keep_speed = 2 }

[[joint]]
name = "B"
type = "spherical"
parent = { body = "crank", point = ["L", 0, 0] }
child = { body = "rod", node = "first" }

[[joint]]
name = "D"
type = "cylindrical"
parent = "ground"
child = { body = "rod", node = "last" }
drive.slide_z = { law = "constant_speed", speed = 1 }
)~";

/// The sound model with the first `find` replaced by `replace`. Each line of `expected` is "line:column: error: ..."
/// as it follows the file's name and a colon.
struct BrokenModel {
  std::string name;
  std::string find;
  std::string replace;
  std::string expected;

  [[nodiscard]] std::string text() const {
    std::string edited = kSoundModel;
    const auto place = edited.find(find);
    return place == std::string::npos ? "" : edited.replace(place, find.size(), replace);
  }

  /// The whole message for a file of that name.
  [[nodiscard]] std::string message(const std::string& file) const {
    std::string whole = file + ":";
    for (const char c : expected) {
      whole += c;
      if (c == '\n') whole += file + ":";
    }
    return whole;
  }

  friend void PrintTo(const BrokenModel& broken, std::ostream* out) { *out << broken.name; }
};

inline const std::vector<BrokenModel>& broken_models() {
  static const std::vector<BrokenModel> kBroken{
      {"not_toml", "gravity = [0, -9.81, 0]", "gravity = [0, -9.81, 0",
       "4:1: error: not TOML: Error while parsing array: expected comma or closing ']', saw '['"},
      {"missing_equals", "format = 1", "format 1",
       "1:8: error: not TOML: Error while parsing key-value pair: expected '=', saw '1'"},
      {"key_twice", "mass = 0.36",
       R"~(mass = 0.36
mass = 0.4)~",
       "14:8: error: not TOML: Error while parsing key-value pair: cannot redefine existing floating-point 'mass'"},
      {"no_format",
       R"~(format = 1
)~",
       "", "1:1: error: missing key 'format'"},
      {"future_format", "format = 1", "format = 2", "1:10: error: 'format' must be 1, found 2"},
      {"unknown_key_at_top", "gravity =", "gravty =", "2:1: error: unknown key 'gravty': did you mean 'gravity'?"},
      {"unknown_table", "[run]", "[runs]", "8:2: error: unknown key 'runs': did you mean 'run'?"},
      {"plural_of_a_table", "[[body]]", "[[bodies]]", R"~(11:3: error: unknown key 'bodies': did you mean 'body'?
32:9: error: joint 'A': unknown body 'crank': known bodies: ground, rod
38:19: error: joint 'B', parent: unknown body 'crank': known bodies: ground, rod)~"},
      {"no_dry_friction", R"~(type = "spherical")~",
       R"~(type = "spherical"
friction = { coefficient = 0.3 })~",
       "38:1: error: joint 'B': unknown key 'friction': concord has no dry friction but that of a [[tire]] on its "
       "road: "
       "state a resistance of the joint by 'damping' or 'damper_table' in its 'spring', or leave it out"},
      {"no_gear", R"~(type = "spherical")~", R"~(type = "gear")~",
       "37:8: error: joint 'B': unknown joint type 'gear': concord has no gear or belt with a place: a [[coupling]] "
       "relates joint coordinates, and its force acts on these alone, on no bearing"},
      {"unknown_key_far_from_all", "mass = 0.36",
       R"~(mass = 0.36
colour_of_paint = "red")~",
       "14:1: error: body 'crank': unknown key 'colour_of_paint': known keys: name, mass, center_of_mass, inertia, "
       "beam, modes_file, start"},
      {"unknown_key_in_body", "mass = 0.36", "masss = 0.36",
       R"~(11:1: error: body 'crank': missing key: one of 'mass', 'beam' or 'modes_file' must be there
13:1: error: body 'crank': unknown key 'masss': did you mean 'mass'?)~"},
      {"unknown_key_in_joint", R"~(type = "spherical")~", R"~(tpye = "spherical")~",
       R"~(35:1: error: joint 'B': missing key 'type'
37:1: error: joint 'B': unknown key 'tpye': did you mean 'type'?)~"},
      {"unknown_key_in_side", R"~(point = ["L", 0, 0])~", R"~(pont = ["L", 0, 0])~",
       "38:28: error: joint 'B', parent: unknown key 'pont': did you mean 'point'?"},
      {"unknown_key_in_beam", "elements = 4", "element = 4",
       "21:1: error: body 'rod', beam: unknown key 'element': did you mean 'elements'?"},
      {"unknown_key_in_law", "speed = 1 }", "sped = 1 }",
       R"~(46:17: error: joint 'D' (cylindrical), drive, slide_z: missing key 'speed'
46:43: error: joint 'D' (cylindrical), drive, slide_z: unknown key 'sped': did you mean 'speed'?)~"},
      {"no_law_by_expression", "speed = 1 }", "speed = 1 }\nspring.slide_z = { force = \"-5*x\", damping = 1 }",
       "47:20: error: joint 'D' (cylindrical), spring, slide_z: unknown key 'force': concord has no force by an "
       "expression of place and speed: a [[load]] is a force over time, and 'spring' of a joint, or a [[line_spring]], "
       "pushes by 'spring_table' (of the place), 'damper_table' (of the speed) and 'actuator' (of time)"},
      {"gravity_of_two", "[0, -9.81, 0]", "[0, -9.81]", "2:11: error: 'gravity' must be a list of 3 numbers, found 2"},
      {"gravity_a_number", "[0, -9.81, 0]", "-9.81",
       "2:11: error: 'gravity' must be a list of 3 numbers, found a number"},
      {"gravity_with_a_flag", "[0, -9.81, 0]", "[0, true, 0]",
       "2:15: error: entry 2 of 'gravity' must be a number or an expression, found true or false"},
      {"mass_missing",
       R"~(mass = 0.36
)~",
       "", "11:1: error: body 'crank': missing key: one of 'mass', 'beam' or 'modes_file' must be there"},
      {"mass_of_wrong_type", "mass = 0.36", "mass = true",
       "13:8: error: body 'crank': 'mass' must be a number or an expression, found true or false"},
      {"mass_a_date", "mass = 0.36", "mass = 1997-10-01",
       "13:8: error: body 'crank': 'mass' must be a number or an expression, found a date or time"},
      {"mass_negative", "mass = 0.36", "mass = -0.36",
       "13:8: error: body 'crank': 'mass' must be positive, found -0.36"},
      {"mass_zero", "mass = 0.36", "mass = 0", "13:8: error: body 'crank': 'mass' must be positive, found 0"},
      {"mass_not_a_number", "mass = 0.36", "mass = nan",
       "13:8: error: body 'crank': 'mass' must be a finite number, found nan"},
      {"mass_infinite", "mass = 0.36", R"~(mass = "1/0")~",
       "13:8: error: body 'crank': 'mass' must be a finite number, found inf"},
      {"mass_too_large", "mass = 0.36", "mass = 3e151",
       "13:8: error: body 'crank': 'mass' must be zero or of a size from 1e-150 to 1e+150, found 3e+151"},
      {"mass_too_small", "mass = 0.36", R"~(mass = "2^(-600)")~",
       "13:8: error: body 'crank': 'mass' must be zero or of a size from 1e-150 to 1e+150, found "
       "2.409919865102884e-181"},
      {"axis_too_long", "x = [0, 1, 0]", "x = [0, 7e180, 0]",
       "31:37: error: joint 'A', parent: entry 2 of 'x' must be zero or of a size from 1e-150 to 1e+150, found 7e+180"},
      {"parameter_too_large", "L = 0.3", R"~(L = 0.3
C = "2^600")~",
       "6:5: error: parameter 'C': must be zero or of a size from 1e-150 to 1e+150, found 4.149515568880993e+180"},
      {"parameter_of_a_long_name", "L = 0.3", "L = 0.3\n" + std::string(101, 'k') + " = 1",
       "6:105: error: parameter '" + std::string(101, 'k') + "': the name has 101 characters, at most 100 are allowed"},
      {"name_too_long", R"~(name = "crank")~", "name = \"" + std::string(101, 'k') + "\"",
       "12:8: error: body '" + std::string(101, 'k') +
           "': 'name' has 101 bytes, at most 100 are allowed: result files are named by it\n"
           "32:9: error: joint 'A': unknown body 'crank': known bodies: ground, " +
           std::string(101, 'k') + ", rod\n" +
           "38:19: error: joint 'B', parent: unknown body 'crank': known bodies: ground, " + std::string(101, 'k') +
           ", rod"},
      {"moment_of_inertia_overflows", R"~(gravity = [0, -9.81, 0])~", R"~(gravity = [0, -9.81, 0]
[[body]]
name = "star"
mass = 2e71
inertia = [1, 1, 1]
[[joint]]
name = "orbit"
type = "weld"
parent = { body = "ground", point = [4e40, 0, 0] }
child = "star"
)~",
       "3:1: error: body 'star': mass times the square of the machine's length is of the size 1e+153, beyond 1e+150: "
       "choose units in which it is nearer to one"},
      {"spring_overflows", "[run]", R"~([[line_spring]]
name = "wire"
parent = { body = "ground", point = [0, 3e60, 0] }
child = "crank"
free = 1
stiffness = 1e31

[run])~",
       "8:1: error: force element 'wire': stiffness times the square of its stretch is of the size 1e+152, beyond "
       "1e+150: choose units in which it is nearer to one"},
      {"driver_overflows", R"~({ law = "constant_speed", speed = 1 })~",
       R"~({ law = "harmonic", amplitude = 5e120, frequency = 2e20 })~",
       "46:49: error: joint 'D' (cylindrical), drive, slide_z: the law or one of its first two derivatives goes beyond "
       "1e+150"},
      {"table_overflows", "[run]", R"~([[line_spring]]
name = "wire"
parent = "ground"
child = "crank"
free = 1
spring_table = { x = [0, 1e-8, 1, 2], force = [0, 1e145, 3, 4] }

[run])~",
       "13:47: error: line_spring 'wire', spring_table: a slope of the table or its change goes beyond 1e+150"},
      {"beam_overflows", "section = { diameter = 0.006 }", "section = { diameter = 1.4965776766268446e51 }",
       "22:11: error: body 'rod', beam: the second moment of area about y that follows must be zero or of a size from "
       "1e-150 to 1e+150, found 2.4624473311287602e+203"},
      {"nested_too_deep", "until = 1",
       "until" +
           [] {
             std::string key;
             for (int k = 0; k < 101; ++k) key += ".a";
             return key;
           }() +
           " = 1",
       "9:206: error: nested deeper than 100 levels: no model needs that"},
      {"mass_a_root_of_minus_one", "mass = 0.36", R"~(mass = "sqrt(-1)")~",
       "13:8: error: body 'crank': 'mass' must be a finite number, found nan"},
      {"inertia_missing",
       R"~(inertia = [1e-4, 7e-4, 7e-4]
)~",
       "", "11:1: error: body 'crank': missing key 'inertia'"},
      {"inertia_of_four", "[1e-4, 7e-4, 7e-4]", "[1e-4, 7e-4, 7e-4, 0]",
       "15:11: error: body 'crank': 'inertia' must be 3 numbers (xx, yy, zz) or 6 (xx, yy, zz, xy, xz, yz), found 4"},
      {"inertia_negative", "[1e-4, 7e-4, 7e-4]", "[-1e-4, 7e-4, 7e-4]",
       "15:11: error: body 'crank': 'inertia' has principal moments -0.0001, 0.0007, 0.0007 kg m2: none may be "
       "negative"},
      {"inertia_not_of_this_world", "[1e-4, 7e-4, 7e-4]", "[1e-4, 7e-4, 9e-4]",
       "15:11: error: body 'crank': 'inertia' has principal moments 0.0001, 0.0007, 0.0009 kg m2: the largest exceeds "
       "the sum of the others, which no mass distribution can have"},
      {"inertia_products_too_large", "[1e-4, 7e-4, 7e-4]", "[1e-4, 7e-4, 7e-4, 5e-4, 0, 0]",
       "15:11: error: body 'crank': 'inertia' has principal moments -0.000183095, 0.0007, 0.000983095 kg m2: none may "
       "be negative"},
      {"center_of_mass_of_two", R"~(["half", 0, 0])~", R"~(["half", 0])~",
       "14:18: error: body 'crank': 'center_of_mass' must be a list of 3 numbers, found 2"},
      {"body_without_name",
       R"~(name = "crank"
)~",
       "",
       R"~(11:1: error: body: missing key 'name'
31:9: error: joint 'A': unknown body 'crank': known bodies: ground, rod
37:19: error: joint 'B', parent: unknown body 'crank': known bodies: ground, rod)~"},
      {"body_with_an_empty_name", R"~(name = "crank")~", R"~(name = "")~",
       R"~(12:8: error: body '': 'name' must not be empty
32:9: error: joint 'A': unknown body 'crank': known bodies: ground, rod
38:19: error: joint 'B', parent: unknown body 'crank': known bodies: ground, rod)~"},
      {"body_named_ground", R"~(name = "crank")~", R"~(name = "ground")~",
       R"~(11:1: error: body 'ground': ground is there already and stands still: choose another name
32:9: error: joint 'A': unknown body 'crank': known bodies: ground, rod
38:19: error: joint 'B', parent: unknown body 'crank': known bodies: ground, rod)~"},
      {"bodies_of_same_name", R"~(name = "rod")~", R"~(name = "crank")~",
       R"~(17:1: error: body 'crank': line 11 has the same name: choose another
39:18: error: joint 'B', child: unknown body 'rod': known bodies: ground, crank
45:18: error: joint 'D', child: unknown body 'rod': known bodies: ground, crank)~"},
      {"body_with_mass_and_beam", R"~(name = "rod")~",
       R"~(name = "rod"
mass = 1)~",
       "20:1: error: body 'rod': 'mass' and 'beam' exclude each other: give one of them"},
      {"body_a_table",
       R"~([[body]]
name = "crank"
mass = 0.36
center_of_mass = ["half", 0, 0]
inertia = [1e-4, 7e-4, 7e-4]

[[body]]
name = "rod"
[body.beam])~",
       R"~([body]
name = "rod"
[body.beam])~",
       "11:1: error: 'body' must be a list of tables, found a table: write [[body]]"},
      {"flexible_body_with_inertia", R"~(name = "rod")~",
       R"~(name = "rod"
inertia = [1, 1, 1])~",
       "19:11: error: body 'rod': 'inertia' follows from the flexible body: leave it out"},
      {"no_body",
       R"~([[body]]
name = "crank"
mass = 0.36
center_of_mass = ["half", 0, 0]
inertia = [1e-4, 7e-4, 7e-4]

[[body]]
name = "rod"
[body.beam]
length = "L"
elements = 4
section = { diameter = 0.006 }
youngs_modulus = 2e11
density = 7870
support = "simply_supported"
modes = { bending_xy = [1, 2] }

[[joint]]
name = "A"
type = "revolute"
parent = { body = "ground", x = [0, 1, 0], z = [1, 0, 0] }
child = "crank"
start.turn_z = { keep = "30 deg", keep_speed = 2 }

[[joint]]
name = "B"
type = "spherical"
parent = { body = "crank", point = ["L", 0, 0] }
child = { body = "rod", node = "first" }

[[joint]]
name = "D"
type = "cylindrical"
parent = "ground"
child = { body = "rod", node = "last" }
drive.slide_z = { law = "constant_speed", speed = 1 }
)~",
       "", "1:1: error: there is no body: write at least one [[body]]"},
      {"elements_a_fraction", "elements = 4", "elements = 4.5",
       "21:12: error: body 'rod', beam: 'elements' must be a whole number of at least 1, found 4.5"},
      {"length_negative", R"~(length = "L")~", R"~(length = "-L")~",
       "20:10: error: body 'rod', beam: 'length' must be positive, found -0.3"},
      {"section_unknown", "{ diameter = 0.006 }", "{ radius = 0.003 }",
       "22:11: error: body 'rod', beam: a section is { diameter }, { diameter, inner_diameter }, { width_y, width_z }, "
       "or { area, second_moment_y, second_moment_z, torsion_constant }"},
      {"section_a_number", "{ diameter = 0.006 }", "0.006",
       "22:11: error: body 'rod', beam: 'section' must be a table, found a number"},
      {"tube_inside_out", "{ diameter = 0.006 }", "{ diameter = 0.006, inner_diameter = 0.007 }",
       "22:48: error: body 'rod', beam, section: 'inner_diameter' must be less than 'diameter' = 0.006 m, found 0.007 "
       "m"},
      {"support_unknown", R"~("simply_supported")~", R"~("simply_suported")~",
       "25:11: error: body 'rod', beam: unknown support 'simply_suported': did you mean 'simply_supported'?"},
      {"mode_that_does_not_exist", "bending_xy = [1, 2]", "bending_xy = [1, 20]",
       "26:9: error: body 'rod', beam: bending_xy mode 20 does not exist: with these supports and 4 elements there are "
       "8"},
      {"mode_chosen_twice", "bending_xy = [1, 2]", "bending_xy = [1, 1]",
       "26:9: error: body 'rod', beam: bending_xy mode 1 is chosen twice"},
      {"mode_zero", "bending_xy = [1, 2]", "bending_xy = [0, 1]",
       "26:24: error: body 'rod', beam, modes: modes are numbered 1, 2, 3, ...; found 0"},
      {"mode_family_unknown", "bending_xy = [1, 2]", "bending_yz = [1, 2]",
       "26:11: error: body 'rod', beam, modes: unknown key 'bending_yz': did you mean 'bending_xz'?"},
      {"static_mode_without_craig_bampton", "modes = { bending_xy = [1, 2] }", "static_modes = { axial = [1] }",
       "26:16: error: body 'rod', beam: static axial mode 1 does not exist: with these supports and 4 elements there "
       "are 0"},
      {"torsion_without_shear_modulus", "bending_xy = [1, 2]", "torsion = [1]",
       "26:9: error: body 'rod', beam: family torsion has stiffness 0 and inertia per length 1.00134e-06; both must be "
       "positive: give the section and the material that it needs"},
      {"beam_without_modes",
       R"~(modes = { bending_xy = [1, 2] }
)~",
       "", "19:1: error: body 'rod', beam: a beam needs modes: give 'modes' or 'static_modes', or make the body rigid"},
      {"modes_file_missing",
       R"~([body.beam]
length = "L"
elements = 4
section = { diameter = 0.006 }
youngs_modulus = 2e11
density = 7870
support = "simply_supported"
modes = { bending_xy = [1, 2] }
)~",
       R"~(modes_file = "nowhere.toml"
)~",
       "19:14: error: body 'rod': there is no modes file 'nowhere.toml'"},
      {"modal_start_of_wrong_length", R"~(name = "rod")~",
       R"~(name = "rod"
start.a = [0.1])~",
       "19:11: error: body 'rod', start: 'a' must be a list of 2 numbers, found 1"},
      {"modal_start_of_rigid_body", "mass = 0.36",
       R"~(mass = 0.36
start.adot = [0.1])~",
       "14:14: error: body 'crank', start: a rigid body has no modal coordinates: 'adot' has no place here"},
      {"joint_type_unknown", R"~("revolute")~", R"~("revolut")~",
       "30:8: error: joint 'A': unknown joint type 'revolut': did you mean 'revolute'?"},
      {"joint_type_missing",
       R"~(type = "revolute"
)~",
       "", "28:1: error: joint 'A': missing key 'type'"},
      {"joint_without_child",
       R"~(child = "crank"
)~",
       "", "28:1: error: joint 'A': missing key 'child'"},
      {"joint_body_unknown", R"~(child = "crank")~", R"~(child = "crnk")~",
       "32:9: error: joint 'A': unknown body 'crnk': did you mean 'crank'?"},
      {"joint_side_without_body", R"~(body = "crank", )~", "", "38:10: error: joint 'B', parent: missing key 'body'"},
      {"joint_side_a_number",
       R"~(parent = "ground"
child = { body = "rod", node = "last" })~",
       R"~(parent = 0
child = { body = "rod", node = "last" })~",
       "44:10: error: joint 'D': 'parent' must be the name of a body, or a table, found a number"},
      {"joint_of_a_body_with_itself", R"~(child = "crank")~", R"~(child = "ground")~",
       "32:9: error: joint 'A': connects body 'ground' with itself"},
      {"joints_of_same_name", R"~(name = "B")~", R"~(name = "A")~",
       "36:8: error: joint 'A': line 29 has the same name: choose another"},
      {"axes_not_perpendicular", "x = [0, 1, 0], z = [1, 0, 0]", "x = [0.0453, 1, 0], z = [1, 0, 0]",
       "31:53: error: joint 'A', parent: axes x and z must be perpendicular, but they enclose 87.4062744 deg"},
      {"axes_parallel", "x = [0, 1, 0], z = [1, 0, 0]", "x = [2, 0, 0], z = [1, 0, 0]",
       "31:48: error: joint 'A', parent: axes x and z must be perpendicular, but they enclose 0 deg"},
      {"one_axis_only", "x = [0, 1, 0], z", "z",
       "31:33: error: joint 'A', parent: a frame takes two of its axes 'x', 'y', 'z', found 1"},
      {"axis_of_length_zero", "x = [0, 1, 0], z", "x = [0, 0, 0], z",
       "31:33: error: joint 'A', parent: 'x' must point somewhere, found a vector of length zero"},
      {"axis_without_angle", "x = [0, 1, 0], z = [1, 0, 0]", "axis = [1, 0, 0]",
       "31:10: error: joint 'A', parent: missing key 'angle'"},
      {"two_orientations", "x = [0, 1, 0], z = [1, 0, 0]", "x = [0, 1, 0], z = [1, 0, 0], axis = [1, 0, 0], angle = 1",
       "31:10: error: joint 'A', parent: an orientation is said in one way: two of x, y, z; axis and angle; sequence "
       "and angles; rotation_vector; or euler_parameters"},
      {"sequence_of_wrong_letters", "x = [0, 1, 0], z = [1, 0, 0]", R"~(sequence = "zxw", angles = [0, 0, 0])~",
       R"~(31:40: error: joint 'A', parent: 'sequence' must be three letters of x, y, z, such as "zxz", found "zxw")~"},
      {"frame_in_both_and_in_side", R"~(type = "revolute")~",
       R"~(type = "revolute"
both = { axis = [0, 0, 1], angle = 1 })~",
       "32:10: error: joint 'A', parent: the frame is given in 'both' already"},
      {"point_in_both_and_in_side", R"~(parent = { body = "ground", x)~",
       R"~(both = { point = [1, 0, 0] }
parent = { body = "ground", point = [0, 0, 0], x)~",
       "32:37: error: joint 'A', parent: the point is given in 'both' already"},
      {"point_in_both_on_flexible_body", R"~(parent = { body = "crank", point = ["L", 0, 0] })~",
       R"~(parent = "crank"
both = { point = [0.1, 0, 0] })~",
       "40:9: error: joint 'B', child: body 'rod' is flexible: the point in 'both' cannot be on it"},
      {"node_unknown", R"~(node = "first")~", R"~(node = "frist")~",
       "39:32: error: joint 'B', child: body 'rod' has no node 'frist': did you mean 'first'?"},
      {"node_and_point", R"~(node = "first")~", R"~(node = "first", point = [0, 0, 0])~",
       "39:32: error: joint 'B', child: 'point' and 'node' exclude each other: give one of them"},
      {"node_on_rigid_body", R"~(point = ["L", 0, 0])~", R"~(node = "first")~",
       "38:35: error: joint 'B', parent: body 'crank' is rigid: give a 'point' instead of a 'node'"},
      {"point_on_flexible_body", R"~(node = "first")~", "point = [0, 0, 0]",
       "39:9: error: joint 'B', child: body 'rod' is flexible: joints and forces sit on its nodes, so give a 'node'"},
      {"flexible_body_by_name_only", R"~(child = { body = "rod", node = "first" })~", R"~(child = "rod")~",
       "39:9: error: joint 'B': body 'rod' is flexible: joints and forces sit on its nodes, so give a 'node'"},
      {"body_not_connected",
       R"~(parent = { body = "crank", point = ["L", 0, 0] }
child = { body = "rod", node = "first" }

[[joint]]
name = "D"
type = "cylindrical"
parent = "ground"
child = { body = "rod", node = "last" })~",
       R"~(parent = "ground"
child = "crank"

[[joint]]
name = "D"
type = "cylindrical"
parent = "ground"
child = "crank")~",
       R"~(17:1: error: no chain of joints connects to ground: rod: add a joint, of type "free" if nothing holds it)~"},
      {"two_bodies_not_connected",
       R"~(parent = { body = "ground", x = [0, 1, 0], z = [1, 0, 0] }
child = "crank"
start.turn_z = { keep = "30 deg", keep_speed = 2 }

[[joint]]
name = "B"
type = "spherical"
parent = { body = "crank", point = ["L", 0, 0] }
child = { body = "rod", node = "first" }

[[joint]]
name = "D"
type = "cylindrical"
parent = "ground")~",
       R"~(parent = { body = "crank", x = [0, 1, 0], z = [1, 0, 0] }
child = { body = "rod", node = "first" }

[[joint]]
name = "D"
type = "cylindrical"
parent = "crank")~",
       R"~(11:1: error: no chain of joints connects to ground: crank, rod: add a joint, of type "free" if nothing holds it)~"},
      {"cut_of_wrong_type", R"~(type = "spherical")~",
       R"~(type = "spherical"
cut = "yes")~",
       "38:7: error: joint 'B': 'cut' must be true or false, found a string"},
      {"start_of_a_word_that_is_not_there", "start.turn_z", "start.turn_x",
       "33:7: error: joint 'A' (revolute), start: unknown key 'turn_x': did you mean 'turn_z'?"},
      {"start_kept_and_guessed", R"~({ keep = "30 deg", keep_speed = 2 })~", R"~({ keep = "30 deg", guess = 0.5 })~",
       "33:43: error: joint 'A' (revolute), start, turn_z: 'keep' and 'guess' exclude each other: give one of them"},
      {"start_of_a_driven_coordinate", "drive.slide_z",
       R"~(start.slide_z = { keep = 0 }
drive.slide_z)~",
       "46:17: error: joint 'D' (cylindrical), start: 'slide_z' is driven, so its start follows from the law: leave "
       "this out"},
      {"start_of_a_ball_by_a_number", R"~(type = "spherical")~",
       R"~(type = "spherical"
start.ball = { keep = 0.3 })~",
       R"~(38:23: error: joint 'B' (spherical), start, ball: 'keep' of a ball must be an orientation, such as { axis = [0, 0, 1], angle = "30 deg" }, found a number)~"},
      {"start_speed_of_a_ball_of_two", R"~(type = "spherical")~",
       R"~(type = "spherical"
start.ball = { keep_speed = [1, 2] })~",
       "38:29: error: joint 'B' (spherical), start, ball: 'keep_speed' must be a list of 3 numbers, found 2"},
      {"driver_law_unknown", R"~("constant_speed")~", R"~("constant_sped")~",
       "46:25: error: joint 'D' (cylindrical), drive, slide_z: unknown law 'constant_sped': did you mean "
       "'constant_speed'?"},
      {"driver_law_missing", R"~(law = "constant_speed", )~", "",
       "46:17: error: joint 'D' (cylindrical), drive, slide_z: missing key 'law'"},
      {"driver_number_missing", ", speed = 1", "",
       "46:17: error: joint 'D' (cylindrical), drive, slide_z: missing key 'speed'"},
      {"driver_on_a_ball", R"~(type = "spherical")~",
       R"~(type = "spherical"
drive.ball = { law = "constant_speed", speed = 1 })~",
       "38:14: error: joint 'B' (spherical), drive: a ball cannot be driven: only a turn or a slide follows a law of "
       "time"},
      {"driver_on_a_word_that_is_not_there", "drive.slide_z", "drive.slide_x",
       "46:7: error: joint 'D' (cylindrical), drive: unknown key 'slide_x': did you mean 'slide_z'?"},
      {"driver_step_backwards", R"~({ law = "constant_speed", speed = 1 })~",
       R"~({ law = "smooth_step", t0 = 1, t1 = 0.5, from = 0, to = 1 })~",
       "46:53: error: joint 'D' (cylindrical), drive, slide_z: 't1' must be later than 't0' = 1 s, found 0.5 s"},
      {"driver_spline_too_short", R"~({ law = "constant_speed", speed = 1 })~",
       R"~({ law = "spline", times = [0, 1, 2], values = [0, 1, 0] })~",
       "46:43: error: joint 'D' (cylindrical), drive, slide_z: a spline takes at least 4 points, found 3"},
      {"driver_spline_times_fall", R"~({ law = "constant_speed", speed = 1 })~",
       R"~({ law = "spline", times = [0, 1, 0.5, 2], values = [0, 1, 0, 1] })~",
       "46:43: error: joint 'D' (cylindrical), drive, slide_z: 'times' must rise, but after 1 s comes 0.5 s"},
      {"driver_spline_too_uneven", R"~({ law = "constant_speed", speed = 1 })~",
       R"~({ law = "spline", times = [0, 1, 2, 4e9], values = [0, 1, 0, 1] })~",
       "46:43: error: joint 'D' (cylindrical), drive, slide_z: 'times' lie 4e+09 s apart in one place and 1 s in "
       "another: a cubic spline resolves distances that differ by a factor of 1e+09 at most"},
      {"driver_spline_of_unequal_lists", R"~({ law = "constant_speed", speed = 1 })~",
       R"~({ law = "spline", times = [0, 1, 2, 3], values = [0, 1, 0] })~",
       "46:66: error: joint 'D' (cylindrical), drive, slide_z: 'values' must be as many as 'times', 4, found 3"},
      {"driver_polynomial_empty", R"~({ law = "constant_speed", speed = 1 })~",
       R"~({ law = "polynomial", coefficients = [] })~",
       "46:54: error: joint 'D' (cylindrical), drive, slide_z: 'coefficients' must have at least one number: those of "
       "1, t, t^2, ..."},
      {"parameter_unknown", R"~("L/2")~", R"~("Len/2")~",
       "6:8: error: parameter 'half': unknown name 'Len' in 'Len/2': known parameters: L, half"},
      {"parameters_in_a_circle", "L = 0.3", R"~(L = "half*2")~",
       "6:8: error: parameter 'half': goes round in a circle: L -> half -> L"},
      {"parameter_with_a_taken_name", "L = 0.3",
       R"~(L = 0.3
sin = 2)~",
       "6:7: error: parameter 'sin': the name already means something in expressions: choose another"},
      {"parameter_that_cannot_be_read", R"~("L/2")~", R"~("L/*2")~",
       R"~(6:8: error: parameter 'half': cannot read 'L/*2': Unexpected operator "*" found at position 2)~"},
      {"parameter_of_wrong_type", R"~("L/2")~", "[1, 2]",
       "6:8: error: parameter 'half': must be a number or an expression, found a list"},
      {"parameter_infinite", R"~("L/2")~", R"~("L/0")~",
       "6:8: error: parameter 'half': must be a finite number, found inf"},
      {"parameter_with_an_odd_name", "L = 0.3",
       R"~(L = 0.3
"2nd" = 1)~",
       "6:9: error: parameter '2nd': the name must consist of letters, digits and underscores, not a digit first"},
      {"expression_with_two_results", R"~(["half", 0, 0])~", R"~(["half, 1", 0, 0])~",
       "14:19: error: body 'crank': entry 1 of 'center_of_mass': 'half, 1' must be one number"},
      {"until_negative", "until = 1", "until = -1", "9:9: error: run: 'until' must be positive, found -1"},
      {"rtol_that_compares_nothing", "until = 1", "rtol = 1",
       "9:8: error: run: 'rtol' must lie between 1e-14 and 0.01, found 1"},
      {"rtol_below_round_off", "until = 1", "rtol = 1e-30",
       "9:8: error: run: 'rtol' must lie between 1e-14 and 0.01, found 1e-30"},
      {"name_of_another_folder", "format = 1", "format = 1\nname = \"../sound\"",
       "2:8: error: 'name' must be one line without '/', for result files are named by it, found \"../sound\""},
      {"name_of_nothing", "format = 1", "format = 1\nname = \"\"", "2:8: error: 'name' must not be empty"},
      {"joint_name_that_ends_with_a_blank", "name = \"A\"", "name = \"A \"",
       "29:8: error: joint 'A ': 'name' must not begin or end with a blank, found \"A \""},
      {"joint_name_of_a_folder", "name = \"A\"", "name = \"left/A\"",
       "29:8: error: joint 'left/A': 'name' must be one line without '/', for result files are named by it, found "
       "\"left/A\""},
      {"beam_of_too_many_elements", "elements = 4", "elements = 400000",
       "21:12: error: body 'rod', beam: 'elements' must be a whole number of at least 1 and at most 10000, found "
       "400000"},
      {"samples_zero", "until = 1", "samples = 0",
       "9:11: error: run: 'samples' must be a whole number of at least 1, found 0"},
      {"need_of_unknown_joint", "[run]",
       R"~([[need]]
joint = "X"
same_run = 6

[run])~",
       "9:9: error: need: unknown joint 'X': known joints: A, B, D"},
      {"need_of_unknown_component", "[run]",
       R"~([[need]]
joint = "A"
component = "F_q"
same_run = 6

[run])~",
       "10:13: error: need: unknown component 'F_q': known components: F_x, F_y, F_z, T_x, T_y, T_z"},
      {"need_of_too_many_digits", "[run]",
       R"~([[need]]
joint = "A"
same_run = 20

[run])~",
       "10:12: error: need: 'same_run' must be at most 16 digits, found 20"},
      {"need_that_says_nothing", "[run]",
       R"~([[need]]
joint = "A"
because = "of noise"

[run])~",
       "8:1: error: need: says nothing: give 'same_state', 'same_run' or 'refined'"},
      {"load_without_a_name", "[run]", R"~([[load]]
body = "crank"
force = [1, 2, 3]

[run])~",
       "8:1: error: load: missing key 'name'"},
      {"load_body_unknown", "[run]", R"~([[load]]
name = "push"
body = "crnk"
force = [1, 2, 3]

[run])~",
       "10:8: error: load 'push': unknown body 'crnk': did you mean 'crank'?"},
      {"load_without_a_body", "[run]", R"~([[load]]
name = "push"
force = [1, 2, 3]

[run])~",
       "8:1: error: load 'push': missing key 'body'"},
      {"load_on_ground", "[run]", R"~([[load]]
name = "push"
body = "ground"
force = [1, 2, 3]

[run])~",
       "10:8: error: load 'push': a load on ground moves nothing: name a moving body"},
      {"load_that_exerts_nothing", "[run]", R"~([[load]]
name = "push"
body = "crank"

[run])~",
       "8:1: error: load 'push': exerts nothing: give a 'force' or a 'torque'"},
      {"load_axes_unknown", "[run]", R"~([[load]]
name = "push"
body = "crank"
axes = "folower"
force = [1, 2, 3]

[run])~",
       "11:8: error: load 'push': unknown axes 'folower': did you mean 'follower'?"},
      {"load_force_of_two", "[run]", R"~([[load]]
name = "push"
body = "crank"
force = [1, 2]

[run])~",
       "11:9: error: load 'push': 'force' must be a list of 3 numbers, found 2"},
      {"load_law_unknown", "[run]", R"~([[load]]
name = "push"
body = "crank"
torque = [1, 2, 3]
law = { law = "harmonc", amplitude = 1, frequency = 2 }

[run])~",
       "12:15: error: load 'push', law: unknown law 'harmonc': did you mean 'harmonic'?"},
      {"load_law_by_its_name_alone", "[run]", R"~([[load]]
name = "push"
body = "crank"
torque = [1, 2, 3]
law = "harmonic"

[run])~",
       R"~(12:7: error: load 'push': the numbers of the law are missing: write law = { law = "harmonic", ... })~"},
      {"load_law_a_list", "[run]", R"~([[load]]
name = "push"
body = "crank"
torque = [1, 2, 3]
law = [1, 2]

[run])~",
       R"~(12:7: error: load 'push': 'law' must be a number or a table such as { law = "harmonic", ... }, found a list)~"},
      {"load_on_an_unknown_node", "[run]", R"~([[load]]
name = "push"
body = "rod"
node = "3rd"
force = [1, 2, 3]

[run])~",
       "11:8: error: load 'push': body 'rod' has no node '3rd': known nodes: 0, 1, 2, 3, 4, first, last"},
      {"load_on_a_point_of_a_flexible_body", "[run]", R"~([[load]]
name = "push"
body = "rod"
point = [0, 0, 0]
force = [1, 2, 3]

[run])~",
       "8:1: error: load 'push': body 'rod' is flexible: joints and forces sit on its nodes, so give a 'node'"},
      {"load_with_an_unknown_key", "[run]", R"~([[load]]
name = "push"
body = "crank"
forces = [1, 2, 3]

[run])~",
       R"~(8:1: error: load 'push': exerts nothing: give a 'force' or a 'torque'
11:1: error: load 'push': unknown key 'forces': did you mean 'force'?)~"},
      {"load_a_table", "[run]", R"~([load]
name = "push"
body = "crank"
force = [1, 2, 3]

[run])~",
       "8:1: error: 'load' must be a list of tables, found a table: write [[load]]"},
      {"element_named_like_a_joint", "[run]", R"~([[load]]
name = "B"
body = "crank"
force = [1, 2, 3]

[run])~",
       "9:8: error: load 'B': line 41 has the same name: choose another"},
      {"elements_of_same_name", "[run]", R"~([[load]]
name = "push"
body = "crank"
force = [1, 2, 3]
[[bushing]]
name = "push"
parent = "ground"
child = "crank"
stiffness = [1, 2, 3, 4, 5, 6]

[run])~",
       "13:8: error: bushing 'push': line 9 has the same name: choose another"},
      {"line_spring_without_a_parent", "[run]", R"~([[line_spring]]
name = "coil"
child = { body = "rod", node = "last" }
stiffness = 5
free = 1

[run])~",
       "8:1: error: line_spring 'coil': missing key 'parent'"},
      {"line_spring_of_a_body_with_itself", "[run]", R"~([[line_spring]]
name = "coil"
parent = { body = "rod", node = "first" }
child = { body = "rod", node = "last" }
damping = 5

[run])~",
       "11:9: error: line_spring 'coil': connects body 'rod' with itself"},
      {"line_spring_without_a_free_length", "[run]", R"~([[line_spring]]
name = "coil"
parent = "ground"
child = { body = "rod", node = "last" }
stiffness = 5

[run])~",
       "8:1: error: line_spring 'coil': missing key 'free': the length [m] at which the spring rests"},
      {"line_spring_that_exerts_nothing", "[run]", R"~([[line_spring]]
name = "coil"
parent = "ground"
child = { body = "rod", node = "last" }
free = 1

[run])~",
       "8:1: error: line_spring 'coil': exerts nothing: give a stiffness, a damping, a preload, a table, a stop or an "
       "actuator"},
      {"line_spring_that_gives_energy", "[run]", R"~([[line_spring]]
name = "coil"
parent = "ground"
child = { body = "rod", node = "last" }
damping = -5

[run])~",
       "12:11: error: line_spring 'coil': 'damping' must not be negative, found -5"},
      {"line_spring_by_a_list", "[run]", R"~([[line_spring]]
name = "coil"
parent = ["ground"]
child = { body = "rod", node = "last" }
damping = 5

[run])~",
       "10:10: error: line_spring 'coil': 'parent' must be the name of a body, or a table, found a list"},
      {"line_spring_on_a_flexible_body_by_name", "[run]", R"~([[line_spring]]
name = "coil"
parent = "ground"
child = "rod"
damping = 5

[run])~",
       "11:9: error: line_spring 'coil': body 'rod' is flexible: joints and forces sit on its nodes, so give a 'node'"},
      {"spring_table_too_short", "[run]", R"~([[line_spring]]
name = "coil"
parent = "ground"
child = { body = "rod", node = "last" }
free = 1
spring_table = { x = [0, 1, 2], force = [0, 1, 8] }

[run])~",
       "13:22: error: line_spring 'coil', spring_table: a spline takes at least 4 points, found 3"},
      {"spring_table_that_falls", "[run]", R"~([[line_spring]]
name = "coil"
parent = "ground"
child = { body = "rod", node = "last" }
free = 1
spring_table = { x = [0, 1, 1, 2], force = [0, 1, 8, 9] }

[run])~",
       "13:22: error: line_spring 'coil', spring_table: 'x' must rise, but after 1 comes 1"},
      {"spring_table_of_unequal_lists", "[run]", R"~([[line_spring]]
name = "coil"
parent = "ground"
child = { body = "rod", node = "last" }
free = 1
spring_table = { x = [0, 1, 2, 3], force = [0, 1, 8] }

[run])~",
       "13:44: error: line_spring 'coil', spring_table: 'force' must be as many as 'x', 4, found 3"},
      {"spring_table_without_forces", "[run]", R"~([[line_spring]]
name = "coil"
parent = "ground"
child = { body = "rod", node = "last" }
free = 1
spring_table = { x = [0, 1, 2, 3], forces = [0, 1, 8, 9] }

[run])~",
       R"~(13:16: error: line_spring 'coil', spring_table: missing key 'force'
13:36: error: line_spring 'coil', spring_table: unknown key 'forces': did you mean 'force'?)~"},
      {"damper_table_a_list", "[run]", R"~([[line_spring]]
name = "coil"
parent = "ground"
child = { body = "rod", node = "last" }
damper_table = [0, 1, 2, 3]

[run])~",
       "12:16: error: line_spring 'coil': 'damper_table' must be a table, found a list"},
      {"stop_without_width", "[run]", R"~([[line_spring]]
name = "coil"
parent = "ground"
child = { body = "rod", node = "last" }
lower_stop = { at = 0.1, stiffness = 1e4 }

[run])~",
       "12:14: error: line_spring 'coil', lower_stop: missing key 'width'"},
      {"stop_of_width_zero", "[run]", R"~([[line_spring]]
name = "coil"
parent = "ground"
child = { body = "rod", node = "last" }
lower_stop = { at = 0.1, stiffness = 1e4, width = 0 }

[run])~",
       "12:51: error: line_spring 'coil', lower_stop: 'width' must be positive, found 0"},
      {"stop_that_pulls", "[run]", R"~([[line_spring]]
name = "coil"
parent = "ground"
child = { body = "rod", node = "last" }
upper_stop = { at = 0.1, stiffness = -1e4, width = 0.01, damping = -1 }

[run])~",
       R"~(12:38: error: line_spring 'coil', upper_stop: 'stiffness' must be positive, found -10000
12:68: error: line_spring 'coil', upper_stop: 'damping' must not be negative, found -1)~"},
      {"stops_that_cross", "[run]", R"~([[turn_spring]]
name = "helix"
parent = "ground"
child = "crank"
lower_stop = { at = "20 deg", stiffness = 10, width = 0.1 }
upper_stop = { at = 0.25, stiffness = 10, width = 0.1 }

[run])~",
       "13:14: error: turn_spring 'helix': the upper stop must be above the lower one at 0.3490658503988659, found "
       "0.25"},
      {"turn_spring_with_an_unknown_key", "[run]", R"~([[turn_spring]]
name = "helix"
parent = "ground"
child = "crank"
stifness = 3
damping = 1

[run])~",
       "12:1: error: turn_spring 'helix': unknown key 'stifness': did you mean 'stiffness'?"},
      {"turn_spring_body_unknown", "[run]", R"~([[turn_spring]]
name = "helix"
parent = "ground"
child = "wheel"
stiffness = 3

[run])~",
       "11:9: error: turn_spring 'helix': unknown body 'wheel': known bodies: ground, crank, rod"},
      {"turn_spring_actuator_unknown", "[run]", R"~([[turn_spring]]
name = "helix"
parent = "ground"
child = "crank"
actuator = { law = "ramp", speed = 1 }

[run])~",
       "12:20: error: turn_spring 'helix', actuator: unknown law 'ramp': known laws: constant_speed, polynomial, "
       "harmonic, smooth_step, spline"},
      {"bushing_of_five_numbers", "[run]", R"~([[bushing]]
name = "mount"
parent = "ground"
child = "crank"
stiffness = [1, 2, 3, 4, 5]

[run])~",
       "12:13: error: bushing 'mount': 'stiffness' must be a list of 6 numbers, found 5"},
      {"bushing_of_five_rows", "[run]", R"~([[bushing]]
name = "mount"
parent = "ground"
child = "crank"
stiffness = [[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0]]

[run])~",
       "12:13: error: bushing 'mount': 'stiffness' must be a list of 6 rows of 6 numbers, found 2"},
      {"bushing_with_a_short_row", "[run]", R"~([[bushing]]
name = "mount"
parent = "ground"
child = "crank"
damping = [[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0], [0, 0, 0, 1, 0], [0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1]]

[run])~",
       "12:72: error: bushing 'mount': row 4 of 'damping' must be a list of 6 numbers, found 5"},
      {"bushing_asymmetric", "[run]", R"~([[bushing]]
name = "mount"
parent = "ground"
child = "crank"
stiffness = [[9, 0, 0, 0, 0, 0], [0, 9, 0, 2, 0, 0], [0, 0, 9, 0, 0, 0], [0, 0, 0, 9, 0, 0], [0, 0, 0, 0, 9, 0], [0, 0, 0, 0, 0, 9]]

[run])~",
       "12:13: error: bushing 'mount': 'stiffness' must be symmetric, but entries (2, 4) and (4, 2) differ: 2 and 0"},
      {"bushing_that_gives_energy", "[run]", R"~([[bushing]]
name = "mount"
parent = "ground"
child = "crank"
damping = [1, 2, 3, 4, -5, 6]

[run])~",
       "12:11: error: bushing 'mount': 'damping' must not give energy, but its smallest eigenvalue is -5, its largest "
       "6"},
      {"bushing_preload_of_three", "[run]", R"~([[bushing]]
name = "mount"
parent = "ground"
child = "crank"
stiffness = [1, 2, 3, 4, 5, 6]
preload = [1, 2, 3]

[run])~",
       "13:11: error: bushing 'mount': 'preload' must be a list of 6 numbers, found 3"},
      {"bushing_that_exerts_nothing", "[run]", R"~([[bushing]]
name = "mount"
parent = "ground"
child = "crank"

[run])~",
       "8:1: error: bushing 'mount': exerts nothing: give a 'stiffness', a 'damping' or a 'preload'"},
      {"joint_spring_on_a_ball", R"~(type = "spherical")~", R"~(type = "spherical"
spring.ball = { stiffness = 3 })~",
       "38:15: error: joint 'B' (spherical), spring: a ball has no spring: only a turn or a slide has; a force element "
       "between the bodies can resist all rotations"},
      {"joint_spring_on_a_word_that_is_not_there", "drive.slide_z", R"~(spring.turn_x = { stiffness = 3 }
drive.slide_z)~",
       "46:8: error: joint 'D' (cylindrical), spring: unknown key 'turn_x': did you mean 'turn_z'?"},
      {"joint_spring_a_number", "drive.slide_z", R"~(spring.turn_z = 3
drive.slide_z)~",
       "46:17: error: joint 'D' (cylindrical), spring: 'turn_z' must be a table, found a number"},
      {"joint_spring_that_exerts_nothing", "drive.slide_z", R"~(spring.turn_z = { free = "90 deg" }
drive.slide_z)~",
       "46:17: error: joint 'D' (cylindrical), spring, turn_z: exerts nothing: give a stiffness, a damping, a preload, "
       "a table, a stop or an actuator"},
      {"joint_spring_with_an_unknown_key", "drive.slide_z", R"~(spring.turn_z = { rate = 30 }
drive.slide_z)~",
       R"~(46:17: error: joint 'D' (cylindrical), spring, turn_z: exerts nothing: give a stiffness, a damping, a preload, a table, a stop or an actuator
46:19: error: joint 'D' (cylindrical), spring, turn_z: unknown key 'rate': known keys: stiffness, damping, preload, spring_table, damper_table, lower_stop, upper_stop, actuator, free)~"},
      {"joint_motor_with_a_missing_number", "drive.slide_z",
       R"~(spring.turn_z = { actuator = { law = "harmonic", frequency = 3 } }
drive.slide_z)~",
       "46:30: error: joint 'D' (cylindrical), spring, turn_z, actuator: missing key 'amplitude'"},
      {"link_without_length", R"~(type = "spherical")~", R"~(type = "distance")~",
       "35:1: error: joint 'B': missing key 'length' [m]: a distance joint has one"},
      {"link_of_negative_length", R"~(type = "spherical")~", R"~(type = "revolute_spherical"
length = "-L")~",
       "38:10: error: joint 'B': 'length' must be positive, found -0.3"},
      {"link_of_length_zero", R"~(type = "spherical")~", R"~(type = "universal_spherical"
length = 0)~",
       "38:10: error: joint 'B': 'length' must be positive, found 0"},
      {"length_where_there_is_none", R"~(type = "spherical")~", R"~(type = "spherical"
length = 0.2)~",
       "38:1: error: joint 'B': unknown key 'length': known keys: name, type, cut, start, drive, spring, parent, "
       "child, both"},
      {"start_of_an_arm", R"~(type = "spherical")~", R"~(type = "distance"
length = 0.2
start.arm = { guess = 0.2 })~",
       "39:7: error: joint 'B' (distance), start: unknown key 'arm': known keys: turn_x, turn_y, ball"},
      {"tire_on_ground", "[run]", R"~([[road]]
name = "track"
profile = "flat"
[[tire]]
name = "wheel"
body = "ground"
road = "track"
radius = 0.3
stiffness = 1e5
slip_stiffness = 1e4
cornering_stiffness = 1e4
friction = 1

[run])~",
       R"~(13:8: error: tire 'wheel': ground has no tire: it is the road; name a moving body)~"},
      {"tire_road_unknown", "[run]", R"~([[road]]
name = "track"
profile = "flat"
[[tire]]
name = "wheel"
body = "crank"
road = "trak"
radius = 0.3
stiffness = 1e5
slip_stiffness = 1e4
cornering_stiffness = 1e4
friction = 1

[run])~",
       R"~(14:8: error: tire 'wheel': unknown road 'trak': did you mean 'track'?)~"},
      {"tire_without_any_road", "[run]", R"~([[tire]]
name = "wheel"
body = "crank"
road = "track"
radius = 0.3
stiffness = 1e5
slip_stiffness = 1e4
cornering_stiffness = 1e4
friction = 1

[run])~",
       R"~(11:8: error: tire 'wheel': unknown road 'track': there are no roads)~"},
      {"tire_without_its_numbers", "[run]", R"~([[road]]
name = "track"
profile = "flat"
[[tire]]
name = "wheel"
body = "crank"

[run])~",
       R"~(11:1: error: tire 'wheel': missing key 'road'
11:1: error: tire 'wheel': missing key 'radius'
11:1: error: tire 'wheel': missing key 'stiffness'
11:1: error: tire 'wheel': missing key 'slip_stiffness'
11:1: error: tire 'wheel': missing key 'cornering_stiffness'
11:1: error: tire 'wheel': missing key 'friction')~"},
      {"tire_without_a_body", "[run]", R"~([[road]]
name = "track"
profile = "flat"
[[tire]]
name = "wheel"
road = "track"
radius = 0.3
stiffness = 1e5
slip_stiffness = 1e4
cornering_stiffness = 1e4
friction = 1

[run])~",
       R"~(11:1: error: tire 'wheel': missing key 'body')~"},
      {"tire_numbers_out_of_range", "[run]", R"~([[road]]
name = "track"
profile = "flat"
[[tire]]
name = "wheel"
body = "crank"
road = "track"
radius = 0
stiffness = -1
slip_stiffness = -2
cornering_stiffness = -3
friction = -4
damping = -5
speed_scale = 0

[run])~",
       R"~(15:10: error: tire 'wheel': 'radius' must be positive, found 0
16:13: error: tire 'wheel': 'stiffness' must be positive, found -1
17:18: error: tire 'wheel': 'slip_stiffness' must not be negative, found -2
18:23: error: tire 'wheel': 'cornering_stiffness' must not be negative, found -3
19:12: error: tire 'wheel': 'friction' must not be negative, found -4
20:11: error: tire 'wheel': 'damping' must not be negative, found -5
21:15: error: tire 'wheel': 'speed_scale' must be positive, found 0)~"},
      {"tire_with_an_unknown_key", "[run]", R"~([[road]]
name = "track"
profile = "flat"
[[tire]]
name = "wheel"
body = "crank"
road = "track"
radius = 0.3
stiffness = 1e5
slip_stiffness = 1e4
cornering_stiffness = 1e4
friction = 1
frction = 2

[run])~",
       R"~(20:1: error: tire 'wheel': unknown key 'frction': did you mean 'friction'?)~"},
      {"tire_on_a_road_at_fault_is_not_told_again", "[run]", R"~([[road]]
name = "track"
profile = "half_sine"
[[tire]]
name = "wheel"
body = "crank"
road = "track"
radius = 0.3
stiffness = 1e5
slip_stiffness = 1e4
cornering_stiffness = 1e4
friction = 1

[run])~",
       R"~(8:1: error: road 'track': missing key 'start'
8:1: error: road 'track': missing key 'length'
8:1: error: road 'track': missing key 'height')~"},
      {"road_without_a_name", "[run]", R"~([[road]]
profile = "flat"

[run])~",
       R"~(8:1: error: road: missing key 'name')~"},
      {"road_without_a_profile", "[run]", R"~([[road]]
name = "track"

[run])~",
       R"~(8:1: error: road 'track': missing key 'profile')~"},
      {"road_profile_unknown", "[run]", R"~([[road]]
name = "track"
profile = "half_sin"
length = 1

[run])~",
       R"~(10:11: error: road 'track': unknown profile 'half_sin': did you mean 'half_sine'?)~"},
      {"road_profile_a_number", "[run]", R"~([[road]]
name = "track"
profile = 3

[run])~",
       R"~(10:11: error: road 'track': 'profile' must be a string, found a number)~"},
      {"road_with_a_key_of_another_profile", "[run]", R"~([[road]]
name = "track"
profile = "flat"
length = 1

[run])~",
       R"~(11:1: error: road 'track': unknown key 'length': known keys: name, profile, height)~"},
      {"road_of_no_length", "[run]", R"~([[road]]
name = "track"
profile = "half_sine"
start = 1
length = 0
height = "half"

[run])~",
       R"~(12:10: error: road 'track': 'length' must be positive, found 0)~"},
      {"road_height_a_list", "[run]", R"~([[road]]
name = "track"
profile = "flat"
height = [1]

[run])~",
       R"~(11:10: error: road 'track': 'height' must be a number or an expression, found a list)~"},
      {"road_table_of_three_points", "[run]", R"~([[road]]
name = "track"
profile = "table"
x = [0, 1, 2]
height = [0, 1, 0]

[run])~",
       R"~(11:5: error: road 'track': a spline takes at least 4 points, found 3)~"},
      {"road_table_that_goes_back", "[run]", R"~([[road]]
name = "track"
profile = "table"
x = [0, 1, 1, 2]
height = [0, 1, 0, 1]

[run])~",
       R"~(11:5: error: road 'track': 'x' must rise, but after 1 m comes 1 m)~"},
      {"road_table_without_heights", "[run]", R"~([[road]]
name = "track"
profile = "table"
x = [0, 1, 2, 3]

[run])~",
       R"~(8:1: error: road 'track': missing key 'height')~"},
      {"roads_of_same_name", "[run]", R"~([[road]]
name = "track"
profile = "flat"
[[road]]
name = "track"
profile = "flat"

[run])~",
       R"~(12:8: error: road 'track': line 9 has the same name: choose another)~"},
      {"road_may_have_the_name_of_a_joint_but_not_be_a_table", "[run]", R"~([road]
name = "A"

[run])~",
       R"~(8:1: error: 'road' must be a list of tables, found a table: write [[road]])~"},
      {"coupling_without_terms", "[run]", R"~([[coupling]]
name = "gears"

[run])~",
       R"~(8:1: error: coupling 'gears': missing key 'terms')~"},
      {"coupling_of_one_term", "[run]", R"~([[coupling]]
name = "gears"
terms = [{ joint = "A", coordinate = "turn_z", factor = 2 }]

[run])~",
       R"~(10:9: error: coupling 'gears': a coupling relates at least two coordinates, found 1: write terms = [{ joint = "A", coordinate = "turn_z", factor = 1 }, ...])~"},
      {"coupling_terms_a_number", "[run]", R"~([[coupling]]
name = "gears"
terms = 3

[run])~",
       R"~(10:9: error: coupling 'gears': 'terms' must be a list of tables, found a number: write [[terms]]
10:9: error: coupling 'gears': a coupling relates at least two coordinates, found 0: write terms = [{ joint = "A", coordinate = "turn_z", factor = 1 }, ...])~"},
      {"coupling_without_a_name", "[run]", R"~([[coupling]]
terms = [{ joint = "A", coordinate = "turn_z", factor = 2 }, { joint = "D", coordinate = "turn_z", factor = -1 }]

[run])~",
       R"~(8:1: error: coupling: missing key 'name')~"},
      {"coupling_joint_unknown", "[run]", R"~([[coupling]]
name = "gears"
terms = [{ joint = "A", coordinate = "turn_z", factor = 2 },
{ joint = "Dd", coordinate = "turn_z", factor = -1 }]

[run])~",
       R"~(11:11: error: coupling 'gears', term 2: unknown joint 'Dd': known joints: A, B, D)~"},
      {"coupling_coordinate_unknown", "[run]", R"~([[coupling]]
name = "gears"
terms = [{ joint = "A", coordinate = "turn_z", factor = 2 },
{ joint = "D", coordinate = "turn_x", factor = -1 }]

[run])~",
       R"~(11:29: error: coupling 'gears', term 2: joint 'D' (cylindrical) has no coordinate 'turn_x': did you mean 'turn_z'?)~"},
      {"coupling_of_a_ball", "[run]", R"~([[coupling]]
name = "gears"
terms = [{ joint = "A", coordinate = "turn_z", factor = 2 },
{ joint = "B", coordinate = "ball", factor = 1 }]

[run])~",
       R"~(11:29: error: coupling 'gears', term 2: a ball cannot be coupled: only a turn or a slide can)~"},
      {"coupling_factor_zero", "[run]", R"~([[coupling]]
name = "gears"
terms = [{ joint = "A", coordinate = "turn_z", factor = 2 },
{ joint = "D", coordinate = "turn_z", factor = "L - 0.3" }]

[run])~",
       R"~(11:48: error: coupling 'gears', term 2: 'factor' must not be zero: leave the term out)~"},
      {"coupling_with_a_coordinate_twice", "[run]", R"~([[coupling]]
name = "gears"
terms = [{ joint = "A", coordinate = "turn_z", factor = 2 },
{ joint = "A", coordinate = "turn_z", factor = 2 }]

[run])~",
       R"~(11:1: error: coupling 'gears', term 2: this coordinate stands in the coupling already: add the factors)~"},
      {"coupling_term_without_factor", "[run]", R"~([[coupling]]
name = "gears"
terms = [{ joint = "A", coordinate = "turn_z", factor = 2 },
{ joint = "D", coordinate = "turn_z", facto = 1 }]

[run])~",
       R"~(11:1: error: coupling 'gears', term 2: missing key 'factor'
11:39: error: coupling 'gears', term 2: unknown key 'facto': did you mean 'factor'?)~"},
      {"coupling_of_the_name_of_a_joint", "[run]", R"~([[coupling]]
name = "D"
offset = "half"
terms = [{ joint = "A", coordinate = "turn_z", factor = 2 }, { joint = "D", coordinate = "turn_z", factor = -1 }]

[run])~",
       R"~(9:8: error: coupling 'D': line 47 has the same name: choose another)~"},
      {"include_without_a_file", "[run]", R"~([[include]]
prefix = "a_"

[run])~",
       R"~(8:1: error: include: missing key 'file')~"},
      {"include_of_no_file", "[run]", R"~([[include]]
file = "nowhere/x.toml"

[run])~",
       R"~(9:8: error: include: there is no file 'nowhere/x.toml')~"},
      {"include_with_an_unknown_key", "[run]", R"~([[include]]
file = "nowhere/x.toml"
prefx = "a"

[run])~",
       R"~(9:8: error: include: there is no file 'nowhere/x.toml'
10:1: error: include: unknown key 'prefx': did you mean 'prefix'?)~"},
      {"include_parameters_a_number", "[run]", R"~([[include]]
file = "x.toml"
parameters = 3

[run])~",
       R"~(9:8: error: include: there is no file 'x.toml'
10:14: error: include: 'parameters' must be a table, found a number)~"},
      {"five_faults_of_forces_at_once", "[run]", R"~([[load]]
name = "push"
body = "crnk"
force = [1, 2]
[[turn_spring]]
name = "helix"
parent = "ground"
child = "crank"
damping = -1
upper_stop = { at = 1 }

[run])~",
       R"~(10:8: error: load 'push': unknown body 'crnk': did you mean 'crank'?
11:9: error: load 'push': 'force' must be a list of 3 numbers, found 2
16:11: error: turn_spring 'helix': 'damping' must not be negative, found -1
17:14: error: turn_spring 'helix', upper_stop: missing key 'stiffness'
17:14: error: turn_spring 'helix', upper_stop: missing key 'width')~"},
      {"three_faults_at_once",
       R"~(mass = 0.36
center_of_mass = ["half", 0, 0])~",
       R"~(mass = -1
center_of_mass = ["hlf", 0, 0]
color = 1)~",
       R"~(13:8: error: body 'crank': 'mass' must be positive, found -1
14:19: error: body 'crank': entry 1 of 'center_of_mass': unknown name 'hlf' in 'hlf': did you mean 'half'?
15:1: error: body 'crank': unknown key 'color': known keys: name, mass, center_of_mass, inertia, beam, modes_file, start)~"},
  };
  return kBroken;
}

}  // namespace concord
