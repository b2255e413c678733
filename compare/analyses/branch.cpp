#include "compare/analyses/branch.h"

#include <array>
#include <vector>

#include "common/decompositions.h"
#include "compare/audit/joint_motion.h"
#include "compare/audit/places.h"
#include "compare/verdict/observe.h"

namespace concord::compare::analyses {

namespace {

/// The body as it stands, moved by one of the units of its velocities: v [lengths/s], omega.
BodyState in_unit_motion(BodyState body, int component, double length) {
  body.v = component < 3 ? Vec3(length * Vec3::Unit(component)) : Vec3::Zero();
  body.omega = component < 3 ? Vec3::Zero() : Vec3(Vec3::Unit(component - 3));
  return body;
}

/// The rows of a joint, over the velocities of its bodies and its speeds.
void add_joint(const Model& model, const State& state, std::size_t k, Eigen::Index first_speed, Eigen::Index row,
               MatX& equations) {
  const Joint& joint = model.joints[k];
  const double length = model.length_scale();
  const std::array<std::size_t, 2> bodies{static_cast<std::size_t>(joint.sides[0].body),
                                          static_cast<std::size_t>(joint.sides[1].body)};
  const Mat3 to_global = place(joint.sides[0], state.bodies[bodies[0]]).A_joint;
  const auto in_units = [&](const Vec6& v_rel) {
    Vec6 row_values;
    row_values << to_global * v_rel.head<3>() / length, to_global * v_rel.tail<3>();
    return row_values;
  };
  for (std::size_t side = 0; side < 2; ++side) {
    if (bodies[side] == 0) continue;
    for (int component = 0; component < 6; ++component) {
      std::array<BodyState, 2> pair{state.bodies[bodies[0]], state.bodies[bodies[1]]};
      for (BodyState& body : pair) body.v = body.omega = Vec3::Zero();
      pair[side] = in_unit_motion(pair[side], component, length);
      const Vec6 v_rel = relative_motion(place(joint.sides[0], pair[0]), place(joint.sides[1], pair[1])).v_rel;
      const auto column = 6 * (static_cast<Eigen::Index>(bodies[side]) - 1) + component;
      equations.block<6, 1>(row, column) += in_units(v_rel);
    }
  }
  const JointMotion motion = read_motion(*joint.type, relative_motion_of(joint, state), state.q[k]);
  const std::vector<bool> turns = turning_speeds(*joint.type);
  for (Eigen::Index u = 0; u < motion.S.cols(); ++u) {
    const double unit = turns[static_cast<std::size_t>(u)] ? 1.0 : length;
    equations.block<6, 1>(row, first_speed + u) = -unit * in_units(motion.S.col(u));
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

bool are_on_one_branch(const Model& model, const State& one, const State& other) {
  const MatX M = velocity_equations(model, one);
  if (M.rows() < M.cols()) return true;
  // By M = Q R it is that of det R det(Q^T N), of which round-off hides no more than of det M and det N.
  const Eigen::HouseholderQR<MatX> factors(M);
  const MatX turned = apply_transposed_factor(factors, velocity_equations(model, other)).topRows(M.cols());
  return sign_of_product(factors.matrixQR().diagonal()) * sign_of_determinant(turned) >= 0;
}

}  // namespace concord::compare::analyses
