#include "common/elements/force_element.h"

#include <concepts>
#include <type_traits>

namespace concord {

namespace {

/// What a page must declare.
template <class Element>
concept StatesFacts = requires(Element& element, const Element& stated) {
  { Element::kKey } -> std::convertible_to<std::string_view>;  // the table in the model file
  { Element::kEndAxes } -> std::convertible_to<elements::EndAxes>;
  { Element::kSidesAlike } -> std::convertible_to<bool>;  // parent and child may change places
  { Element::ends_of(element) } -> std::same_as<elements::Ends<Attachment>>;
  { Element::ends_of(stated) } -> std::same_as<elements::Ends<const Attachment>>;
  Element::each_quantity(stated, elements::IgnoreQuantity{});
};

template <class... Kinds>
constexpr bool state_facts(std::type_identity<std::variant<Kinds...>> /*all*/) {
  return (StatesFacts<Kinds> && ...);
}
static_assert(state_facts(std::type_identity<AnyElement>{}), "a page of common/elements lacks facts");

template <class... Kinds>
std::vector<std::string_view> keys_of(std::type_identity<std::variant<Kinds...>> /*all*/) {
  return {Kinds::kKey...};
}

}  // namespace

elements::Ends<Attachment> ends_of(ForceElement& element) {
  return std::visit([](auto& one) -> elements::Ends<Attachment> { return one.ends_of(one); }, element.what);
}

elements::Ends<const Attachment> ends_of(const ForceElement& element) {
  return std::visit([](const auto& one) -> elements::Ends<const Attachment> { return one.ends_of(one); }, element.what);
}

const Attachment* end_of(const ForceElement& element, Side side) {
  const elements::Ends<const Attachment> ends = ends_of(element);
  if (side == Side::child) return &ends.back();
  return ends.size() == 2 ? &ends.front() : nullptr;
}

std::string_view key_of(const ForceElement& element) { return element_keys()[element.what.index()]; }

const std::vector<std::string_view>& element_keys() {
  static const std::vector<std::string_view> kKeys = keys_of(std::type_identity<AnyElement>{});
  return kKeys;
}

elements::EndAxes end_axes_of(const ForceElement& element) {
  return std::visit([](const auto& one) { return one.kEndAxes; }, element.what);
}

bool has_sides_alike(const ForceElement& element) {
  return std::visit([](const auto& one) { return one.kSidesAlike; }, element.what);
}

}  // namespace concord
