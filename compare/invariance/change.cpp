#include "compare/invariance/change.h"

#include <algorithm>
#include <cmath>

#include "compare/audit/places.h"
#include "compare/quantities/observe.h"
#include "compare/states/branch.h"

namespace concord::compare::invariance {

Change operator|(const Change& first, const Change& then) {
  Change both;
  both.model = [first, then](Model model) { return then.model(first.model(std::move(model))); };
  both.state = [first, then](State state) { return then.state(first.state(std::move(state))); };
  both.back = [first, then](State state) { return first.back(then.back(std::move(state))); };
  both.evaluation = [first, then](const State& before, Evaluation evaluation) {
    return first.evaluation(before, then.evaluation(first.state(before), std::move(evaluation)));
  };
  both.report = [first, then](RankReport report) { return first.report(then.report(std::move(report))); };
  return both;
}

Model started_in(Model model, const State& state) {
  model = started_at(model, state);
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    Joint& joint = model.joints[k];
    for (std::size_t word = 0; word < joint.start.size(); ++word) {
      WordStart& start = joint.start[word];
      if (start.q.size() == 0) continue;  // an arm
      start.u = state.u[k].segment(first_u(*joint.type, static_cast<int>(word)), start.u.size());
      start.role_u = std::max(start.role_u, StartRole::guess);
    }
  }
  for (std::size_t i = 1; i < model.bodies.size(); ++i) model.bodies[i].adot_start = state.bodies[i].adot;
  return model;
}

void for_each_joint_wrench(Evaluation& evaluation, const std::function<void(SideWrench&)>& edit) {
  for (JointWrenches& joint : evaluation.joints) {
    for (auto* wrenches : {&joint.reaction, &joint.total}) {
      for (SideWrench& side : *wrenches) edit(side);
    }
  }
}

void for_each_wrench(Evaluation& evaluation, const std::function<void(SideWrench&)>& edit) {
  for_each_joint_wrench(evaluation, edit);
  for (ElementWrenches& element : evaluation.elements) {
    for (SideWrench& side : element.on) edit(side);
  }
}

void turn_flags(const Mat3& G, std::array<bool, 6>& unique, std::array<bool, 6>& decided) {
  constexpr double kNothing = 1e-12;
  const std::array<bool, 6> found = unique;
  const std::array<bool, 6> known = decided;
  for (int first = 0; first < 6; first += 3) {
    for (int c = 0; c < 3; ++c) {
      int mixed = 0;
      bool all = true;
      bool all_known = true;
      for (int from = 0; from < 3; ++from) {
        if (std::abs(G(c, from)) <= kNothing) continue;
        ++mixed;
        all = all && found[static_cast<std::size_t>(first + from)];
        all_known = all_known && known[static_cast<std::size_t>(first + from)];
      }
      unique[static_cast<std::size_t>(first + c)] = all;
      decided[static_cast<std::size_t>(first + c)] = all_known && (all || mixed == 1);
    }
  }
}

std::vector<JointUniqueness>& decided_flags(RankReport& report) {
  if (report.decided.empty()) report.decided.resize(report.joints.size());
  return report.decided;
}

bool is_forced(const Model& model, int k) { return !forced_speeds(model, k).empty(); }

}  // namespace concord::compare::invariance
