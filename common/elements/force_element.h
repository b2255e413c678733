#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/elements/bushing.h"
#include "common/elements/line_spring.h"
#include "common/elements/load.h"
#include "common/elements/tire.h"
#include "common/elements/turn_spring.h"
#include "common/error.h"

/// Force elements: what pushes and pulls on bodies and is no joint. Each is a statement, on a page of its own; the
/// solvers turn it into generalized forces by virtual work (S20). Ends are places on bodies with frames, as for joints,
/// and move with the modes: A' = A R(theta) C is the end's frame.
namespace concord {

/// All kinds. A new one has its page and its place here; what must have a clause for each does not compile without it.
using AnyElement = std::variant<Load, LineSpring, TurnSpring, Bushing, Tire>;

struct ForceElement {
  std::string name;
  AnyElement what;
  SourceLocation where;
};

/// Its ends, two or one; the child's comes last.
elements::Ends<Attachment> ends_of(ForceElement& element);
elements::Ends<const Attachment> ends_of(const ForceElement& element);

/// The element's end on `side`; one with one end has only that of the child, its one body.
const Attachment* end_of(const ForceElement& element, Side side);

/// The table that states the element in a model file, "line_spring"; and of all kinds, in their order.
std::string_view key_of(const ForceElement& element);
const std::vector<std::string_view>& element_keys();

/// Calls `visit` with each quantity of the element, as facts.h has them.
template <class Element, class Visit>
void each_quantity(Element& element, const Visit& visit) {
  std::visit([&](auto& one) { one.each_quantity(one, visit); }, element.what);
}

/// What the element's kind says of itself.
elements::EndAxes end_axes_of(const ForceElement& element);
bool has_sides_alike(const ForceElement& element);

}  // namespace concord
