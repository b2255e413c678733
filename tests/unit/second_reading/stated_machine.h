#pragma once

#include <filesystem>
#include <fstream>
#include <string>

namespace concord::second_reading {

/// A machine that states something of every kind, in frames that nothing is parallel to. It need not move.
inline const std::string kStatedMachine = R"(
format = 1
gravity = [0.3, "-g", 1.1]
[parameters]
g = 9.81
L = "2*half"
half = 0.4
tilt = "25 deg"

[[body]]
name = "rod"
mass = "3*L"
center_of_mass = [0.1, "-L/4", 0.03]
inertia = [0.31, 0.42, 0.53, 0.011, -0.022, 0.033]
start.pose = { origin = [0.1, 0.2, 0.3], sequence = "xyz", angles = [0.1, "20 deg", -0.3] }

[[body]]
name = "plate"
mass = 1.5
inertia = [0.2, 0.3, 0.4]

[[body]]
name = "blade"
start.a = [0.001, 0.002, 0.003, 0.004]
start.adot = [0.1, 0, 0, -0.1]
[body.beam]
first_end = [0.05, 0.01, -0.02]
y = [0, 2, 1]
z = [0, -1, 2]
length = "L"
elements = 8
section = { width_y = 0.03, width_z = 0.004 }
youngs_modulus = 7.0e10
poissons_ratio = 0.33
density = 2700
support = "cantilever"
modes = { bending_xz = [1, 2], bending_xy = [1], torsion = [1] }
damping_ratio = 0.01

[[body]]
name = "tube"
[body.beam]
axis = [1, 2, 3]
angle = "tilt"
length = 0.5
section = { diameter = 0.03, inner_diameter = 0.02 }
youngs_modulus = 2.1e11
shear_modulus = 8e10
density = 7800
support = "craig_bampton"
modes = { bending_xy = [2, 1] }
static_modes = { torsion = [1], axial = [1], bending_xy = [1], bending_xz = [2] }

[[body]]
name = "panel"
modes_file = "panel.toml"

[[body]]
name = "wheel"
mass = 9
inertia = [0.2, 0.3, 0.2]

[[joint]]
name = "hinge"
type = "revolute"
both = { point = [0.1, 0.2, 0.3], z = [1, 1, 0], x = [0, 0, 2] }
parent = "ground"
child = "rod"
cut = true
drive.turn_z = { law = "smooth_step", t0 = 0.1, t1 = 0.5, from = 0.2, to = "pi/3" }
spring.turn_z = { stiffness = 3, free = "15 deg", preload = 0.2, damping = 0.7 }

[[joint]]
name = "thread"
type = "screw"
lead = 0.02
parent = { body = "rod", point = [0, "L", 0], euler_parameters = [2, 1, -1, 3] }
child = { body = "plate", rotation_vector = [0.3, -0.2, 0.5] }
start.turn = { guess = "370 deg", keep_speed = 3 }

[[joint]]
name = "rod_of_air"
type = "distance"
length = 0.35
parent = { body = "plate", x = [1, 1, 1], y = [1, -1, 0] }
child = { body = "blade", node = "3", offset = [0.01, -0.02, 0.03], axis = [0, 1, 1], angle = 0.4 }
start.ball = { keep = { axis = [1, 0, 2], angle = 2.5 }, guess_speed = [1, 2, 3] }
start.turn_x = { keep = 0.3 }

[[joint]]
name = "cross"
type = "universal"
parent = { body = "blade", node = "last" }
child = { body = "tube", node = "first", offset = [-0.02, 0, 0.01] }
[joint.spring.turn_y]
damper_table = { x = [-5, -1, 0, 1, 5], force = [-0.4, -0.15, 0, 0.1, 0.3] }
upper_stop = { at = "50 deg", stiffness = 200, damping = 0.5, width = "5 deg" }
lower_stop = { at = -0.5, stiffness = 100, width = 0.1 }
actuator = { law = "spline", times = [0, 1, 2, 3], values = [0, 0.2, 0.1, 0.4] }

[[joint]]
name = "seat"
type = "cylindrical"
parent = { body = "tube", node = "last" }
child = { body = "panel", node = "tip", offset = [0.1, 0, -0.2], sequence = "zyx", angles = ["80 deg", 0.4, -0.2] }

[[joint]]
name = "roller"
type = "rolling_ball"
radius = 0.3
parent = "ground"
child = "wheel"

[[joint]]
name = "glue"
type = "weld"
parent = { body = "panel", node = "tip" }
child = "plate"

[[coupling]]
name = "mesh"
terms = [{ joint = "seat", coordinate = "turn_z", factor = 1 }, { joint = "hinge", coordinate = "turn_z", factor = -3 }]
offset = "30 deg"

[[load]]
name = "wind"
body = "rod"
point = [0, 0.25, 0]
axis = [0, 0, 1]
angle = 0.3
force = [1, -2, 0.5]
torque = [0.1, 0.2, 0.3]
axes = "follower"
law = { law = "harmonic", offset = 1, amplitude = 0.5, frequency = 7, phase = 0.3 }

[[load]]
name = "push"
body = "panel"
node = "tip"
force = [1, 0, 0]

[[line_spring]]
name = "coil"
parent = { body = "ground", point = [0.2, 0.3, 0.1] }
child = { body = "blade", node = "first", offset = [0.1, 0.2, 0.3] }
stiffness = 120
free = 0.2
spring_table = { x = [-2, -1, 1, 2], force = [-8, -1, 1, 8] }
actuator = 4

[[turn_spring]]
name = "helix"
both = { z = [0, 1, 0], x = [1, 0, 0] }
parent = "rod"
child = "plate"
damping = 0.5
actuator = { law = "polynomial", coefficients = [1, 2, 3] }

[[bushing]]
name = "mount"
parent = { body = "ground", point = [0.35, 0.1, 0], axis = [1, 1, 0], angle = "20 deg" }
child = { body = "plate", point = [0, 0.1, 0] }
stiffness = [[20, 1, 2, 0, 0, 0.1], [1, 30, 0, 0, 0, 0], [2, 0, 25, 0, 0, 0],
             [0, 0, 0, 0.4, 0, 0], [0, 0, 0, 0, 0.3, 0.01], [0.1, 0, 0, 0, 0.01, 0.2]]
damping = [[4, 0.5, 0, 0, 0, 0], [0.5, 5, 0, 0, 0, 0], [0, 0, 3, 0, 0, 0],
           [0, 0, 0, 0.4, 0, 0.05], [0, 0, 0, 0, 0.3, 0], [0, 0, 0, 0.05, 0, 0.2]]
preload = [0, 1, 0, 0, 0, 0.1]

[[road]]
name = "bump"
profile = "half_sine"
start = 0.3
length = 0.4
height = 0.01

[[road]]
name = "hills"
profile = "table"
x = [0, 1, 2, 4]
height = [0, 0.1, 0, 0.2]

[[tire]]
name = "tire"
body = "wheel"
point = [0, 0.01, 0]
road = "bump"
radius = 0.3
stiffness = 1.5e5
damping = 100
slip_stiffness = 3e4
cornering_stiffness = 2e4
friction = 0.9
speed_scale = 0.2

[[tire]]
name = "spare"
body = "wheel"
road = "hills"
radius = 0.3
stiffness = 1.5e5
slip_stiffness = 3e4
cornering_stiffness = 2e4
friction = 0.9

[run]
until = 3
samples = 400
start = "equilibrium"

[[need]]
joint = "hinge"
component = "T_z"
same_run = 6
because = "shown as an example"
)";

