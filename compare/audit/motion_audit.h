#pragma once

#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "compare/audit/audit_ledger.h"
#include "compare/audit/joint_kinematics.h"
#include "compare/audit/law_of_time.h"

namespace concord::compare {

/// The third opinion on motions: do positions, velocities and accelerations obey joints, drivers and couplings, and are
/// the derivatives of joints by functions right? Scales are the speeds and accelerations of a joint's two places, at
/// least what gravity and the largest force give to the machine's mass along its length, and a part of the fastest
/// body's: solvers close a machine as well as its largest speed lets them. The model must outlive it.
class MotionAudit {
 public:
  explicit MotionAudit(const Model& model);

  void add(const State& state, const Evaluation& evaluation);

  [[nodiscard]] const std::vector<AuditEntity>& joints() const { return joints_; }
  /// Of all bodies [kg].
  [[nodiscard]] double mass() const { return mass_; }
  [[nodiscard]] const std::vector<AuditEntity>& couplings() const { return couplings_; }

 private:
  void lay_out(const Joint& joint);
  /// What scales are at least.
  struct LeastScales {
    double of_forces = 0.0;     // m/s2
    double speed = 0.0;         // m/s
    double acceleration = 0.0;  // m/s2
  };

  void add_joint(std::size_t joint, const State& state, const Evaluation& evaluation, const LeastScales& least);
  void add_coupling(std::size_t coupling, double t);
  [[nodiscard]] VecX expected_udot(std::size_t joint, double t) const;
  [[nodiscard]] LeastScales least_scales(const State& state, const Evaluation& evaluation) const;
  [[nodiscard]] AuditScales scales_of(const JointKinematics& found, const State& state, const Joint& joint,
                                      const LeastScales& least) const;

  const Model& model_;
  double length_;
  double mass_ = 0.0;
  std::vector<VecX> ways_;                       // largest_ways() of each body
  std::vector<std::vector<LawOfTime>> drivers_;  // of each joint
  std::vector<AuditEntity> joints_;
  std::vector<AuditEntity> couplings_;
  std::vector<std::vector<int>> coupled_speeds_;  // of each joint
  // Of the state that is being added, for each joint.
  std::vector<JointKinematics> kinematics_;
  std::vector<AuditScales> scales_;
};

}  // namespace concord::compare
