#include "common/force_elements.h"

namespace concord {

const Attachment* end_of(const ForceElement& element, Side side) {
  if (const auto* load = std::get_if<Load>(&element.what)) return side == Side::child ? &load->at : nullptr;
  return std::visit(
      [side](const auto& what) -> const Attachment* {
        if constexpr (requires { what.ends; }) return &what.ends[index(side)];
        return nullptr;
      },
      element.what);
}

}  // namespace concord
