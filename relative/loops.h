#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "common/decompositions.h"
#include "relative/articulated_bodies.h"
#include "relative/closure.h"

/// The part of closure in (R32): Phi_u udot = gamma through the Schur complement Lambda = Phi_u Mbar^-1 Phi_u^T.
namespace concord::relative {

/// Constraint forces of the cut joints, couplings and nonholonomic constraints. Lambda is summed over the links between
/// each of their joints and ground; those whose paths share no link do not couple. All memory is laid out at
/// construction.
class Loops {
 public:
  /// Both must outlive this object.
  Loops(const Kinematics& kinematics, const Closure& closure, ArticulatedBodies& articulated_bodies);

  /// Takes the number of independent closure rows in a general pose (all at first).
  void set_rank(int rank);
  [[nodiscard]] int rank() const { return rank_; }

  /// After the tree has been solved with free loops (the passes of ArticulatedBodies): finds lambda and solves the tree
  /// again, udot obeying the closure. Where a machine is redundant, the independent rows are chosen anew in each pose,
  /// by the pose alone. Throws SingularPose if there are too few.
  void close(VecX& udot);

  /// The smallest pivot of the rows used last, in Lambda scaled to unit diagonal: the square of the sine between a row
  /// and those before it, in the metric of the inverse inertia; 1 without rows.
  [[nodiscard]] double least_pivot() const { return least_pivot_; }
  /// The rows used last.
  [[nodiscard]] const std::vector<int>& used_rows() const { return used_; }

  /// A closure row that is not used because it depends on others in this pose, and that the accelerations found by
  /// those violate: the worst of those that miss by more than `allowed` [1/s2], lengths in units of the machine's; if
  /// any does.
  [[nodiscard]] std::optional<int> contradicted_row(double allowed) const;

  /// Within a step of an integrator the rows stay those of its first evaluation after this call, as long as they are
  /// independent: between rows that agree in a closed pose the stages of a step would else jump.
  void keep_rows() {
    keeps_rows_ = true;
    has_kept_ = false;
  }
  /// Rows are chosen in each pose again.
  void free_rows() { keeps_rows_ = false; }

  /// Multipliers of all closure rows, zero in rows that are not used. The cut joint's wrench on the child is -T lambda,
  /// the coordinate forces of a speed constraint -C lambda.
  [[nodiscard]] const VecX& lambda() const { return lambda_; }

 private:
  /// One link on the path to ground: the generalized forces that reach it from unit multipliers of the path's rows, and
  /// the response of its unknowns to them.
  struct PathLink {
    int link = 0;
    std::optional<int> next;  // the path's link of the reference body; none at ground
    Mat6X z_r;
    MatX z_a;
    MatX unit_response;
  };
  /// The multipliers of a cut joint's closure, or of a speed constraint, act by wrenches on the two bodies of a cut
  /// joint: on these links of the path; none is ground.
  struct WrenchLoad {
    int joint = 0;
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
    int cut = 0;
  };
  struct SpeedRows {
    int constraint = 0;
  };
  /// The rows of a cut joint, with one load, or of a speed constraint, with one for each of its joints.
  struct LoopPath {
    std::variant<CutRows, SpeedRows> owner;
    int first_row = 0;
    int n_rows = 0;
    std::vector<MultiplierLoad> loads;
    std::vector<PathLink> links;  // outermost first
  };
  struct SharedLink {
    int path, link, other_path, other_link;
  };

  void lay_out_paths();
  void lay_out(LoopPath path, const std::vector<int>& joints);
  [[nodiscard]] std::vector<int> links_to_ground(const std::vector<int>& joints) const;
  void lay_out_shared();
  void compute_unit_responses(LoopPath& path);
  void apply_unit_multipliers(LoopPath& path);
  void apply_unit_wrenches(LoopPath& path, const WrenchLoad& load, const Eigen::Ref<const Mat6X>& on_child);
  void apply_unit_wrenches(LoopPath& path, const WrenchLoad& load, Side side, const Eigen::Ref<const Mat6X>& on_child);
  void sum_Lambda();
  void choose_rows();
  void use(int pivot);
  [[nodiscard]] bool are_kept_rows_sound();
  void select();
  void factorize();
  void factorize_stacked();
  void solve(VecX& right) const;
  [[noreturn]] void throw_singular(int row) const;
  void apply_constraint_forces(const VecX& lambda);

  const Kinematics* kinematics_;
  const Closure* closure_;
  ArticulatedBodies* articulated_bodies_;
  std::vector<LoopPath> paths_;
  std::vector<SharedLink> shared_;
  int rank_ = 0;
  std::vector<int> used_;
  bool keeps_rows_ = false;
  bool has_kept_ = false;                          // whether used_ are the rows to keep
  std::vector<std::optional<int>> first_of_link_;  // rows of stacked_ where a link's unknowns begin, if on a path
  MatX Lambda_;
  VecX scale_;                                  // of the rows: 1 / sqrt of the diagonal of Lambda
  MatX rest_;                                   // of Lambda scaled to unit diagonal, while rows are chosen
  MatX selected_;                               // used rows of Lambda, scaled
  Eigen::LLT<MatX> llt_{MatX::Identity(1, 1)};  // Eigen copies its outcome: there must be one
  MatX stacked_;                                // unit_response of the used rows, scaled: Lambda = stacked^T stacked
  Eigen::ColPivHouseholderQR<MatX> qr_;
  bool is_orthogonal_ = false;  // whether qr_ is used instead of llt_
  double least_pivot_ = 1.0;
  VecX residual_;
  VecX solution_;
  VecX lambda_;
  VecX lambda_correction_;
  VecX force_;
  mutable VecX permuted_;
};

}  // namespace concord::relative
