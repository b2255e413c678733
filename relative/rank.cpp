#include "relative/rank.h"

#include <algorithm>

namespace concord::relative {

namespace {

constexpr double kThreshold = 1e-10;
constexpr double kSurelyZero = 1e-12;
constexpr double kSurelyKept = 1e-8;
/// A component of a self-stress below this part of the largest one of its kind is zero.
constexpr double kUnmoved = 1e-8;

/// Phi_u in machine units over the free columns, and the factors that turn multipliers of these rows into lambda. The
/// rows T^T W have unit norm in these units; to norm Phi_u itself would blow up rows that vanish but for round-off.
struct ScaledRows {
  MatX Phi;
  VecX units;
  std::vector<Eigen::Index> free;
};

ScaledRows free_rows(Equations& equations, const Scales& scales) {
  const Closure& closure = equations.closure();
  const MatX all = scales.scaled(closure.Phi_u(), closure);
  std::vector<Eigen::Index> free;
  for (Eigen::Index c = 0; c < all.cols(); ++c) {
    if (equations.driven()[c] == 0) free.push_back(c);
  }
  return {all(Eigen::all, free), scales.rows(closure).cwiseInverse(), free};
}

/// Rows that the tree holds by itself: forbidden directions of its joints and their drivers.
int tree_rows(const Equations& equations) {
  int rows = 0;
  for (const Link& link : equations.topology().links) {
    const Joint& joint = equations.model().joints[link.joint];
    rows += 6 - joint.type->n_u() + static_cast<int>(joint.drivers.size());
  }
  return rows;
}

/// Relations are free of units: their multipliers count as torques.
double largest_of_relations(const Closure& closure, const VecX& lambda) {
  double largest = 0.0;
  for (const Relation& relation : closure.relations()) {
    largest = std::max(largest, lambda.segment(relation.first_row, relation.n_rows).cwiseAbs().maxCoeff());
  }
  return largest;
}

/// Marks the components that the wrenches of one self-stress move; forces count against the largest force times the
/// length of the machine, and torques alike, beside multipliers of relations: couplings may hold each other and move no
/// reaction.
void mark(const Kinematics& kinematics, const std::vector<JointWrenches>& joints, double length, double of_relations,
          std::vector<JointUniqueness>& flags) {
  double size = of_relations;
  for (const JointWrenches& joint : joints) {
    for (const SideWrench& side : joint.total) {
      size = std::max({size, length * side.in_C.force.cwiseAbs().maxCoeff(), side.in_C.torque.cwiseAbs().maxCoeff()});
    }
  }
  for (std::size_t k = 0; k < joints.size(); ++k) {
    const auto mark_moved = [&](const SideWrench& wrench, std::array<bool, 6>& unique) {
      for (int c = 0; c < 6; ++c) {
        const double moved = wrench.in_C.vector()(c) * (c < 3 ? length : 1.0);
        if (std::abs(moved) > kUnmoved * size) unique[c] = false;
      }
    };
    for (const Side side : {Side::parent, Side::child}) {
      mark_moved(joints[k].reaction_on(side), flags[k].unique[index(side)]);
      mark_moved(joints[k].total_on(side), flags[k].unique_total[index(side)]);
    }
    const Motion& motion = kinematics.motion(static_cast<int>(k));
    for (int c = 0; c < motion.n_u(); ++c) {
      const double moved = joints[k].tau(c) * (motion.kind(c).is_length ? length : 1.0);
      if (std::abs(moved) > kUnmoved * size) flags[k].unique_tau[c] = false;
    }
  }
}

}  // namespace

RankReport analyze_rank(Equations& equations, const Scales& scales, const Coordinates& coordinates) {
  equations.move(coordinates.t, coordinates.q, coordinates.u);
  const ScaledRows rows = free_rows(equations, scales);
  RankReport report;
  report.joints.resize(equations.model().joints.size());
  const int n_rows = equations.closure().n_rows();
  int rank = 0;
  if (n_rows > 0) {
    // Where drivers hold every column, one of zeros stands for them: no row has rank, and all can carry self-stress.
    const Eigen::JacobiSVD<MatX> svd(rows.free.empty() ? MatX::Zero(n_rows, 1) : rows.Phi, Eigen::ComputeFullU);
    // Rows of unit norm over speeds of unit size: where all of them vanish, the largest is round-off, and 1 the scale.
    const VecX relative = svd.singularValues() / std::max(svd.singularValues()(0), 1.0);
    rank = static_cast<int>((relative.array() > kThreshold).count());
    report.undecided = (relative.array() > kSurelyZero && relative.array() < kSurelyKept).any();
    report.smallest_kept = rank > 0 ? relative(rank - 1) : 0.0;
    report.largest_dropped = rank < relative.size() ? relative(rank) : 0.0;
    for (int z = rank; z < n_rows; ++z) {
      const VecX lambda = rows.units.cwiseProduct(svd.matrixU().col(z));
      equations.reactions().compute_self_stress(lambda);
      mark(equations.kinematics(), equations.reactions().joints(), scales.length(),
           largest_of_relations(equations.closure(), lambda), report.joints);
    }
  }
  const int tree = tree_rows(equations);
  report.constraints = tree + n_rows;
  report.rank = tree + rank;
  report.degrees_of_freedom = static_cast<int>(rows.Phi.cols()) - rank;
  return report;
}

MatX permitted_velocities(Equations& equations, const Scales& scales, const Coordinates& coordinates) {
  equations.move(coordinates.t, coordinates.q, coordinates.u);
  const ScaledRows rows = free_rows(equations, scales);
  const auto n_free = static_cast<Eigen::Index>(rows.free.size());
  MatX N = MatX::Identity(n_free, n_free);
  if (rows.Phi.size() > 0) {
    const Eigen::JacobiSVD<MatX> svd(rows.Phi, Eigen::ComputeFullV);
    const VecX& sigma = svd.singularValues();
    const Eigen::Index rank = (sigma.array() > kThreshold * std::max(sigma(0), 1.0)).count();
    N = svd.matrixV().rightCols(n_free - rank);
  }
  const VecX units = scales.speeds()(rows.free);
  const MatX B = equations.kinematics().explicit_B();
  MatX velocities = B(Eigen::all, rows.free) * units.asDiagonal() * N;
  for (std::size_t i = 1; i < equations.model().bodies.size(); ++i) {
    velocities.middleRows<3>(equations.kinematics().first_row(static_cast<int>(i))) /= scales.length();
  }
  const Eigen::HouseholderQR<MatX> qr(velocities);
  return qr.householderQ() * MatX::Identity(velocities.rows(), velocities.cols());
}

}  // namespace concord::relative
