#include "compare/random_machines/coverage.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "common/joints/catalogue.h"
#include "compare/audit/digits.h"
#include "compare/random_machines/elements.h"
#include "compare/report/text_table.h"

namespace concord::compare::fuzz {

namespace {

constexpr std::array<const char*, 6> kRoles{"tree", "reversed", "cut", "driven", "sprung", "coupled"};

std::string pair_name(const std::string& one, const std::string& other) {
  return one < other ? one + " - " + other : other + " - " + one;
}

}  // namespace

void Coverage::add_joint(const JointPlan& joint, int outer_body) {
  const std::string& name = joint.type->name;
  if (joint.closes_loop) {
    ++counts_["cut"][name];
  } else {
    ++counts_[joint.ends[1].body == outer_body ? "tree" : "reversed"][name];
  }
  const auto& all = joint.coordinates;
  if (std::any_of(all.begin(), all.end(), [](const auto& one) { return !one.drive.empty(); }))
    ++counts_["driven"][name];
  if (std::any_of(all.begin(), all.end(), [](const auto& one) { return !one.spring.empty(); }))
    ++counts_["sprung"][name];
}

/// Two joints on one body, ground left out.
void Coverage::add_pairs(const Machine& machine) {
  const auto touches = [](const JointPlan& joint, int body) {
    return joint.ends[0].body == body || joint.ends[1].body == body;
  };
  for (int i = 1; i < static_cast<int>(machine.bodies.size()); ++i) {
    for (std::size_t k = 0; k < machine.joints.size(); ++k) {
      for (std::size_t other = k + 1; other < machine.joints.size(); ++other) {
        if (!touches(machine.joints[k], i) || !touches(machine.joints[other], i)) continue;
        ++counts_["pairs"][pair_name(machine.joints[k].type->name, machine.joints[other].type->name)];
      }
    }
  }
}

void Coverage::add(const Machine& machine) {
  for (std::size_t k = 0; k < machine.joints.size(); ++k) add_joint(machine.joints[k], static_cast<int>(k) + 1);
  add_pairs(machine);
  for (std::size_t i = 1; i < machine.bodies.size(); ++i) {
    const auto& flexible = machine.bodies[i].flexible;
    ++counts_["bodies"][!flexible ? "rigid" : flexible->beam.empty() ? "modes file" : "beam"];
  }
  for (const CouplingPlan& coupling : machine.couplings) {
    for (const TermPlan& term : coupling.terms) ++counts_["coupled"][machine.joints[term.joint].type->name];
  }
  for (const ElementPlan& element : machine.elements) ++counts_["elements"][element.table];
}

long Coverage::count(const std::string& table, const std::string& name) const {
  const auto found = counts_.find(table);
  if (found == counts_.end()) return 0;
  const auto one = found->second.find(name);
  return one == found->second.end() ? 0 : one->second;
}

std::string Coverage::format() const {
  std::vector<std::vector<std::string>> roles{{"joint"}};
  roles.front().insert(roles.front().end(), kRoles.begin(), kRoles.end());
  for (const joints::JointType* type : joints::catalogue()) {
    roles.push_back({type->name});
    for (const char* role : kRoles) roles.back().push_back(fmt::format("{}", count(role, type->name)));
  }
  std::string text = format_table(roles, {false, true, true, true, true, true, true});
  std::vector<std::vector<std::string>> parts{{"part", "count"}};
  for (const char* kind : {"rigid", "beam", "modes file"}) {
    parts.push_back({std::string(kind) + " body", fmt::format("{}", count("bodies", kind))});
  }
  for (const std::string_view table : element_keys()) {
    parts.push_back({std::string(table), fmt::format("{}", count("elements", std::string(table)))});
  }
  text += '\n' + format_table(parts, {false, true});
  long met = 0;
  long all = 0;
  std::string missing;
  const auto& types = joints::catalogue();
  for (std::size_t one = 0; one < types.size(); ++one) {
    for (std::size_t other = one; other < types.size(); ++other) {
      const std::string name = pair_name(types[one]->name, types[other]->name);
      ++all;
      if (count("pairs", name) > 0) {
        ++met;
      } else {
        missing += fmt::format("{}{}", missing.empty() ? "" : ", ", name);
      }
    }
  }
  text += fmt::format("\npairs of joint types on one body: {} of {}\n", met, all);
  if (!missing.empty()) text += "pairs that did not occur: " + missing + '\n';
  return text;
}

}  // namespace concord::compare::fuzz
