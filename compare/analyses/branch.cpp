#include "compare/analyses/branch.h"

#include <algorithm>

#include "common/decompositions.h"
#include "common/rotation.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/places.h"
#include "compare/quantities/observe.h"

namespace concord::compare::analyses {

namespace {

/// What [v; omega] of a body, v in lengths, moves a point by that lies so far from its origin, and turns there.
Mat6 carried_by(const Vec3& arm, double length) {
  Mat6 motion = Mat6::Identity();
  motion.topRightCorner<3, 3>() = -skew(arm) / length;
  return motion;
}

/// The rows of a joint, over the velocities of its bodies and its speeds.
void add_joint(const Model& model, const State& state, std::size_t k, Eigen::Index first_speed, Eigen::Index row,
               MatX& equations) {
  const Joint& joint = model.joints[k];
  const double length = model.length_scale();
  const auto placed = [&](Side side) { return place(joint.on(side), state.bodies[joint.on(side).body]); };
  const PlacedFrame parent = placed(Side::parent);
  const PlacedFrame child = placed(Side::child);
  const auto add = [&](Side side, const Mat6& motion) {
    if (joint.on(side).body != kGround) equations.block<6, 6>(row, 6 * (joint.on(side).body - 1)) += motion;
  };
  add(Side::child, carried_by(child.lever, length));
  add(Side::parent, -carried_by(parent.lever + child.r_P - parent.r_P, length));
  const Mat6X S = read_motion(*joint.type, relative_motion(parent, child), state.q[k]).S;
  const std::vector<bool> turns = turning_speeds(*joint.type);
  for (Eigen::Index u = 0; u < S.cols(); ++u) {
    const double unit = turns[static_cast<std::size_t>(u)] ? 1.0 : length;
    equations.col(first_speed + u).segment<3>(row) = -unit / length * parent.A_joint * S.col(u).head<3>();
    equations.col(first_speed + u).segment<3>(row + 3) = -unit * parent.A_joint * S.col(u).tail<3>();
  }
}

/// The sign of the product of pivots; 0 where round-off may change it.
int sign_of_product(const VecX& pivots) {
  constexpr double kDoubtful = 1e-12;
  if (!(pivots.cwiseAbs().minCoeff() > kDoubtful * pivots.cwiseAbs().maxCoeff())) return 0;
  return (pivots.array() < 0.0).count() % 2 == 0 ? 1 : -1;
}

/// The same of a square matrix. The determinant of its orthogonal factor is -1 for each reflection in it.
int sign_of_determinant(const MatX& A) {
  const Eigen::ColPivHouseholderQR<MatX> factors(A);
  const bool is_mirrored = (factors.hCoeffs().array() != 0.0).count() % 2 != 0;
  return (is_mirrored ? -1 : 1) * sign_of_product(factors.matrixQR().diagonal()) *
         static_cast<int>(factors.colsPermutation().determinant());
}

}  // namespace

MatX velocity_equations(const Model& model, const State& state) {
  const double length = model.length_scale();
  std::vector<Eigen::Index> first_speed;
  auto columns = 6 * (static_cast<Eigen::Index>(model.bodies.size()) - 1);
  auto rows = static_cast<Eigen::Index>(6 * model.joints.size() + model.couplings.size());
  for (const Joint& joint : model.joints) {
    first_speed.push_back(columns);
    columns += joint.type->n_u();
    rows += static_cast<Eigen::Index>(joint.drivers.size());
  }
  MatX equations = MatX::Zero(rows, columns);
  Eigen::Index row = 0;
  for (std::size_t k = 0; k < model.joints.size(); ++k, row += 6) {
    add_joint(model, state, k, first_speed[k], row, equations);
  }
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    for (const Driver& driver : model.joints[k].drivers) {
      const int u = first_u(*model.joints[k].type, driver.word) + driver.component;
      equations(row++, first_speed[k] + u) = 1.0;
    }
  }
  for (const Coupling& coupling : model.couplings) {
    for (const CouplingTerm& term : coupling.terms) {
      const auto k = static_cast<std::size_t>(term.joint);
      const joints::JointType& type = *model.joints[k].type;
      const bool is_length = joints::is_length(type.permits[static_cast<std::size_t>(term.word)], term.component);
      equations(row, first_speed[k] + first_u(type, term.word) + term.component) +=
          term.factor * (is_length ? length : 1.0);
    }
    const double size = equations.row(row).norm();
    if (size > 0.0) equations.row(row) /= size;
    ++row;
  }
  return equations;
}

bool are_on_one_branch(const Model& model, const std::vector<Block>& blocks, const State& one, const State& other) {
  const MatX here = velocity_equations(model, one);
  const MatX there = velocity_equations(model, other);
  const auto is_held = [](const Block& block) { return block.rows.size() >= block.columns.size(); };
  if (!std::all_of(blocks.begin(), blocks.end(), is_held)) return true;
  const auto keeps_sign = [&](const Block& block) {
    // By M = Q R it is that of det R det(Q^T N), of which round-off hides no more than of det M and det N.
    const Eigen::HouseholderQR<MatX> factors(MatX(here(block.rows, block.columns)));
    const MatX turned = apply_transposed_factor(factors, there(block.rows, block.columns)).topRows(factors.cols());
    return sign_of_product(factors.matrixQR().diagonal()) * sign_of_determinant(turned) >= 0;
  };
  return std::all_of(blocks.begin(), blocks.end(), keeps_sign);
}

}  // namespace concord::compare::analyses
