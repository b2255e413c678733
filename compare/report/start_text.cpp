#include "compare/report/start_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>

#include "compare/report/text_table.h"

namespace concord::compare {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::size_t kFewRows = 8;
constexpr std::size_t kPosesShown = 3;
constexpr double kSameValue = 1e-6;  // of itself, of 1 m or 1 rad

/// Round-off of a coordinate that is zero is no number to read.
double shown(double value) { return std::abs(value) < 1e-12 ? 0.0 : value; }

std::string with_unit(joints::CoordinateKind kind, double value) {
  if (kind == joints::CoordinateKind::length) return fmt::format("{:.6g} m", shown(value));
  return fmt::format("{:.6g} deg", shown(value) / kDegree);
}

std::string value_text(joints::CoordinateKind kind, const VecX& value) {
  if (kind != joints::CoordinateKind::orientation) return with_unit(kind, value(0));
  const double angle = value.norm();
  if (shown(angle) == 0.0) return "0 deg";
  const VecX axis = value / angle;
  return fmt::format("{} about ({:.3g}, {:.3g}, {:.3g})", with_unit(joints::CoordinateKind::angle, angle),
                     shown(axis(0)), shown(axis(1)), shown(axis(2)));
}

std::string said_text(const StartCoordinate& coordinate) {
  switch (coordinate.said) {
    case Said::keep:
      return coordinate.guess.size() > 0 ? "keep " + value_text(coordinate.kind, coordinate.guess) : "keep";
    case Said::law:
      return "driven";
    case Said::guess:
      return "guess " + value_text(coordinate.kind, coordinate.guess);
    case Said::nothing:
      break;
  }
  return "nothing";
}

const char* said_word(Said said) {
  switch (said) {
    case Said::keep:
      return "keep";
    case Said::law:
      return "driven";
    case Said::guess:
      return "guess";
    case Said::nothing:
      break;
  }
  return "nothing";
}

std::string moved_text(const StartCoordinate& coordinate) {
  if (coordinate.said != Said::guess || coordinate.size <= kNoticed) return "";
  return with_unit(coordinate.kind == joints::CoordinateKind::length ? coordinate.kind : joints::CoordinateKind::angle,
                   coordinate.moved);
}

/// How much a coordinate tells: how far it moved, or lies from its value in another pose.
double weight_of(const Model& model, const StartReport& start, std::size_t k) {
  const StartCoordinate& coordinate = start.coordinates[k];
  const double unit = coordinate.kind == joints::CoordinateKind::length ? model.length_scale() : 1.0;
  double weight = coordinate.size > kNoticed ? coordinate.size : 0.0;
  for (const std::vector<VecX>& other : start.others.values) {
    weight = std::max(weight, (other[k] - coordinate.value).norm() / unit);
  }
  return weight;
}

/// Places of the coordinates to show, in the order of the model.
std::vector<std::size_t> rows_of(const Model& model, const StartReport& start, bool all_rows) {
  std::vector<std::size_t> rows(start.coordinates.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  if (all_rows || rows.size() <= kFewRows) return rows;
  std::vector<double> weights;
  for (const std::size_t k : rows) weights.push_back(weight_of(model, start, k));
  std::stable_sort(rows.begin(), rows.end(), [&](std::size_t a, std::size_t b) { return weights[a] > weights[b]; });
  rows.resize(kFewRows);
  std::sort(rows.begin(), rows.end());
  return rows;
}

TextTable table_of(const Model& model, const StartReport& start, const std::vector<std::size_t>& rows) {
  std::vector<std::vector<std::string>> lines{{"joint", "coordinate", "at the start", "the model says", "moved"}};
  std::vector<bool> right{false, false, true, false, true};
  const std::size_t poses = std::min(start.others.values.size(), kPosesShown);
  for (std::size_t other = 0; other < poses; ++other) {
    lines.front().push_back(fmt::format("found {}", other + 1));
    right.push_back(true);
  }
  for (const std::size_t k : rows) {
    const StartCoordinate& coordinate = start.coordinates[k];
    std::vector<std::string>& line = lines.emplace_back(std::vector<std::string>{
        model.joints[static_cast<std::size_t>(coordinate.joint)].name, coordinate.name,
        value_text(coordinate.kind, coordinate.value), said_text(coordinate), moved_text(coordinate)});
    for (std::size_t other = 0; other < poses; ++other) {
      const VecX& value = start.others.values[other][k];
      const bool is_same = (value - coordinate.value).norm() <= kSameValue * std::max(1.0, value.norm());
      line.push_back(is_same ? "" : value_text(coordinate.kind, value));
    }
  }
  return {std::move(lines), std::move(right)};
}

std::string moved_bodies(const Model& model, const StartReport& start) {
  std::string text;
  for (const MovedBody& moved : start.bodies) {
    text += fmt::format("{} body {} by {:.3g} m and {:.3g} deg", text.empty() ? "moved from the guessed pose:" : ",",
                        model.bodies[static_cast<std::size_t>(moved.body)].name, shown(moved.apart),
                        shown(moved.turned) / kDegree);
  }
  return text.empty() ? "" : text + '\n';
}

std::string other_poses(const StartReport& start) {
  const OtherPoses& others = start.others;
  if (others.not_sought) return "other poses of so large a machine were not sought: `concord info` seeks them\n";
  if (others.guesses == 0) return "";
  const auto count = static_cast<int>(others.values.size());
  if (count == 0) return fmt::format("found no other pose from {} other guesses\n", others.guesses);
  std::string text =
      fmt::format("found: {} with the same kept and driven coordinates, from {} other guesses by {}; {} accepts {}",
                  plural(count, "other pose", "other poses"), others.guesses, others.found_by, others.accepted_by,
                  count == 1 ? "it" : "them");
  if (others.values.size() > kPosesShown) text += fmt::format("; the first {} are shown", kPosesShown);
  return text + '\n';
}

Json numbers(const VecX& value) {
  if (value.size() == 1) return value(0);
  return std::vector<double>(value.data(), value.data() + value.size());
}

}  // namespace

std::string format_start(const Model& model, const StartReport& start, bool all_rows) {
  if (start.coordinates.empty()) return "";
  const std::vector<std::size_t> rows = rows_of(model, start, all_rows);
  std::string text = format_table(table_of(model, start, rows));
  if (rows.size() < start.coordinates.size()) {
    const auto left_out = static_cast<int>(start.coordinates.size() - rows.size());
    text += fmt::format("and {} more: --all names them\n", plural(left_out, "coordinate", "coordinates"));
  }
  return text + moved_bodies(model, start) + other_poses(start);
}

std::string poses_line(const Model& model, const StartReport& start) {
  const std::vector<std::vector<VecX>>& others = start.others.values;
  if (others.empty()) return "";
  std::size_t most = 0;
  for (std::size_t k = 1; k < start.coordinates.size(); ++k) {
    if (weight_of(model, start, k) > weight_of(model, start, most)) most = k;
  }
  const StartCoordinate& told = start.coordinates[most];
  std::string text =
      fmt::format("starts with {} of {} at {}; {} found with the same kept coordinates:", told.name,
                  model.joints[static_cast<std::size_t>(told.joint)].name, value_text(told.kind, told.value),
                  plural(static_cast<int>(others.size()), "other pose was", "other poses were"));
  for (std::size_t other = 0; other < std::min(others.size(), kPosesShown); ++other) {
    text += fmt::format("{} {}", other == 0 ? "" : ",", value_text(told.kind, others[other][most]));
  }
  return text + (others.size() > kPosesShown ? ", ..." : "");
}

StartTable start_table(const Model& model, const StartReport& start) {
  StartTable told{table_of(model, start, rows_of(model, start, true)), {}};
  for (std::string line : {moved_bodies(model, start), other_poses(start)}) {
    if (line.empty()) continue;
    line.pop_back();  // the line feed
    told.lines.push_back(std::move(line));
  }
  return told;
}

Json start_json(const Model& model, const StartReport& start) {
  Json coordinates = Json::array();
  for (const StartCoordinate& one : start.coordinates) {
    Json said{{"joint", model.joints[static_cast<std::size_t>(one.joint)].name},
              {"coordinate", one.name},
              {"unit", one.kind == joints::CoordinateKind::length ? "m" : "rad"},
              {"value", numbers(one.value)},
              {"said", said_word(one.said)}};
    if (one.said == Said::keep && one.guess.size() > 0) said["written"] = numbers(one.guess);
    if (one.said == Said::guess) {
      said["guess"] = numbers(one.guess);
      said["moved"] = one.moved;
    }
    coordinates.push_back(std::move(said));
  }
  Json bodies = Json::array();
  for (const MovedBody& moved : start.bodies) {
    bodies.push_back({{"body", model.bodies[static_cast<std::size_t>(moved.body)].name},
                      {"apart_m", moved.apart},
                      {"turned_rad", moved.turned}});
  }
  Json poses = Json::array();
  for (const std::vector<VecX>& other : start.others.values) {
    Json values = Json::array();
    for (const VecX& value : other) values.push_back(numbers(value));
    poses.push_back(std::move(values));
  }
  return {{"coordinates", std::move(coordinates)},
          {"bodies", std::move(bodies)},
          {"other_guesses", start.others.guesses},
          {"other_poses", std::move(poses)}};
}

}  // namespace concord::compare
