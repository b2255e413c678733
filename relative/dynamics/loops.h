#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "relative/closure/closure.h"
#include "relative/dynamics/articulated_inertias.h"
#include "relative/dynamics/independent_rows.h"
#include "relative/dynamics/lambda_blocks.h"
#include "relative/dynamics/multiplier_factors.h"
#include "relative/dynamics/tree_accelerations.h"

/// The part of closure in (R32): Phi_u udot = gamma through the Schur complement Lambda = Phi_u Mbar^-1 Phi_u^T.
namespace concord::relative {

/// How the loops, couplings and nonholonomic constraints of a machine hold it in one pose.
struct LoopSolution {
  /// Multipliers of all closure rows, zero in rows that are not used. The cut joint's wrench on the child is -T lambda,
  /// the coordinate forces of a speed constraint -C lambda.
  VecX lambda;
  /// The rows that are used.
  IndependentRows used;
  /// The smallest pivot of these, in Lambda scaled to unit diagonal: the square of the sine between a row and those
  /// before it, in the metric of the inverse inertia; 1 without rows.
  double least_pivot = 1.0;
  /// What is left of the acceleration closure, of all rows.
  VecX residual;

  /// A closure row that is not used because it depends on others in this pose, and that the accelerations found by
  /// those violate: the worst of those that miss by more than `allowed` [1/s2], lengths in units of the machine's
  /// (those of the rows are `row_units`); if any does.
  [[nodiscard]] std::optional<RowIndex> contradicted_row(const VecX& row_units, double allowed) const;
};

/// Constraint forces of the cut joints, couplings and nonholonomic constraints. Lambda is summed over the links between
/// each of their joints and ground; those whose paths share no link do not couple. All memory is laid out at
/// construction.
class Loops {
 public:
  /// For the links of these inertias, which need not be computed yet. Kinematics and closure must outlive this object.
  Loops(const Kinematics& kinematics, const Closure& closure, const ArticulatedInertias& tree);

  /// Takes the number of independent closure rows in a general pose (all at first).
  void set_rank(int rank);
  [[nodiscard]] int rank() const { return rank_; }

  /// Closes the loops of a tree that has been solved with free ones: finds lambda and solves the accelerations again,
  /// so that they obey the closure. Where a machine is redundant, the independent rows are chosen anew in each pose, by
  /// the pose alone, unless keep_rows() holds them. Throws SingularPose if there are too few.
  const LoopSolution& close(const ArticulatedInertias& tree, TreeAccelerations& accelerations);

  /// The last one.
  [[nodiscard]] const LoopSolution& solution() const { return solution_; }

  /// Within a step of an integrator the rows stay those of its first evaluation after this call, as long as they are
  /// independent and none has almost vanished: between rows that agree in a closed pose the stages of a step would else
  /// jump.
  void keep_rows() {
    keeps_rows_ = true;
    has_kept_ = false;
  }
  /// Takes round-off out of the closure once more, after the accelerations have been refined.
  void close_again(const ArticulatedInertias& tree, TreeAccelerations& accelerations) {
    if (rank_ > 0) refine(tree, accelerations);
  }
  /// Rows are chosen in each pose again.
  void free_rows() { keeps_rows_ = false; }

 private:
  /// One link on the path to ground: the generalized forces that reach it from unit multipliers of the path's rows, and
  /// the response of its unknowns to them.
  struct PathLink {
    LinkIndex link;
    std::optional<int> next;  // the path's link of the reference body; none at ground
    Mat6X z_r;
    MatX z_a;
    MatX unit_response;
  };
  /// The multipliers of a cut joint's closure, or of a speed constraint, act by wrenches on the two bodies of a cut
  /// joint: on these links of the path; none is ground.
  struct WrenchLoad {
    JointIndex joint;
    std::optional<int> child_link;
    std::optional<int> parent_link;
  };
  /// They act by coordinate forces on a joint of the tree.
  struct CoordinateLoad {
    int own_link = 0;
  };
  using MultiplierLoad = std::variant<WrenchLoad, CoordinateLoad>;
  /// Whose rows a path's are: a cut joint's (index in Closure::cuts) or a speed constraint's.
  struct CutRows {
    CutIndex cut;
  };
  struct SpeedRows {
    int constraint = 0;
  };
  /// The rows of a cut joint, with one load, or of a speed constraint, with one for each of its joints.
  struct LoopPath {
    std::variant<CutRows, SpeedRows> owner;
    RowIndex first_row;
    int n_rows = 0;
    std::vector<MultiplierLoad> loads;
    std::vector<PathLink> links;  // outermost first
  };
  /// A link on two paths, or twice the same: what it adds to a block of Lambda, rows by the first.
  struct SharedLink {
    int block;
    int path, link, other_path, other_link;
  };

  [[nodiscard]] std::vector<LoopPath> lay_out_paths(const ArticulatedInertias& tree) const;
  [[nodiscard]] LoopPath lay_out(const ArticulatedInertias& tree, LoopPath path,
                                 const std::vector<JointIndex>& joints) const;
  [[nodiscard]] std::vector<LinkIndex> links_to_ground(const std::vector<JointIndex>& joints) const;
  [[nodiscard]] EliminationOrder order_of_paths() const;
  void lay_out_shared();
  void lay_out_stacked(const ArticulatedInertias& tree);
  void compute_unit_responses(const ArticulatedInertias& tree, LoopPath& path);
  void apply_unit_multipliers(const ArticulatedInertias& tree, LoopPath& path);
  void apply_unit_wrenches(LoopPath& path, const WrenchLoad& load, const Eigen::Ref<const Mat6X>& on_child);
  void apply_unit_wrenches(LoopPath& path, const WrenchLoad& load, Side side, const Eigen::Ref<const Mat6X>& on_child);
  void sum_Lambda();
  void choose_rows();
  void factorize();
  void stack_unit_responses();
  [[noreturn]] void throw_singular(RowIndex row) const;
  void refine(const ArticulatedInertias& tree, TreeAccelerations& accelerations);
  [[nodiscard]] double select_residual();
  void apply_constraint_forces(const VecX& lambda, TreeAccelerations& accelerations);

  const Kinematics* kinematics_;
  const Closure* closure_;
  std::vector<LoopPath> paths_;
  LambdaBlocks Lambda_;
  std::vector<SharedLink> shared_;
  int rank_ = 0;
  bool keeps_rows_ = false;
  bool has_kept_ = false;                          // whether the rows of the solution are those to keep
  std::vector<std::optional<int>> first_of_link_;  // stacked rows where a link's unknowns begin, if on a path
  Eigen::Index n_stacked_ = 0;
  VecX diagonal_;                   // of Lambda
  MatX dense_Lambda_;               // all of it, for the choice of rows
  double least_kept_weight_ = 0.0;  // below which one of the kept rows has almost vanished
  RowChoice choice_;
  MultiplierFactors factors_;
  LoopSolution solution_;
  VecX right_;  // of the used rows, and what solves them
  VecX lambda_correction_;
  VecX force_;
  std::vector<int> slides_;  // speeds that are lengths per second, and those that are angles
  std::vector<int> turns_;
};

}  // namespace concord::relative
