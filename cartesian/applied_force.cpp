#include "cartesian/applied_force.h"

namespace concord::cartesian {

Wrench opposite(const Wrench& on_child, const Vec3& gap) {
  return {-on_child.force, -(on_child.torque + gap.cross(on_child.force))};
}

}  // namespace concord::cartesian
