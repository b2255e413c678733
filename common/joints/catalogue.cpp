#include "common/joints/catalogue.h"

#include "common/joints/cylindrical.h"
#include "common/joints/distance.h"
#include "common/joints/free.h"
#include "common/joints/knife_edge.h"
#include "common/joints/revolute.h"
#include "common/joints/revolute_spherical.h"
#include "common/joints/rolling_ball.h"
#include "common/joints/screw.h"
#include "common/joints/spherical.h"
#include "common/joints/translational.h"
#include "common/joints/universal.h"
#include "common/joints/universal_spherical.h"
#include "common/joints/weld.h"

namespace concord::joints {

const std::vector<const JointType*>& catalogue() {
  static const std::vector<const JointType*> types = [] {
    std::vector<const JointType*> all{
        &weld,     &revolute,           &translational,       &cylindrical, &spherical,  &universal,    &free,
        &distance, &revolute_spherical, &universal_spherical, &screw,       &knife_edge, &rolling_ball,
    };
    for (const JointType* extra : extra_types()) all.push_back(extra);
    return all;
  }();
  return types;
}

const JointType* find(std::string_view name) {
  for (const JointType* type : catalogue()) {
    if (type->name == name) return type;
  }
  return nullptr;
}

}  // namespace concord::joints
