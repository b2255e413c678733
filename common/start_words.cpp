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

std::vector<StartWord> kept_words(const Model& model, StartRole WordStart::*role) {
  std::vector<StartWord> words = start_words(model);
  std::erase_if(words,
                [&](const StartWord& one) { return model.joints[one.joint].start[one.word].*role != StartRole::keep; });
  return words;
}

Model keeping_only(Model model, const std::vector<StartWord>& coordinates, const std::vector<StartWord>& speeds) {
  const auto guess_others = [&](const std::vector<StartWord>& kept, StartRole WordStart::*role) {
    for (const StartWord& word : kept_words(model, role)) {
      const bool stays = std::any_of(kept.begin(), kept.end(), [&](const StartWord& one) {
        return one.joint == word.joint && one.word == word.word;
      });
      if (!stays) model.joints[word.joint].start[word.word].*role = StartRole::guess;
    }
  };
  guess_others(coordinates, &WordStart::role_q);
  guess_others(speeds, &WordStart::role_u);
  return model;
}

double slack_of(const VecX& slack, const VecX& kept, int entry) {
  const double exactly = kWrittenExactly * std::max(1.0, std::abs(kept(entry)));
  return slack.size() > entry ? std::max(slack(entry), exactly) : exactly;
}

namespace {

/// "turn_z of joint 'C' is 0.812, where 0.7 is kept to 0.05": entries of a word that are off by more; of a ball all.
void add_missed(const std::string& name, const VecX& found, const VecX& kept, const VecX& slack,
                std::vector<std::string>& missed) {
  for (int c = 0; c < kept.size(); ++c) {
    const double allowed = slack_of(slack, kept, c);
    if (std::abs(found(c) - kept(c)) <= allowed) continue;
    missed.push_back(fmt::format("{} is {:.9g}, where {:.9g} is kept to {:.2g}", name, found(c), kept(c), allowed));
  }
}

}  // namespace

void require_written(const Model& model, const Model& fewer, const std::vector<VecX>& q, const std::vector<VecX>& u) {
  std::vector<std::string> missed;
  const SourceLocation* where = nullptr;
  for (const StartWord& word : start_words(model)) {
    const Joint& joint = model.joints[word.joint];
    const WordStart& said = joint.start[word.word];
    const std::string name = names_of(model, {word});
    if (said.role_q == StartRole::keep) {
      VecX found = q[word.joint].segment(first_q(*joint.type, word.word), said.q.size());
      VecX kept = said.q;
      if (joints::is_orientation(joint.type->permits[word.word])) {
        kept.normalize();
        if (found.dot(kept) < 0.0) kept = -kept;
      }
      add_missed(name, found, kept, said.slack_q, missed);
    }
    if (said.role_u == StartRole::keep) {
      const VecX found = u[word.joint].segment(first_u(*joint.type, word.word), said.u.size());
      add_missed("the speed of " + name, found, said.u, said.slack_u, missed);
    }
    if (where == nullptr && !missed.empty()) where = &joint.where;
  }
  if (where == nullptr) return;
  throw StartNotFound(*where,
                      fmt::format("the start keeps more than the machine has freedoms, and the values contradict each "
                                  "other: with {} as kept, {}: correct these values, or keep fewer",
                                  names_of(model, kept_words(fewer, &WordStart::role_q)), fmt::join(missed, "; ")));
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
