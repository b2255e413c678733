#include "relative/rank/rank.h"

#include <algorithm>
#include <cmath>

#include "common/decompositions.h"
#include "common/products.h"
#include "relative/rank/loop_rows.h"
#include "relative/rank/row_rank.h"

namespace concord::relative {

namespace {

constexpr double kSurelyZero = 1e-12;
constexpr double kSurelyKept = 1e-8;
/// A component that self-stresses of unit size move by less than this part of the largest one is unique.
constexpr double kUnmoved = 1e-8;
/// A flag that changes when both thresholds move by this factor, one way or the other, is undecided.
const double kHalfWay = std::sqrt(1000.0);

/// Rows that the tree holds by itself: forbidden directions of its joints and their drivers.
int tree_rows(const Equations& equations) {
  int rows = 0;
  for (const Link& link : equations.topology().links) {
    const Joint& joint = equations.model().joints[link.joint];
    rows += 6 - joint.type->n_u() + static_cast<int>(joint.drivers.size());
  }
  return rows;
}

/// What the self-stresses of a machine move: for each component the root of the sum of squares over an orthonormal set
/// of them, so that it does not matter which set; forces times the length of the machine beside torques, and the forces
/// of couplings as multipliers of their rows, which are free of units.
class SelfStressEffect {
 public:
  explicit SelfStressEffect(const Model& model)
      : joints_(model.joints.size()), couplings_(model.couplings.size(), 0.0) {}

  /// Adds the wrenches of one self-stress and its multipliers.
  void add(const Equations& equations, const JointReactions& stress, const VecX& lambda) {
    const double length = equations.size().length();
    const std::vector<JointWrenches>& joints = stress.joints;
    for (std::size_t k = 0; k < joints.size(); ++k) {
      for (const Side side : {Side::parent, Side::child}) {
        add_squares(joints[k].reaction_on(side), length, joints_[k].reaction[index(side)]);
        add_squares(joints[k].total_on(side), length, joints_[k].total[index(side)]);
      }
      const Span& span = equations.topology().joints[k];
      const auto units = equations.size().speeds().segment(span.first_u, span.n_u);
      joints_[k].tau.head(span.n_u) += joints[k].tau.cwiseProduct(units).cwiseAbs2();
      joints_[k].driver.head(span.n_u) += joints[k].share_of(Actor::driver).cwiseProduct(units).cwiseAbs2();
    }
    for (const SpeedConstraint& constraint : equations.closure().speed_constraints()) {
      const double squares = lambda.segment(constraint.first_row, constraint.n_rows).squaredNorm();
      of_speed_constraints_ = std::max(of_speed_constraints_, squares);
      if (constraint.is_coupling()) couplings_[*constraint.coupling] += squares;
    }
  }

  /// Flags with components moved by more than `unmoved` of the largest one: couplings may hold each other and move no
  /// reaction, so that their multipliers count beside the wrenches.
  void mark(double unmoved, std::vector<JointUniqueness>& joints, std::vector<bool>& couplings) const {
    const double least = unmoved * unmoved * size();
    joints.assign(joints_.size(), {});
    for (std::size_t k = 0; k < joints_.size(); ++k) {
      for (int side = 0; side < 2; ++side) {
        for (int c = 0; c < 6; ++c) {
          joints[k].unique[side][c] = !(joints_[k].reaction[side](c) > least);
          joints[k].unique_total[side][c] = !(joints_[k].total[side](c) > least);
        }
      }
      for (int c = 0; c < 6; ++c) {
        joints[k].unique_tau[c] = !(joints_[k].tau(c) > least);
        joints[k].unique_driver[c] = !(joints_[k].driver(c) > least);
      }
    }
    couplings.assign(couplings_.size(), true);
    for (std::size_t g = 0; g < couplings_.size(); ++g) couplings[g] = !(couplings_[g] > least);
  }

 private:
  struct Squares {
    std::array<Vec6, 2> reaction{Vec6::Zero(), Vec6::Zero()};
    std::array<Vec6, 2> total{Vec6::Zero(), Vec6::Zero()};
    Vec6 tau = Vec6::Zero();
    Vec6 driver = Vec6::Zero();
  };

  static void add_squares(const SideWrench& wrench, double length, Vec6& squares) {
    Vec6 moved = wrench.in_C.vector();
    moved.head<3>() *= length;
    squares += moved.cwiseAbs2();
  }

  [[nodiscard]] double size() const {
    double size = of_speed_constraints_;
    for (const Squares& joint : joints_) {
      for (const Vec6& total : joint.total) size = std::max(size, total.maxCoeff());
    }
    return size;
  }

