#include "compare/joint_check/sheet.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>

#include "compare/joint_check/type_properties.h"
#include "compare/report/explanations.h"
#include "compare/report/text_table.h"

namespace concord::compare::joint_check {

namespace {

using Json = nlohmann::ordered_json;

/// Calls visit(property) for all of a sheet.
void each_property(const Sheet& sheet, const std::function<void(const Property&)>& visit) {
  for (const Property& property : sheet.properties) visit(property);
  for (const Property& cell : sheet.wrenches.cells) visit(cell);
}

std::string poses_in_words(const SheetOptions& options) {
  if (options.poses.size() == 1) return fmt::format("pose {}", options.poses.front());
  return fmt::format("poses {} to {}", options.poses.front(), options.poses.back());
}

std::string measured(const Property& property) {
  if (!property.looked) return "-";
  if (property.need) return format_digits(property.digits);
  return property.holds() ? "yes" : "no";
}

std::string property_table(const Sheet& sheet) {
  std::vector<std::vector<std::string>> lines{{"property", "digits", "need", "worst pose", "verdict"}};
  for (const Property& property : sheet.properties) {
    const std::string pose = property.looked && property.pose >= 0 ? fmt::format("{}", property.pose) : "";
    const std::string verdict = !property.looked ? "nothing to look at" : (property.holds() ? "holds" : "FAILS");
    lines.push_back(
        {property.name, measured(property), property.need ? fmt::format("{:g}", *property.need) : "", pose, verdict});
  }
  return format_table(lines, {false, true, true, true, false});
}

std::string wrench_table(const WrenchTable& wrenches) {
  std::vector<std::vector<std::string>> lines{{"joint, rig"}};
  for (const std::string& pair : WrenchTable::pair_names()) lines.front().push_back(pair);
  lines.front().emplace_back("need");
  for (int load = 0; load < WrenchTable::kLoads; ++load) {
    for (int rig = 0; rig < WrenchTable::kRigs; ++rig) {
      std::vector<std::string>& line = lines.emplace_back();
      line.push_back(fmt::format("{}, {}", WrenchTable::load_names()[load], WrenchTable::rig_names()[rig]));
      for (int pair = 0; pair < WrenchTable::kPairs; ++pair) {
        const Property& cell = wrenches.at(pair, load, rig);
        line.push_back(measured(cell) + (cell.holds() ? "" : " FAILS"));
      }
      line.push_back(fmt::format("{:g}", wrenches.at(0, load, rig).need.value_or(0.0)));
    }
  }
  std::vector<bool> right(lines.front().size(), true);
  right.front() = false;
  return "Total wrench, reaction and tau on both sides, and all accelerations: matching digits of the Cartesian "
         "solver\n"
         "with the relative one, joint in the tree and cut, tree along the joint and against it; parent - child.\n" +
         format_table(lines, right);
}

std::string failure(const Sheet& sheet, const Property& property) {
  std::string text = fmt::format("FAIL {}: {}", sheet.joint, property.name);
  if (property.need) text += fmt::format(": {} digits (need {:g})", format_digits(property.digits), *property.need);
  text +=
      fmt::format("\n     {}\n     again: concord joint {} --seed {}", property.where, sheet.joint, sheet.options.seed);
  if (property.pose >= 0) text += fmt::format(" --pose {}", property.pose);
  return text + '\n';
}

/// The first failing cell in words, and how many more the table shows.
std::string failures_of_wrenches(const Sheet& sheet) {
  const auto fails = [](const Property& cell) { return !cell.holds(); };
  const auto& cells = sheet.wrenches.cells;
  const auto first = std::find_if(cells.begin(), cells.end(), fails);
  if (first == cells.end()) return {};
  const auto others = std::count_if(first + 1, cells.end(), fails);
  return failure(sheet, *first) +
         (others > 0 ? fmt::format("     and {} more cells of the table of wrenches\n", others) : "");
}

std::string last_line(const Sheet& sheet) {
  return fmt::format("{} {}: {} of {} properties hold at {} of seed {}\n", sheet.holds() ? "holds" : "FAILS",
                     sheet.joint, sheet.held(), sheet.looked(), poses_in_words(sheet.options), sheet.options.seed);
}

/// The least digits of the properties that are measured in digits, apart from those by differences.
double least_digits(const Sheet& sheet) {
  double least = kMostDigits;
  if (sheet.wrenches.cells.empty()) {  // couplings: all is measured as one
    for (const Property& property : sheet.properties) {
      if (property.looked && property.need) least = std::min(least, property.digits);
    }
  }
  for (const Property& cell : sheet.wrenches.cells) {
    if (cell.looked) least = std::min(least, cell.digits);
  }
  return least;
}

Json json_of(const Property& property) {
  Json json;
  json["name"] = property.name;
  json["looked"] = property.looked;
  json["digits"] = digits_json(property.looked && property.need ? std::optional(property.digits) : std::nullopt);
  json["need"] = property.need ? Json(*property.need) : Json();
  json["holds"] = property.holds();
  json["pose"] = property.looked && property.pose >= 0 ? Json(property.pose) : Json();
  json["where"] = property.where;
  return json;
}

/// "5", or "2 + 1" with the rows of velocities alone.
std::string rows_of(const Sheet& sheet) {
  return fmt::format("{}", sheet.rows) +
         (sheet.nonholonomic_rows > 0 ? fmt::format(" + {}", sheet.nonholonomic_rows) : "");
}

}  // namespace

bool Sheet::holds() const { return held() == looked(); }

int Sheet::looked() const {
  int count = 0;
  each_property(*this, [&](const Property& property) { count += property.looked ? 1 : 0; });
  return count;
}

int Sheet::held() const {
  int count = 0;
  each_property(*this, [&](const Property& property) { count += property.looked && property.holds() ? 1 : 0; });
  return count;
}

Sheet check_joint(const JointType& type, const SheetOptions& options) {
  Sheet sheet;
  sheet.joint = type.name;
  sheet.rows = type.rows();
  sheet.nonholonomic_rows = type.nonholonomic_rows();
  sheet.options = options;
  for (const joints::Permit& word : type.permits) {
    for (const joints::StatedCoordinate& one : stated_coordinates(word)) sheet.coordinates.emplace_back(one.name);
  }
  sheet.properties = check_statement(type);
  if (!sheet.holds()) return sheet;
  const Properties of_words = check_words(type, options.seed, options.poses);
  sheet.properties.insert(sheet.properties.end(), of_words.begin(), of_words.end());
  RigFindings in_rigs = check_in_rigs(type, options.seed, options.poses);
  sheet.properties.insert(sheet.properties.end(), in_rigs.properties.begin(), in_rigs.properties.end());
  sheet.wrenches = std::move(in_rigs.wrenches);
  return sheet;
}

std::string format_sheet(const Sheet& sheet) {
  std::string text =
      fmt::format("joint {}: forbids {} directions{}, permits {}; seed {}, {}\n\n", sheet.joint, sheet.rows,
                  sheet.nonholonomic_rows > 0 ? fmt::format(" and {} velocities", sheet.nonholonomic_rows) : "",
                  sheet.coordinates.empty() ? "nothing" : fmt::format("{}", fmt::join(sheet.coordinates, ", ")),
                  sheet.options.seed, poses_in_words(sheet.options));
  text += property_table(sheet) + '\n';
  if (!sheet.wrenches.cells.empty()) text += wrench_table(sheet.wrenches) + '\n';
  for (const Property& property : sheet.properties) {
    if (!property.holds()) text += failure(sheet, property);
  }
  return text + failures_of_wrenches(sheet) + last_line(sheet);
}

std::string format_summary(const std::vector<Sheet>& sheets) {
  std::vector<std::vector<std::string>> lines{{"joint", "rows", "coordinates", "properties", "wrenches", "verdict"}};
  for (const Sheet& sheet : sheets) {
    lines.push_back({sheet.joint, rows_of(sheet), fmt::format("{}", fmt::join(sheet.coordinates, ", ")),
                     fmt::format("{} of {}", sheet.held(), sheet.looked()), format_digits(least_digits(sheet)),
                     sheet.holds() ? "holds" : "FAILS"});
  }
  return format_table(lines, {false, true, false, true, true, false});
}

std::string format_sheet_json(const Sheet& sheet) {
  Json json;
  json["format"] = 1;
  json["joint"] = sheet.joint;
  json["verdict"] = sheet.holds() ? "holds" : "fails";
  json["rows"] = sheet.rows;
  json["slip_rows"] = sheet.nonholonomic_rows;
  json["coordinates"] = sheet.coordinates;
  json["seed"] = sheet.options.seed;
  json["poses"] = sheet.options.poses;
  json["held"] = sheet.held();
  json["looked"] = sheet.looked();
  json["properties"] = Json::array();
  each_property(sheet, [&](const Property& property) { json["properties"].push_back(json_of(property)); });
  return json.dump(2) + '\n';
}

}  // namespace concord::compare::joint_check
