#include "compare/quantities/needs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "compare/quantities/observe.h"

namespace concord::compare {

const char* name_of(Check check) {
  switch (check) {
    case Check::same_state:
      return "same state";
    case Check::same_run:
      return "same run";
    default:
      return "refined";
  }
}

double need_of(const Needs& needs, Check check) {
  switch (check) {
    case Check::same_state:
      return needs.same_state;
    case Check::same_run:
      return needs.same_run;
    default:
      return needs.refined;
  }
}

namespace {

/// Whether two components are both of forces or both of torques.
bool is_same_kind(const std::string& one, const std::string& other) { return one.front() == other.front(); }

bool is_on_body(const Joint& joint, int body) {
  return joint.on(Side::parent).body == body || joint.on(Side::child).body == body;
}

/// A change for a component holds for the same component of what stands in other axes too: they mix.
bool applies_to_component(const NeedOverride& change, const Quantity& quantity) {
  if (change.component.empty()) return true;
  const std::string own = describe_component(quantity);
  const bool in_other_axes = quantity.kind == Kind::reaction_global || quantity.kind == Kind::body_sum;
  if (in_other_axes) return is_same_kind(own, change.component);
  return is_scalar_force(quantity.kind) || own == change.component;
}

/// Whether a change holds for the owner of a quantity: for a joint all wrenches and forces in it and the sums on its
/// bodies, for a force element its wrenches, for a body its accelerations and the sum on it; without a name for all.
bool applies(const Model& model, const NeedOverride& change, const Quantity& quantity) {
  if (!applies_to_component(change, quantity)) return false;
  const bool is_free = change.joint.empty() && change.element.empty() && change.body.empty();
  if (is_free) return true;
  const auto is_body = [&](int body) { return !change.body.empty() && model.bodies[body].name == change.body; };
  switch (quantity.kind) {
    case Kind::element:
      return model.elements[quantity.owner].name == change.element;
    case Kind::acceleration:
      return is_body(quantity.owner);
    case Kind::body_sum:
      return is_body(quantity.owner) || std::any_of(model.joints.begin(), model.joints.end(), [&](const Joint& joint) {
               return joint.name == change.joint && is_on_body(joint, quantity.owner);
             });
    case Kind::coupling: {
      const auto& terms = model.couplings[quantity.owner].terms;
      return std::any_of(terms.begin(), terms.end(),
                         [&](const CouplingTerm& term) { return model.joints[term.joint].name == change.joint; });
    }
    default:
      return model.joints[quantity.owner].name == change.joint;
  }
}

struct NeededCheck {
  const char* name;
  std::optional<double> NeedOverride::*asked;
  double Needs::*need;
};
constexpr std::array kNeededChecks{NeededCheck{"same_state", &NeedOverride::same_state, &Needs::same_state},
                                   NeededCheck{"same_run", &NeedOverride::same_run, &Needs::same_run},
                                   NeededCheck{"refined", &NeedOverride::refined, &Needs::refined}};

bool lowers(const NeedOverride& change, const Needs& standard) {
  return std::any_of(kNeededChecks.begin(), kNeededChecks.end(), [&](const NeededCheck& check) {
    return (change.*check.asked).value_or(standard.*check.need) < standard.*check.need;
  });
}

/// What a spring or damper exerts where others act, too, follows from the state, whose errors its stiffness makes as
/// large as it likes: runs are judged by the sum, which the motion answers.
bool is_law_of_state(const Quantity& quantity) {
  return quantity.kind == Kind::share && (quantity.actor == Actor::spring || quantity.actor == Actor::damper);
}

template <class Items>
void check_name(const char* what, const std::string& name, const Items& items, const NeedOverride& change,
                std::vector<Diagnostic>& complaints) {
  const auto has_name = [&](const auto& item) { return item.name == name; };
  if (name.empty() || std::any_of(items.begin(), items.end(), has_name)) return;
  complaints.push_back({change.where, fmt::format("need: no {} is called '{}'", what, name)});
}

void check_names(const Model& model, const NeedOverride& change, std::vector<Diagnostic>& complaints) {
  check_name("joint", change.joint, model.joints, change, complaints);
  check_name("force element", change.element, model.elements, change, complaints);
  check_name("body", change.body, model.bodies, change, complaints);
  const int named = !change.joint.empty() + !change.element.empty() + !change.body.empty();
  if (named > 1) {
    complaints.push_back({change.where, "need: it names more than one of joint, element and body; one need, one name"});
  }
  const auto& names = component_names();
  if (!change.component.empty() && std::find(names.begin(), names.end(), change.component) == names.end()) {
    complaints.push_back({change.where, fmt::format("need: no component is called '{}'; there are {}", change.component,
                                                    fmt::join(names, ", "))});
  }
}

}  // namespace

Needs default_needs(const Model& model) {
  if (model.is_flexible()) return {kFlexibleSameState, kFlexibleSameRun, kRefined, "", false};
  return {kRigidSameState, kRigidSameRun, kRefined, "", false};
}

Needs needs_of(const Model& model, const Quantity& quantity) {
  Needs standard = default_needs(model);
  if (is_law_of_state(quantity)) standard.same_run = standard.refined = 0.0;
  Needs needs = standard;
  for (const NeedOverride& change : model.needs) {
    if (!applies(model, change, quantity)) continue;
    for (const NeededCheck& check : kNeededChecks)
      needs.*check.need = (change.*check.asked).value_or(needs.*check.need);
    if (lowers(change, standard)) needs.because = change.because;
  }
  needs.same_state_lowered = needs.same_state < standard.same_state;
  return needs;
}

void check_needs(const Model& model) {
  const Needs standard = default_needs(model);
  std::vector<Diagnostic> complaints;
  for (const NeedOverride& change : model.needs) {
    check_names(model, change, complaints);
    for (const NeededCheck& check : kNeededChecks) {
      const double need = standard.*check.need;
      const double asked = (change.*check.asked).value_or(need);
      if (asked >= need || !change.because.empty()) continue;
      complaints.push_back(
          {change.where, fmt::format("need: {} = {} is below the {} digits that the comparator asks of this model; "
                                     "say why with because = \"...\"",
                                     check.name, asked, need)});
    }
  }
  if (!complaints.empty()) throw InputError(std::move(complaints));
}

}  // namespace concord::compare
