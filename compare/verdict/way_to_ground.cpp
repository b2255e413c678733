#include "compare/verdict/way_to_ground.h"

#include <algorithm>

namespace concord::compare {

std::vector<int> depths(const Model& model) {
  const auto n = static_cast<int>(model.bodies.size());
  std::vector<int> depth(model.bodies.size(), n);
  depth[kGround] = -1;
  for (bool is_found = true; is_found;) {
    is_found = false;
    for (const Joint& joint : model.joints) {
      const int parent = joint.on(Side::parent).body;
      const int child = joint.on(Side::child).body;
      const int least = std::min(depth[parent], depth[child]) + 1;
      for (const int body : {parent, child}) {
        if (depth[body] <= least) continue;
        depth[body] = least;
        is_found = true;
      }
    }
  }
  return depth;
}

std::optional<std::pair<int, int>> near_and_far(const Joint& joint, const std::vector<int>& depth) {
  const auto [near, far] = std::minmax(joint.on(Side::parent).body, joint.on(Side::child).body,
                                       [&](int one, int other) { return depth[one] < depth[other]; });
  if (near == kGround || depth[near] == depth[far]) return std::nullopt;
  return std::pair<int, int>(near, far);
}

}  // namespace concord::compare
