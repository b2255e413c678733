#include "common/start_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "common/joints/named_coordinates.h"

namespace concord {

namespace {

constexpr double kRoundOff = 1e-6;  // beside a larger number of the same message

/// "a, b and c".
std::string enumerated(const std::vector<std::string>& names) {
  if (names.size() < 2) return fmt::format("{}", fmt::join(names, ""));
  return fmt::format("{} and {}", fmt::join(names.begin(), names.end() - 1, ", "), names.back());
}

Vec3 without_round_off(const Vec3& direction) {
  return direction.unaryExpr([](double part) { return std::abs(part) < kRoundOff ? 0.0 : part; });
}

/// "-z", or three numbers.
std::string direction_words(const Vec3& direction) {
  const Vec3 shown = without_round_off(direction);
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(shown(axis)) < 1.0 - kRoundOff) continue;
    return fmt::format("{}{}", shown(axis) < 0.0 ? "-" : "", "xyz"[axis]);
  }
  return fmt::format("({:.4g}, {:.4g}, {:.4g})", shown.x(), shown.y(), shown.z());
}

std::string numbers_of(const Vec3& direction) {
  const Vec3 shown = without_round_off(direction);
  return fmt::format("({:.4g}, {:.4g}, {:.4g})", shown.x(), shown.y(), shown.z());
}

}  // namespace

std::vector<StartWord> start_words(const Model& model) {
  std::vector<StartWord> words;
  for (int k = 0; k < static_cast<int>(model.joints.size()); ++k) {
    const Joint& joint = model.joints[k];
    for (int word = 0; word < static_cast<int>(joint.start.size()); ++word) {
      if (joint.start[word].q.size() > 0) words.push_back({k, word});
    }
  }
  return words;
}

std::string names_of(const Model& model, std::vector<StartWord> words) {
  std::sort(words.begin(), words.end(), [](const StartWord& a, const StartWord& b) {
    return std::pair(a.joint, a.word) < std::pair(b.joint, b.word);
  });
  std::vector<std::string> joints;
  for (auto word = words.begin(); word != words.end();) {
    const Joint& joint = model.joints[word->joint];
    const auto end = std::find_if(word, words.end(), [&](const StartWord& one) { return one.joint != word->joint; });
    std::vector<std::string> names;
    for (const NamedCoordinate& coordinate : named_coordinates(*joint.type)) {
      const bool is_one = std::any_of(word, end, [&](const StartWord& one) { return one.word == coordinate.word; }) &&
                          driver_of(joint, coordinate.word, coordinate.component) == nullptr;
      if (is_one) names.push_back(coordinate.name);
    }
    joints.push_back(fmt::format("{} of joint '{}'", enumerated(names), joint.name));
    word = end;
  }
  return fmt::format("{}", fmt::join(joints, ", "));
}

std::string words_of(const JointGap& gap, double length) {
  const double apart = gap.apart_C.norm();
  const double turned = gap.turned_C.norm();
  std::vector<std::string> in_frame;
  std::vector<std::string> in_world;
  const auto say = [&](double size, std::string_view unit, std::string_view preposition, const Vec3& direction) {
    in_frame.push_back(fmt::format("{:.4g} {} {} {}", size, unit, preposition, direction_words(direction)));
    in_world.push_back(fmt::format("{} {}", preposition, numbers_of(gap.A_C * direction)));
  };
  if (apart > kRoundOff * turned * length) say(apart, "m", "along", gap.apart_C / apart);
  if (turned > kRoundOff * apart / length) say(turned, "rad", "about", gap.turned_C / turned);
  return fmt::format("{} of its frame on the parent (in the world {})", enumerated(in_frame), enumerated(in_world));
}

}  // namespace concord
