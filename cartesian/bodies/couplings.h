#pragma once

#include <vector>

#include "cartesian/bodies/indices.h"
#include "cartesian/bodies/joint_equations.h"
#include "cartesian/bodies/layout.h"
#include "common/model.h"

/// Couplings: each is one row, the weighted sum of the rows of the joint coordinates that it relates.
namespace concord::cartesian {

/// Where a coupling's row stands and what it relates.
struct CouplingLayout {
  struct Term {
    JointIndex joint;
    int row;  // among the joint's rows
    double factor;
  };
  RowIndex row;
  double offset = 0.0;
  std::vector<Term> terms;
  std::vector<BodyIndex> bodies;  // moving ones, each once
};

/// The row at the current state.
struct CouplingEquations : CouplingLayout {
  std::vector<MatX> Phi_Y_transposed;  // by body: one column
};

/// Of each joint its coordinates that couplings relate, each once.
ByJoint<std::vector<CoupledCoordinate>> coupled_coordinates(const Model& model);

/// The equations of a coupling whose row is `row`; its joints get their shares in it.
CouplingEquations make_coupling_equations(const Model& model, const Coupling& stated, const Layout& layout,
                                          RowIndex row, ByJoint<JointEquations>& joints);

/// Jacobian of a coupling whose joints are placed (C30).
void place_coupling(const Model& model, const ByJoint<JointEquations>& joints, CouplingEquations& coupling);

/// Sum of factor q - offset, turns counted, and its rate, of placed and of moved joints.
double residual_of(const CouplingEquations& coupling, const ByJoint<JointEquations>& joints);
double rate_of(const CouplingEquations& coupling, const ByJoint<JointEquations>& joints);
/// What the second rate is without the accelerations Ydot.
double bias_of(const CouplingEquations& coupling, const ByJoint<JointEquations>& joints);

/// A coupled coordinate of a placed joint, turns counted.
double coupled_value(const JointEquations& joint, int row);

/// Multipliers of all rows of a joint and, behind them, of its coupled coordinates, from those of all constraints.
VecX joint_multipliers(const JointEquations& joint, const Eigen::Ref<const VecX>& lambda);  // (C42)

}  // namespace concord::cartesian
