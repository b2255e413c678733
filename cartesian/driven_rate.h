#pragma once

#include "common/model.h"

namespace concord::cartesian {

/// The largest rate at which a driver moves its coordinate, at any time, over the machine's length or a radian [1/s];
/// zero without drivers. What a machine that its drivers have brought to rest is measured by.
double rate_of_drivers(const Model& model);

}  // namespace concord::cartesian
