#pragma once

#include <vector>

#include "relative/closure.h"
#include "relative/elimination.h"

/// The loops' part of (21), (22): Phi_u udot = gamma through the Schur complement Lambda = Phi_u Mbar^-1 Phi_u^T.
namespace concord::relative {

/// Constraint forces of the cut joints. Lambda is summed over the links between each cut joint and ground; cut joints
/// whose ways share no link do not couple. All memory is laid out at construction.
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

  /// Multipliers of all closure rows, zero in rows that are not kept. The cut joint's wrench on the child is -T lambda.
  [[nodiscard]] const VecX& lambda() const { return lambda_; }

 private:
  /// One link on the way from a cut joint to ground, and what unit multipliers of the cut's rows do there.
  struct Step {
    int link = 0;
    int next = -1;  // step of the reference body; -1 at ground
    Mat6X z_r;
    MatX z_a;
    MatX eps;
  };
  struct Way {
    int cut = 0;
    std::vector<Step> steps;  // inward
    int child_step = -1;      // -1: ground
    int parent_step = -1;
  };
  struct Shared {
    int way, step, other_way, other_step;
  };

  void lay_out(int cut);
  void pull(Way& way);
  void load(Way& way, int step, Side side);
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
