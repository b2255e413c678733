#include "cartesian/driven_rate.h"

#include <algorithm>

#include "common/joints/facts.h"

namespace concord::cartesian {

double rate_of_drivers(const Model& model) {
  const double length = model.length_scale();
  double largest = 0.0;
  for (const Joint& joint : model.joints) {
    for (const Driver& driver : joint.drivers) {
      const bool slides = joints::is_length(joint.type->permits[driver.word], driver.component);
      largest = std::max(largest, typical_rate(driver.law, slides ? length : 1.0));
    }
  }
  return largest;
}

}  // namespace concord::cartesian
