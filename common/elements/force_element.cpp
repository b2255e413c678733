#include "common/elements/force_element.h"

namespace concord {

namespace {

template <class... Kinds>
std::vector<std::string_view> keys_of(std::type_identity<std::variant<Kinds...>> /*all*/) {
  return {Kinds::kKey...};
}

}  // namespace

std::span<Attachment> ends_of(ForceElement& element) {
  return std::visit([](auto& one) -> std::span<Attachment> { return one.ends_of(one); }, element.what);
}

std::span<const Attachment> ends_of(const ForceElement& element) {
  return std::visit([](const auto& one) -> std::span<const Attachment> { return one.ends_of(one); }, element.what);
}

const Attachment* end_of(const ForceElement& element, Side side) {
  const std::span<const Attachment> ends = ends_of(element);
  if (side == Side::child) return &ends.back();
  return ends.size() == 2 ? &ends.front() : nullptr;
}

std::string_view key_of(const ForceElement& element) { return element_keys()[element.what.index()]; }

const std::vector<std::string_view>& element_keys() {
  static const std::vector<std::string_view> kKeys = keys_of(std::type_identity<AnyElement>{});
  return kKeys;
}

}  // namespace concord
