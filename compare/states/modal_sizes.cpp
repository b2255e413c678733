#include "compare/states/modal_sizes.h"

#include "compare/audit/free_body.h"

namespace concord::compare {

VecX largest_deflections(const Body& body) {
  const VecX largest = largest_displacements(body);
  return (largest.array() > 0.0).select(largest, 1.0);
}

VecX modal_sizes(const Model& model, std::size_t body) {
  VecX sizes = largest_deflections(model.bodies[body]) / model.length_scale();
  const auto add = [&](const Attachment* end) {
    if (end == nullptr || static_cast<std::size_t>(end->body) != body || end->Psi_r_L.cols() != sizes.size()) return;
    sizes = sizes.cwiseMax(VecX(end->Psi_r_L.colwise().norm().transpose()));
  };
  for (const Side side : kSides) {
    for (const Joint& joint : model.joints) add(&joint.on(side));
    for (const ForceElement& element : model.elements) add(end_of(element, side));
  }
  return sizes;
}

}  // namespace concord::compare
