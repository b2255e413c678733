#pragma once

#include <array>
#include <string>

#include "common/types.h"

namespace concord {
struct Model;
struct Trajectory;
}  // namespace concord

/// How far two runs' motions agree.
namespace concord::compare {

class QuantityLayout;

/// The tightest integration holds a motion to 1e-13 of its size (kTightestRepeat): so many units of round-off of a
/// state does its end differ by.
inline constexpr double kUnitsOfARun = 450.0;

/// Angle between two orientations, of A1^T A2 [rad], accurate near zero.
double angle_between(const Mat3& A1, const Mat3& A2);

/// What an integration leaves open of speeds in each sample of a run (columns): of body i's velocity in row 2 i [m/s],
/// of its angular velocity in the next [rad/s], and after those of all bodies of their modal rates [1/s]. Where the
/// body's acceleration is known no better than `resolution` (of a run: see resolution_of_run) because its place is not
/// (kUnitsOfARun), as on a stiff spring, the two give the square of a frequency: what is open of the place, times that
/// frequency, is what is open of its speed. So does what a mode's acceleration resolves, in a loop that holds the mode
/// stiffer than it is alone. Zero where the resolution is not known.
MatX noise_of_speeds(const QuantityLayout& layout, const MatX& resolution, const Trajectory& run);

/// Agreement of motions over two aligned trajectories: the worst of body origins (relative to the machine's length, or
/// to the farthest that a body comes from its start), orientations (rad), velocities and angular velocities (relative
/// to the largest of the run), and modal coordinates (relative to the body's largest). What hardly moves is compared
/// with a thousandth of what the machine's length, gravity and the time of the run give. What the round-off of places
/// explains is no difference: of speeds it is `noise` (noise_of_speeds), if that is given.
struct MotionAgreement {
  double digits = 16.0;
  double t = 0.0;
  std::string worst;  // "origin of coupler", "orientation of crank", ...
};
MotionAgreement compare_motions(const Model& model, const std::array<const Trajectory*, 2>& trajectories,
                                const MatX& noise = {});

}  // namespace concord::compare
