#include "common/joints/named_coordinates.h"

#include <fmt/format.h>

#include <algorithm>

namespace concord {

std::vector<NamedCoordinate> named_coordinates(const joints::JointType& type) {
  std::vector<NamedCoordinate> coordinates;
  const auto add = [&](const joints::StatedCoordinate& stated, int word, int component) {
    const auto is_taken = [&](const std::string& name) {
      return std::any_of(coordinates.begin(), coordinates.end(), [&](const auto& one) { return one.name == name; });
    };
    std::string name(stated.name);
    for (int number = 2; is_taken(name); ++number) name = fmt::format("{}{}", stated.name, number);
    coordinates.push_back({name, word, component, static_cast<int>(coordinates.size()), stated.kind, stated.axis});
  };
  for (int word = 0; word < static_cast<int>(type.permits.size()); ++word) {
    const joints::StatedCoordinates stated = stated_coordinates(type.permits[word]);
    for (int component = 0; component < stated.size(); ++component) add(stated[component], word, component);
  }
  return coordinates;
}

}  // namespace concord
