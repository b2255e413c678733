#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "common/types.h"

/// How far two solvers agree on each quantity over one check.
namespace concord::compare {

class QuantityLayout;
struct Series;

/// A scale is never smaller than this part of the machine's largest of its kind.
inline constexpr double kScaleFloor = 1e-6;

/// A difference within so many resolutions is round-off.
inline constexpr double kWithinResolution = 20.0;
/// A difference in the same state beyond this many resolutions is a difference whatever the need, unless the model
/// lowered it. Differences of sound solvers on the random machines of `concord fuzz` stay below a tenth of it, and most
/// slips in a parameter show there first.
inline constexpr double kBeyondRoundOff = 200.0;
/// Where kWithinResolution resolutions exceed this part of the scale, a row is unresolved; where they also exceed this
/// part of the machine's largest of its kind, it is not judged.
inline constexpr double kCoarsest = 1e-6;

/// Where a scale comes from.
enum class ScaleSource {
  own_peak,  // the largest of the kind that the joint, element or body has: |F|, |T|, |vdot| ...
  lever,     // the peak force times the machine's length, or peak turning times it
  gravity,   // of an acceleration: g
  floor      // kScaleFloor of the machine's largest, loads of bodies included
};
/// "peak", "F l", "g", "floor".
const char* name_of(ScaleSource source);

/// For each quantity (rows) and sample (columns) whether it is judged there.
using Mask = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic>;

/// What a difference is compared with besides the need: the resolution of each quantity in each sample, NaN where it is
/// unknown, and the samples in which it is unique. Null: unknown everywhere; unique everywhere.
struct Budget {
  const MatX* resolution = nullptr;
  const Mask* judged = nullptr;
};

/// One quantity over all samples in which it is judged.
struct Measured {
  double scale = 0.0;    // in the quantity's unit
  double machine = 0.0;  // the machine's largest of its kind
  ScaleSource source = ScaleSource::own_peak;
  double difference = 0.0;  // the largest
  /// The largest difference that exceeds kWithinResolution resolutions of its sample; zero if none does.
  double unexplained = 0.0;
  /// The largest resolution; NaN where none is known.
  double resolution = std::numeric_limits<double>::quiet_NaN();
  /// The largest ratio of a difference to its resolution; 0 where none is known.
  double ratio = 0.0;
  int samples = 0;          // in which it is judged
  int not_unique = 0;       // samples in which it is not
  int too_coarse = 0;       // samples left out because double precision resolves too little
  bool unresolved = false;  // in some sample kWithinResolution resolutions exceed kCoarsest of the scale
  std::size_t worst = 0;    // sample of the largest unexplained difference, or of the largest
  double t = 0.0;           // its time [s]
  std::array<double, 2> values{};
  double digits = 16.0;              // of the largest difference
  double unexplained_digits = 16.0;  // of the largest unexplained one: this is judged
};

/// A failing quantity in words: "joint D on slider, T_z, t = ...", and what it looks like.
struct Finding {
  std::string what;
  std::string symptom;
};

/// One entry for each row of the series. Scale of a force: the joint's peak |F| over the series, the larger of both
/// solvers'; of a torque: max(peak |T|, peak |F| l), l the machine's length; both floored by kScaleFloor of the
/// machine's largest wrench or load m (|g| + max(|vdot|, |omegadot| k, |omega|^2 k)), k its radius of gyration. A force
/// on a joint speed takes the scale of its joint's total wrench, or its own peak if larger, that of a coupling the
/// largest of its joints' divided by their factors; a force element's wrench its own; a body's sum that of the largest
/// wrench in it; an acceleration the body's max(|vdot|, |omegadot| l, |omega|^2 l, g), g because the forces on a body
/// at rest are those that keep it from falling; angular the same over l; modal accelerations the body's largest.
std::vector<Measured> measure(const QuantityLayout& layout, const Series& series, const Budget& budget = {});

}  // namespace concord::compare
