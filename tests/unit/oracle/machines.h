#pragma once

#include <string>
#include <vector>

#include "cartesian/solver.h"
#include "common/reading/model_file.h"
#include "compare/oracle/simbody_oracle.h"
#include "compare/quantities/align.h"
#include "compare/quantities/third_opinion.h"
#include "relative/solver.h"

/// Machines that both solvers and the oracle are asked about.
namespace concord::compare::oracle {

/// Two bodies of unequal inertia with their centres of mass off their origins, pushed about.
inline const std::string kTwoBodies = R"(format = 1
gravity = [1.3, -2.1, -9.2]
[[body]]
name = "a"
mass = 2.3
center_of_mass = [0.11, -0.07, 0.05]
inertia = [0.09, 0.06, 0.11, 0.008, -0.005, 0.003]
[[body]]
name = "b"
mass = 0.8
center_of_mass = [-0.04, 0.09, 0.06]
inertia = [0.013, 0.021, 0.017, -0.002, 0.001, 0.0015]
[[load]]
name = "push"
body = "b"
point = [0.1, 0.2, -0.1]
axes = "body"
force = [4, -3, 2]
torque = [0.4, 0.7, -0.2]
[[line_spring]]
name = "strut"
parent = { body = "ground", point = [1.5, 1.2, -0.9] }
child = { body = "a", point = [0.2, -0.1, 0.3] }
stiffness = 40
damping = 3
free = 0.5
)";

/// What both solvers and Simbody say at the model's start.
inline ThirdReport opinion_at_start(const Model& model) {
  const auto cartesian = cartesian::make_solver(model);
  const auto relative = relative::make_solver(model);
  const auto simbody = make_simbody(model);
  const State start = relative->assemble();
  const QuantityLayout layout(model);
  const auto rows = static_cast<Eigen::Index>(layout.quantities().size());
  const Mask everywhere = Mask::Constant(rows, 1, true);
  const MatX unknown = MatX::Constant(rows, 1, std::numeric_limits<double>::quiet_NaN());
  const std::vector<SharedState> states{{start, {cartesian->evaluate(start), relative->evaluate(start)}, 0}};
  return ask_third(layout, *simbody, states, {&unknown, &everywhere});
}

}  // namespace concord::compare::oracle