inline const std::string kStatedPanel = R"(
format = 1
modes = 2
stiffness = [[400, 30], [30, 900]]
damping_ratios = [0.02, 0.05]

[[mass_point]]
mass = 0.2
point = [0.3, 0, 0]
Psi_t = [[0, 0.1], [1, 0.2], [0, -0.3]]

[[mass_point]]
mass = 0.4
point = [0, 0.2, 0.1]
Psi_t = [[0.3, -0.1], [0.5, 0.2], [0.1, -0.3]]

[[mass_point]]
mass = 0.5
point = [0, 0, 0.02]
Psi_t = [[0, 0], [-0.1, 0], [0, 0.7]]
inertia = [1.1e-3, 2.1e-3, 2.3e-3, 1e-4, -2e-4, 3e-4]
Psi_r = [[0, 0.5], [0.1, 0], [3.0, 0.2]]

[[node]]
name = "tip"
point = [0.3, 0, 0]
Psi_t = [[0, 0.1], [1, 0.2], [0, -0.3]]
Psi_r = [[0, 0.4], [0.2, 0], [3.5, 0.1]]

[[node]]
name = "edge"
point = [0, 0.2, 0.1]
Psi_t = [[0.3, -0.1], [0.5, 0.2], [0.1, -0.3]]
Psi_r = [[0, 0.5], [0.3, 0], [2.5, 0.2]]
)";

/// Writes a file of a test into its folder and gives its path.
inline std::filesystem::path write_file(const std::filesystem::path& folder, const std::string& name,
                                        const std::string& text) {
  std::filesystem::create_directories(folder);
  std::ofstream(folder / name) << text;
  return folder / name;
}

/// A text with one passage replaced by another.
inline std::string with(std::string text, const std::string& passage, const std::string& other) {
  return text.replace(text.find(passage), passage.size(), other);
}

}  // namespace concord::second_reading
