#include "compare/needs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "compare/observe.h"

namespace concord::compare {

namespace {

bool applies(const NeedOverride& change, const std::string& joint, const std::string& component) {
  return (change.joint.empty() || change.joint == joint) && (change.component.empty() || change.component == component);
}

struct NeededRung {
  const char* name;
  std::optional<double> NeedOverride::*asked;
  double Needs::*need;
};
constexpr std::array kNeededRungs{NeededRung{"same_state", &NeedOverride::same_state, &Needs::same_state},
                                  NeededRung{"same_run", &NeedOverride::same_run, &Needs::same_run},
                                  NeededRung{"refined", &NeedOverride::refined, &Needs::refined}};

bool lowers(const NeedOverride& change, const Needs& standard) {
  return std::any_of(kNeededRungs.begin(), kNeededRungs.end(), [&](const NeededRung& rung) {
    return (change.*rung.asked).value_or(standard.*rung.need) < standard.*rung.need;
  });
}

void check_names(const Model& model, const NeedOverride& change, std::vector<Diagnostic>& complaints) {
  const auto has_name = [&](const Joint& joint) { return joint.name == change.joint; };
  if (!change.joint.empty() && std::none_of(model.joints.begin(), model.joints.end(), has_name)) {
    complaints.push_back({change.where, fmt::format("need: no joint is called '{}'", change.joint)});
  }
  const auto& names = component_names();
  if (!change.component.empty() && std::find(names.begin(), names.end(), change.component) == names.end()) {
    complaints.push_back({change.where, fmt::format("need: no component is called '{}'; there are {}", change.component,
                                                    fmt::join(names, ", "))});
  }
}

}  // namespace

Needs default_needs(const Model& model) {
  if (model.is_flexible()) return {kFlexibleSameState, kFlexibleSameRun, kRefined, ""};
  return {kRigidSameState, kRigidSameRun, kRefined, ""};
}

Needs needs_of(const Model& model, const std::string& joint, const std::string& component) {
  const Needs standard = default_needs(model);
  Needs needs = standard;
  for (const NeedOverride& change : model.needs) {
    if (!applies(change, joint, component)) continue;
    for (const NeededRung& rung : kNeededRungs) needs.*rung.need = (change.*rung.asked).value_or(needs.*rung.need);
    if (lowers(change, standard)) needs.because = change.because;
  }
  return needs;
}

void check_needs(const Model& model) {
  const Needs standard = default_needs(model);
  std::vector<Diagnostic> complaints;
  for (const NeedOverride& change : model.needs) {
    check_names(model, change, complaints);
    for (const NeededRung& rung : kNeededRungs) {
      const double need = standard.*rung.need;
      const double asked = (change.*rung.asked).value_or(need);
      if (asked >= need || !change.because.empty()) continue;
      complaints.push_back(
          {change.where, fmt::format("need: {} = {} is below the {} digits that the comparator asks of this model; "
                                     "say why with because = \"...\"",
                                     rung.name, asked, need)});
    }
  }
  if (!complaints.empty()) throw InputError(std::move(complaints));
}

}  // namespace concord::compare
