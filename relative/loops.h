#pragma once

#include <vector>

#include "relative/closure.h"
#include "relative/elimination.h"

/// The part of closure in (21), (22): Phi_u udot = gamma through the Schur complement Lambda = Phi_u Mbar^-1 Phi_u^T.
namespace concord::relative {

/// Constraint forces of the cut joints, couplings and constraints of velocity. Lambda is summed over the links between
/// each of their joints and ground; those whose ways share no link do not couple. All memory is laid out at
/// construction.
class Loops {
 public:
  /// Both must outlive this object.
  Loops(const Kinematics& kinematics, const Closure& closure, Elimination& elimination);

  /// Keeps only these closure rows (all at first): the independent ones of a redundant machine.
  void keep_rows(const std::vector<int>& rows);
  [[nodiscard]] const std::vector<int>& kept_rows() const { return kept_; }

  /// After the tree has been solved with free loops (Elimination::inward, outward): finds lambda and solves the tree
  /// again, udot obeying the closure. If the kept rows have become dependent in this pose, others of the same number
  /// are chosen for it; throws SolverError if there are none: the rank has dropped below the machine's.
  void close(VecX& udot);

  /// Multipliers of all closure rows, zero in rows that are not kept. The cut joint's wrench on the child is -T lambda,
  /// the coordinate forces of a relation -C lambda.
  [[nodiscard]] const VecX& lambda() const { return lambda_; }

 private:
  /// One link on the way to ground, and what unit multipliers of the way's rows do there.
  struct Step {
    int link = 0;
    int next = -1;  // step of the reference body; -1 at ground
    Mat6X z_r;
    MatX z_a;
    MatX eps;
  };
  /// Where the multipliers of a way pull: wrenches on the two bodies of a cut joint, its closure's (part -1) or a
  /// relation's, or coordinate forces on a joint of the tree.
  struct Pull {
    int joint = 0;
    int part = -1;        // place among the relation's joints
    int child_step = -1;  // -1: ground
    int parent_step = -1;
    int own_step = -1;  // of the link of a joint of the tree
  };
  /// The rows of a cut joint or of a relation.
  struct Way {
    int cut = -1;
    int relation = -1;
    int first_row = 0;
    int n_rows = 0;
    std::vector<Pull> pulls;
    std::vector<Step> steps;  // inward
  };
  struct Shared {
    int way, step, other_way, other_step;
  };

  void lay_out_ways();
  void lay_out(Way way);
  void lay_out_shared();
  void pull(Way& way);
  void load(Way& way, const Pull& pull);
  void load_wrenches(Way& way, const Pull& pull, Side side, const Eigen::Ref<const Mat6X>& on_child);
  void sum_Lambda();
  [[nodiscard]] bool factorize(const std::vector<int>& rows);
  void choose_rows_of_this_pose();
  [[noreturn]] void throw_singular(std::size_t rank) const;
  void push_back(const VecX& lambda);

  const Kinematics* kinematics_;
  const Closure* closure_;
  Elimination* elimination_;
  std::vector<Way> ways_;
  std::vector<Shared> shared_;
  std::vector<int> kept_;
  std::vector<int> used_;  // kept_, or the choice of this pose
  MatX Lambda_;
  MatX selected_;
  Eigen::LLT<MatX> llt_{MatX::Identity(1, 1)};  // Eigen copies its outcome: there must be one
  VecX residual_;
  VecX solution_;
  VecX lambda_;
  VecX step_lambda_;
  VecX force_;
};

}  // namespace concord::relative
