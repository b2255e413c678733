#include "compare/quantities/convention.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "common/rotation.h"
#include "compare/audit/places.h"

namespace concord::compare {

namespace {

struct Word {
  std::string name;
  std::vector<std::string> values;
};

/// In the order of ConventionWord.
const std::array<Word, 5>& words() {
  static const std::array<Word, 5> kWords{{{"side", {"child", "parent"}},
                                           {"axes", {"joint", "world", "body"}},
                                           {"point", {"own", "other"}},
                                           {"driver", {"without", "with"}},
                                           {"sign", {"same", "opposite"}}}};
  return kWords;
}

constexpr int kWorld = 1;
constexpr int kBody = 2;

int value_of(const Convention& convention, ConventionWord word, int otherwise) {
  return convention[static_cast<std::size_t>(word)].value_or(otherwise);
}

Field wrench_field(bool with_driver, bool in_world_axes) {
  if (with_driver) return in_world_axes ? Field::total_global : Field::total;
  return in_world_axes ? Field::reaction_global : Field::reaction;
}

/// M v, where what has no part in a component does not count, NaN or not.
Vec3 part_by_part(const Mat3& M, const Vec3& v) {
  constexpr double kNoPart = 1e-12;
  Vec3 product = Vec3::Zero();
  for (int row = 0; row < 3; ++row) {
    for (int c = 0; c < 3; ++c) {
      if (std::abs(M(row, c)) > kNoPart) product(row) += M(row, c) * v(c);
    }
  }
  return product;
}

}  // namespace

Convention stated_of(const std::string& joint, const Conventions& stated) {
  const auto own = stated.find(joint);
  const auto all = stated.find("");
  Convention both = own == stated.end() ? Convention() : own->second;
  for (std::size_t k = 0; k < both.size() && all != stated.end(); ++k) {
    if (!both[k]) both[k] = all->second[k];
  }
  return both;
}

bool has_convention(const Column& column) {
  return column.field >= Field::reaction && column.field <= Field::total_global;
}

Column in_convention(const Column& column, const Convention& convention) {
  if (!has_convention(column)) return column;
  const bool is_total = column.field == Field::total || column.field == Field::total_global;
  const bool is_global = column.field == Field::reaction_global || column.field == Field::total_global;
  Column other = column;
  const bool is_parent = value_of(convention, ConventionWord::side, column.side == Side::parent ? 1 : 0) == 1;
  other.side = is_parent ? Side::parent : Side::child;
  other.field = wrench_field(value_of(convention, ConventionWord::driver, is_total ? 1 : 0) == 1,
                             value_of(convention, ConventionWord::axes, is_global ? kWorld : 0) == kWorld);
  return other;
}

double sign_in(const Column& column, const Convention& convention) {
  return has_convention(column) && value_of(convention, ConventionWord::sign, 0) == 1 ? -1.0 : 1.0;
}

std::array<bool, 2> re_expression_of(const Convention& convention) {
  return {value_of(convention, ConventionWord::axes, 0) == kBody, value_of(convention, ConventionWord::point, 0) == 1};
}

void re_express(const Joint& joint, const Convention& convention, const State& state, JointWrenches& wrenches) {
  const auto [in_body_axes, about_other_point] = re_expression_of(convention);
  for (const Side side : kSides) {
    const BodyState& body = state.bodies[static_cast<std::size_t>(joint.on(side).body)];
    const Attachment& beyond = joint.on(side == Side::child ? Side::parent : Side::child);
    const PlacedFrame here = place(joint.on(side), body);
    const Vec3 arm = here.r_P - place(beyond, state.bodies[static_cast<std::size_t>(beyond.body)]).r_P;
    for (SideWrench* wrench : {&wrenches.reaction[index(side)], &wrenches.total[index(side)]}) {
      if (about_other_point) {
        wrench->in_global.torque += part_by_part(skew(arm), wrench->in_global.force);
        wrench->in_C.torque += part_by_part(skew(here.A_joint.transpose() * arm), wrench->in_C.force);
      }
      if (!in_body_axes) continue;
      const Mat3 to_body = rotation_of(body.p).transpose() * here.A_joint;
      wrench->in_C = {part_by_part(to_body, wrench->in_C.force), part_by_part(to_body, wrench->in_C.torque)};
    }
  }
}

std::vector<std::string> header_lines(const Convention& convention, const std::string& joint) {
  std::vector<std::string> lines;
  for (std::size_t k = 0; k < convention.size(); ++k) {
    if (!convention[k]) continue;
    const Word& word = words()[k];
    lines.push_back(fmt::format("# {}{}{} = {}", word.name, joint.empty() ? "" : " ", joint,
                                word.values.at(static_cast<std::size_t>(*convention[k]))));
  }
  return lines;
}

bool is_convention_word(const std::string& word) {
  return std::any_of(words().begin(), words().end(), [&](const Word& one) { return one.name == word; });
}

bool say(const std::string& word, const std::string& value, Convention& convention) {
  for (std::size_t k = 0; k < convention.size(); ++k) {
    const Word& one = words()[k];
    const auto found = std::find(one.values.begin(), one.values.end(), value);
    if (word != one.name || found == one.values.end()) continue;
    convention[k] = static_cast<int>(found - one.values.begin());
    return true;
  }
  return false;
}

std::string words_of_conventions() {
  std::vector<std::string> texts;
  for (const Word& word : words()) {
    texts.push_back(fmt::format("`{} = {}`", word.name, fmt::join(word.values, "` or `")));
  }
  return fmt::format("{}", fmt::join(texts, ", "));
}

std::vector<Convention> all_conventions() {
  std::vector<Convention> all{Convention()};
  for (std::size_t k = 0; k < words().size(); ++k) {
    std::vector<Convention> more;
    for (const Convention& one : all) {
      for (std::size_t value = 0; value < words()[k].values.size(); ++value) {
        more.push_back(one);
        more.back()[k] = static_cast<int>(value);
      }
    }
    all = std::move(more);
  }
  return all;
}

}  // namespace concord::compare
