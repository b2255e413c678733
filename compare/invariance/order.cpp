#include "compare/invariance/order.h"

#include <utility>

namespace concord::compare::invariance {

namespace {

/// picked[k] = all[order[k]]; nothing of an empty list, which stands for parts of which nothing is said.
template <class Parts>
void pick(Parts& all, const std::vector<int>& order) {
  if (all.empty()) return;
  Parts picked;
  picked.reserve(order.size());
  for (const int k : order) picked.push_back(all[static_cast<std::size_t>(k)]);
  all = std::move(picked);
}

std::vector<int> inverse_of(const std::vector<int>& order) {
  std::vector<int> inverse(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) inverse[static_cast<std::size_t>(order[k])] = static_cast<int>(k);
  return inverse;
}

PartOrder inverse_of(const PartOrder& order) {
  return {inverse_of(order.bodies), inverse_of(order.joints), inverse_of(order.couplings), inverse_of(order.elements)};
}

Model model_in_order(Model model, const PartOrder& order, const PartOrder& places) {
  pick(model.bodies, order.bodies);
  pick(model.joints, order.joints);
  pick(model.couplings, order.couplings);
  pick(model.elements, order.elements);
  for_each_attachment(model, [&](Attachment& side) { side.body = places.bodies[static_cast<std::size_t>(side.body)]; });
  for (Coupling& coupling : model.couplings) {
    for (CouplingTerm& term : coupling.terms) term.joint = places.joints[static_cast<std::size_t>(term.joint)];
  }
  return model;
}

State state_in_order(State state, const PartOrder& order) {
  pick(state.bodies, order.bodies);
  pick(state.q, order.joints);
  pick(state.u, order.joints);
  pick(state.spring_angles, order.elements);
  return state;
}

}  // namespace

Change in_order(const PartOrder& order) {
  const PartOrder places = inverse_of(order);
  Change change;
  change.model = [order, places](Model model) { return model_in_order(std::move(model), order, places); };
  change.state = [order](State state) { return state_in_order(std::move(state), order); };
  change.back = [places](State state) { return state_in_order(std::move(state), places); };
  change.evaluation = [places](const State&, Evaluation evaluation) {
    pick(evaluation.bodies, places.bodies);
    pick(evaluation.joints, places.joints);
    pick(evaluation.couplings, places.couplings);
    pick(evaluation.elements, places.elements);
    return evaluation;
  };
  change.report = [places](RankReport report) {
    pick(report.joints, places.joints);
    pick(report.decided, places.joints);
    pick(report.unique_coupling, places.couplings);
    pick(report.decided_coupling, places.couplings);
    return report;
  };
  return change;
}

}  // namespace concord::compare::invariance