  std::vector<Squares> joints_;
  std::vector<double> couplings_;
  double of_speed_constraints_ = 0.0;
};

void agree(const JointUniqueness& one, const JointUniqueness& other, JointUniqueness& same) {
  for (int side = 0; side < 2; ++side) {
    for (int c = 0; c < 6; ++c) {
      same.unique[side][c] = one.unique[side][c] == other.unique[side][c];
      same.unique_total[side][c] = one.unique_total[side][c] == other.unique_total[side][c];
    }
  }
  for (int c = 0; c < 6; ++c) {
    same.unique_tau[c] = one.unique_tau[c] == other.unique_tau[c];
    same.unique_driver[c] = one.unique_driver[c] == other.unique_driver[c];
  }
}

/// The flags, and which of them stay with stricter and looser thresholds (R67), (R68).
void decide_uniqueness(const ScaledClosure& scaled, const Motion& motion, const RowRank& rows, RankReport& report) {
  Equations& equations = scaled.equations();
  std::array<std::vector<JointUniqueness>, 3> joints;
  std::array<std::vector<bool>, 3> couplings;
  const std::array<double, 3> factors{1.0 / kHalfWay, 1.0, kHalfWay};
  for (std::size_t step = 0; step < factors.size(); ++step) {
    const MatX stresses = rows.vanishing_combinations(rows.rank(kDependentPart * factors[step]));
    SelfStressEffect moved(equations.model());
    for (Eigen::Index z = 0; z < stresses.cols(); ++z) {
      const VecX lambda = stresses.col(z).cwiseQuotient(scaled.closure().row_units());
      moved.add(equations, equations.compute_self_stress(motion, lambda), stresses.col(z));
    }
    moved.mark(kUnmoved / factors[step], joints[step], couplings[step]);
  }
  report.joints = joints[1];
  report.unique_coupling = couplings[1];
  report.decided.resize(report.joints.size());
  for (std::size_t k = 0; k < report.joints.size(); ++k) agree(joints[0][k], joints[2][k], report.decided[k]);
  report.decided_coupling.resize(report.unique_coupling.size());
  for (std::size_t g = 0; g < report.unique_coupling.size(); ++g) {
    report.decided_coupling[g] = couplings[0][g] == couplings[2][g];
  }
}

}  // namespace

RankReport analyze_rank(const ScaledClosure& scaled, const Coordinates& coordinates) {
  Equations& equations = scaled.equations();
  const Motion& motion = equations.move(coordinates.t, coordinates.q, coordinates.u);
  RankReport report;
  report.joints.resize(equations.model().joints.size());
  report.decided = report.joints;
  report.unique_coupling.assign(equations.model().couplings.size(), true);
  report.decided_coupling = report.unique_coupling;
  const int n_rows = equations.closure().n_rows();
  int rank = n_rows;
  if (const std::optional<double> clear = LoopRows(scaled).find_clear_singular_value()) {
    report.smallest_kept = *clear;
  } else {
    const RowRank rows(scaled.rows(scaled.free_columns()));
    rank = rows.rank();
    report.smallest_kept = rank > 0 ? rows.relative_singular_value(rank) : 0.0;
    report.largest_dropped = rows.pivot(rank);
    report.undecided = (rank > 0 && report.smallest_kept < kSurelyKept) || report.largest_dropped > kSurelyZero;
    if (rank < n_rows || report.undecided) decide_uniqueness(scaled, motion, rows, report);
  }
  const int tree = tree_rows(equations);
  report.constraints = tree + n_rows;
  report.rank = tree + rank;
  report.degrees_of_freedom = static_cast<int>(scaled.free_columns().size()) - rank;
  return report;
}

MatX permitted_velocities(const ScaledClosure& scaled, const Coordinates& coordinates) {
  Equations& equations = scaled.equations();
  equations.move(coordinates.t, coordinates.q, coordinates.u);
  const std::vector<int>& free = scaled.free_columns();
  const MatX N = RowRank(scaled.rows(free)).free_directions();
  const VecX& speeds = scaled.size().speeds();
  const VecX units = speeds(free);
  const MatX B = equations.kinematics().explicit_B_of_origins();
  MatX velocities = product(B(Eigen::all, free) * units.asDiagonal(), N);
  const double length = equations.model().length_scale();  // as every solver counts them
  VecX sizes = VecX::Ones(velocities.rows());
  for (std::size_t i = 1; i < equations.model().bodies.size(); ++i) {
    const auto first = equations.kinematics().first_row(BodyIndex(i));
    velocities.middleRows<3>(first) /= length;
    const Span& modes = equations.topology().modes[BodyIndex(i)];
    sizes.segment(first + 6, modes.n_u) = speeds.segment(modes.first_u, modes.n_u);
  }
  return sizes.asDiagonal() * orthonormal_columns(sizes.cwiseInverse().asDiagonal() * velocities);
}

}  // namespace concord::relative
