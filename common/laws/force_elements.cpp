#include "common/laws/force_elements.h"

#include "common/overloaded.h"

namespace concord {

const Attachment* end_of(const ForceElement& element, Side side) {
  const auto on_child = [side](const Attachment& end) { return side == Side::child ? &end : nullptr; };
  return std::visit(Overloaded{[&](const Load& load) -> const Attachment* { return on_child(load.at); },
                               [&](const Tire& tire) -> const Attachment* { return on_child(tire.wheel); },
                               [&](const auto& spring) { return &spring.ends[index(side)]; }},
                    element.what);
}

}  // namespace concord
