#include "common/joints/named_coordinates.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <variant>

namespace concord {

namespace {

constexpr std::string_view kAxisLetters = "xyz";

std::string base_name(const joints::Permit& word) {
  if (const auto* turn = std::get_if<joints::Turn>(&word)) {
    return std::string("turn_") + kAxisLetters[index(turn->axis)];
  }
  if (const auto* slide = std::get_if<joints::Slide>(&word)) {
    return std::string("slide_") + kAxisLetters[index(slide->axis)];
  }
  return "ball";
}

}  // namespace

std::vector<NamedCoordinate> named_coordinates(const joints::JointType& type) {
  std::vector<NamedCoordinate> coordinates;
  const auto add = [&](const std::string& base, int word, int component) {
    const auto is_taken = [&](const std::string& name) {
      return std::any_of(coordinates.begin(), coordinates.end(), [&](const auto& one) { return one.name == name; });
    };
    std::string name = base;
    for (int number = 2; is_taken(name); ++number) name = fmt::format("{}{}", base, number);
    coordinates.push_back({name, word, component, static_cast<int>(coordinates.size())});
  };
  for (int word = 0; word < static_cast<int>(type.permits.size()); ++word) {
    const joints::Permit& permit = type.permits[word];
    if (const auto* by = std::get_if<joints::ByMotion>(&permit)) {
      for (int k = 0; k < static_cast<int>(by->names.size()); ++k) add(by->names[k], word, k);
    } else if (n_q(permit) > 0) {
      add(base_name(permit), word, 0);
    }
  }
  return coordinates;
}

}  // namespace concord
