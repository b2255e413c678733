#include "cartesian/dynamics/evaluation.h"

#include <optional>

#include "cartesian/bodies/joint_coordinates.h"
#include "cartesian/dynamics/reactions.h"

namespace concord::cartesian {

State reported_state(const Equations& equations, const VecX& q, const VecX& Y, const std::vector<VecX>& known) {
  State state = equations.layout().pack(equations.time(), q, Y);
  state.q = known;
  state.u = zero_speeds(equations.model());
  read_joint_coordinates(equations.model(), equations.moving_constraints(), state.q, state.u);
  state.spring_angles = equations.applied().spring_angles(equations.moving_constraints(), q, Y);
  return state;
}

Evaluation reported_accelerations(const Equations& equations, const Solution& solution) {
  const Layout& layout = equations.layout();
  Evaluation result;
  result.bodies.resize(layout.n_bodies());
  for (const BodyIndex i : layout.moving_bodies()) {
    result.bodies[i.value] = {layout.v(solution.Ydot(), i), layout.omega(solution.Ydot(), i),
                              layout.adot(solution.Ydot(), i)};
  }
  return result;
}

Evaluation reported_evaluation(const Equations& equations, const Solution& solution) {
  const Model& model = equations.model();
  const MovingConstraints& constraints = equations.moving_constraints();
  Evaluation result = reported_accelerations(equations, solution);
  for (const JointIndex k : constraints.joints()) {
    const JointEquations& joint = constraints.joint(k);
    const VecX lambda = joint_multipliers(joint, solution.lambda());
    const AppliedForce* springs = equations.applied().springs_of(k);
    std::optional<SpringsAt> exerted;
    if (springs != nullptr) exerted.emplace(SpringsAt{equations.time(), *springs});
    result.joints.push_back(compute_wrenches(pick(model.joints, k), joint, lambda, exerted ? &*exerted : nullptr));
  }
  for (const CouplingIndex g : constraints.couplings()) {
    result.couplings.push_back(-solution.lambda()(constraints.coupling(g).row.value));
  }
  for (const ElementIndex e : indices_of(model.elements)) result.elements.push_back(equations.applied().element(e));
  return result;
}

}  // namespace concord::cartesian
