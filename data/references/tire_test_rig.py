#!/usr/bin/env python3
"""What the tire of models/tire_test_rig.toml must do, from the statement in data/format alone; writes
tire_test_rig.csv. The wheel's motion is prescribed, so that no equation of motion is solved."""
from math import cos, pi, radians, sin, sqrt

SPEED, HEIGHT, CAMBER, ROAD = 15.0, 0.29, radians(4), 0.01
RADIUS, STIFFNESS, SLIP, CORNERING, FRICTION, SCALE = 0.3, 2.0e5, 4.5e4, 3.8e4, 0.85, 0.1


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def times(factor, a):
    return [factor * x for x in a]


def steer(t):
    """The angle of the fork and its rate: 35 z^4 - 84 z^5 + 70 z^6 - 20 z^7, level to the third derivative at both ends."""
    z = min(max((t - 0.1) / 1.3, 0.0), 1.0)
    share = z**4 * (35 + z * (-84 + z * (70 - 20 * z)))
    rate = 140 * z**3 * (1 - z) ** 3 / 1.3
    return 14 * pi / 180 * share, 14 * pi / 180 * rate


def wrench(t):
    """Force and torque about the wheel's centre, in the axes of ground."""
    angle, turning = steer(t)
    spin = 56 - 18 * t * t
    axle = [-sin(angle) * cos(CAMBER), cos(angle) * cos(CAMBER), sin(CAMBER)]
    velocity = [SPEED, 0.0, 0.0]
    omega = [spin * axle[0], spin * axle[1], spin * axle[2] + turning]
    normal = [0.0, 0.0, 1.0]
    distance = HEIGHT - ROAD
    forward = cross(axle, normal)
    forward = times(1 / sqrt(dot(forward, forward)), forward)
    sideways = cross(normal, forward)
    V_x, V_y = dot(velocity, forward), dot(velocity, sideways)
    rim = cross(omega, times(-distance, normal))  # velocity of the contact against the centre
    s_x = V_x + dot(rim, forward)
    V = sqrt(V_x**2 + SCALE**2)
    N = STIFFNESS * (RADIUS - distance)
    F_x, F_y = -SLIP * s_x / V, -CORNERING * V_y / V
    grip = FRICTION * N / sqrt(F_x**2 + F_y**2)
    if grip < 1:
        F_x, F_y = grip * F_x, grip * F_y
    force = [N * n + F_x * f + F_y * s for n, f, s in zip(normal, forward, sideways)]
    return force + cross(times(-distance, normal), force)


with open("tire_test_rig.csv", "w", encoding="utf-8") as file:
    file.write("# The tire of models/tire_test_rig.toml in closed form, by tire_test_rig.py.\n# error = 1e-8 %\n")
    names = ["F_x [N]", "F_y [N]", "F_z [N]", "T_x [N m]", "T_y [N m]", "T_z [N m]"]
    file.write("t [s]," + ",".join("tire.child.global." + name for name in names) + "\n")
    for k in range(0, 81, 4):
        t = 1.6 * k / 80
        file.write(f"{t:.17g}," + ",".join(f"{x:.17g}" for x in wrench(t)) + "\n")
