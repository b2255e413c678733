#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "compare/quantities/agreement.h"
#include "compare/quantities/observe.h"

/// The largest forces of a run, for its reader. Never judged.
namespace concord::compare {

/// The first value over a run whose size is within 1e-6 of the largest, its time [s], and the root mean square over all
/// samples.
struct Peak {
  double value = 0.0;
  double t = 0.0;
  double root_mean_square = 0.0;
};

/// The peak of |F| or |T| of a wrench [N, N m], or of a force along a coordinate and of the power that it delivers [W].
struct ForcePeak {
  bool exists = false;  // not where a joint carries no component of it, of a coupling's power, without a run
  /// "xy": the components that it holds where others are not unique; "part": what of the vector is; empty: all.
  std::string axes;
  std::optional<Peak> value;  // missing where it is not unique
  /// In the axes of a body each component by itself, with its sign; missing where it is not unique in most samples.
  std::array<std::optional<Peak>, 3> components = {};
};

/// What a row of a table of forces tells: the peaks of |F| and |T| of a joint's reaction or a force element's wrench on
/// a side, or the peaks of force and power of a driver, motor, spring, damper or coupling.
struct ForcePeaks {
  Quantity of;  // of a wrench its first component
  std::array<ForcePeak, 2> parts;
};

/// Of all joints and sides, force elements and sides, and forces along coordinates, in the layout's order. A force
/// along a coordinate that several exert stands by its shares only. `run`: nullptr where there is none. `unique`: the
/// layout's quantities in the samples of the run, nullptr: all unique. A component that is open in most samples is left
/// out of |F| or |T|; samples in which one of the others is open count for nothing. Joints that carry nothing have no
/// row; what is 1e-14 of the machine's largest force (times its length), or less, is round-off and told as zero.
/// `axes`: those in which components of wrenches are told, see told_axes().
std::vector<ForcePeaks> force_peaks(const QuantityLayout& layout, const Trajectory* run, const Mask* unique,
                                    std::optional<int> axes = {});

/// The wrench of which a quantity of a reaction or a force element is a component, in the frame of its side.
const Wrench& wrench_of(const Quantity& of, const Sample& sample);

/// A run with its wrenches in the axes of a body, and what of it is unique: a component is where all that has a part of
/// it in the frame of its side is. Where something is not unique, NaN may stand.
struct ToldRun {
  Trajectory run;
  Mask unique;
};
ToldRun told_in(const QuantityLayout& layout, const Trajectory& run, const Mask* unique, int axes);

}  // namespace concord::compare
