#pragma once

#include <array>
#include <optional>
#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "compare/audit/audit_ledger.h"
#include "compare/audit/carried_components.h"
#include "compare/audit/element_laws.h"
#include "compare/audit/free_body.h"
#include "compare/audit/law_of_force.h"
#include "compare/audit/motion_audit.h"
#include "compare/audit/round_off.h"

/// The third opinion: are a solver's motions and wrenches in balance, and do they obey joints and laws? Computed from
/// the results, mass points, modal stiffness and damping, laws and gravity alone; no solver's inertia terms, Jacobians
/// or multipliers are used, and no evaluator of a law that the solvers call.
namespace concord::compare {

/// What every rule found at one body, joint, force element or coupling.
struct AuditedPlace {
  enum class Kind { body, joint, element, coupling };
  Kind kind = Kind::body;
  int number = 0;  // in the model
  std::array<AuditFinding, kAuditRules> rules;

  [[nodiscard]] const AuditFinding& by(AuditRule rule) const { return rules[static_cast<std::size_t>(rule)]; }
};

/// What a body's forces leave over: six rigid rows [N, N m about its origin] and its modal ones, in the body's axes,
/// and the sizes of what was added up to them.
struct OutOfBalance {
  VecX rows;
  VecX scales;
};

struct AuditReport {
  long states = 0;
  /// The finding that is farthest below its need, or nearest to it; 16 digits if nothing was added.
  AuditFinding worst;
  std::array<AuditFinding, kAuditRules> rules;
  /// How many numbers each rule holds against zero in a state.
  std::array<int, kAuditRules> rows{};
  /// Free-body rows of every body, in the order of the model; ground (nothing is known of its mass) has 16 digits.
  std::vector<AuditFinding> bodies;
  /// For every joint, in the order of the model, the worst of its own rules and of the free-body rows of the bodies
  /// that it joins: a wrench is right only if both bodies move accordingly.
  std::vector<AuditFinding> joints;
  /// For every force element, and for every coupling, in the order of the model, the worst of its own rules.
  std::vector<AuditFinding> elements;
  std::vector<AuditFinding> couplings;
  /// Rule by rule: all bodies, joints, force elements and couplings, in this order and that of the model.
  std::vector<AuditedPlace> places;

  [[nodiscard]] double digits() const { return worst.digits; }
  /// Whether every rule reaches its need.
  [[nodiscard]] bool holds() const { return worst.holds(); }
};

/// Audits evaluated states of one model, one after the other. Scales are peaks over all of them: for the force rows of
/// a body the larger of the sum of its mass points' m (|acceleration| + |g|) and the largest force on it, likewise with
/// levers for moments and mode shapes for modal rows; for a joint or a force element its peak |F|, and max(peak |T|,
/// peak |F| l) with l the machine's length scale; each at least 1e-6 of the machine's largest, which for a machine that
/// carries nothing is its weight; of motions see MotionAudit. The model must outlive the auditor.
class Auditor {
 public:
  explicit Auditor(const Model& model);

  /// With `redraw`, what a body's forces leave over is no breach as far as it is the solver's own round-off there.
  void add(const State& state, const Evaluation& evaluation, const Redraw& redraw = {});

  [[nodiscard]] AuditReport report() const;

  /// d'Alembert's sum on one body in one state, which is zero for a right answer; nothing is recorded.
  [[nodiscard]] OutOfBalance out_of_balance(int body, const State& state, const Evaluation& evaluation) const;

 private:
  void lay_out_body(const Body& body);
  void lay_out_joint(int joint);
  void lay_out_element(const ForceElement& element);
  void add_body(int body, const State& state, const Evaluation& evaluation, OwnRoundOff& own);
  void add_joint(std::size_t joint, const State& state, const Evaluation& evaluation);
  void add_element(std::size_t element, const State& state, const ElementWrenches& wrenches);
  [[nodiscard]] AuditScales largest_scales() const;
  [[nodiscard]] AuditScales largest_terms(const AuditScales& largest) const;

  const Model& model_;
  double length_;
  bool has_laws_;
  /// Of the state that is being added: those that differ from it by round-off, if there are laws to ask.
  std::optional<std::array<State, 2>> moved_;
  FreeBodies free_bodies_;
  std::vector<std::vector<LawOfForce>> joint_springs_;  // of each joint
  std::vector<CarriedComponents> carried_;              // of each joint
  std::vector<ElementLaw> element_laws_;
  std::vector<AuditEntity> bodies_;
  std::vector<AuditEntity> beams_;  // of each body; without rows if it is none
  std::vector<AuditEntity> joints_;
  std::vector<AuditEntity> elements_;
  MotionAudit motions_;
  long states_ = 0;
};

}  // namespace concord::compare
