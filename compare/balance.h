#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "common/model.h"
#include "common/results.h"

/// The third opinion: are a solver's motions and wrenches in balance? Computed from the results, mass points, modal
/// stiffness and damping, force laws and gravity alone; no solver's inertia terms, Jacobians or multipliers are used.
namespace concord::compare {

/// What the audit demands of every state.
enum class AuditRule {
  free_body,   // d'Alembert on every body: 6 + m rows against the total wrenches that act on it
  workless,    // reactions vanish along permitted directions, eq. S^T [F; T] = 0
  both_sides,  // F_j = -F_i, T_j = -(T_i + (r_Pi - r_Pj) x F_i), of joints and of force elements
  two_frames,  // components in the joint frame (or an element's end frame) and in global axes are one vector
  drivers,     // S^T [F; T] of the total wrench on the child is tau; total minus reaction is its coordinate wrench
  force_law    // each element's wrench is what its law says of the state, and tau what springs, actuators and couplings
               // add
};
inline constexpr int kAuditRules = 6;

/// "free body", "workless", ...
std::string_view name_of(AuditRule rule);

/// The worst that a rule met, over all states added.
struct AuditFinding {
  /// -log10(residual / scale), between 0 and 16; 0 if the residual is not a number.
  double digits = 16.0;
  double residual = 0.0;  // N, N m, or J per unit of a modal coordinate
  double scale = 0.0;
  double t = 0.0;  // s, where the residual is largest
  AuditRule rule = AuditRule::free_body;
  std::string where;  // a body, a joint or a force element
  std::string row;    // "F_x", "mode 3", "T_y of reaction on parent", "tau"; empty if there was nothing to audit
  /// The scale is 1e-6 of the machine's largest, because the body's or joint's own is smaller.
  bool floored = false;

  /// All of it in one line: "free body: coupler, T_y, t = 1.284 s: residual 3.1e-11, scale 2.4, 10.9 digits".
  [[nodiscard]] std::string text() const;
};

struct AuditReport {
  long states = 0;
  /// The worst of everything; 16 digits if nothing was added.
  AuditFinding worst;
  std::array<AuditFinding, kAuditRules> rules;
  /// Free-body rows of every body, in the order of the model; ground (nothing is known of its mass) has 16 digits.
  std::vector<AuditFinding> bodies;
  /// For every joint, in the order of the model, the worst of its own rules and of the free-body rows of the bodies
  /// that it joins: a wrench is right only if both bodies move accordingly.
  std::vector<AuditFinding> joints;
  /// For every force element, in the order of the model, the worst of its own rules.
  std::vector<AuditFinding> elements;

  [[nodiscard]] double digits() const { return worst.digits; }
};

/// Audits evaluated states of one model, one after the other. Scales are peaks over all of them: for the force rows of
/// a body the larger of the sum of its mass points' |m (acceleration - g)| and the largest force on it, likewise with
/// levers for moments and mode shapes for modal rows; for a joint or a force element its peak |F|, and max(peak |T|,
/// peak |F| l) with l the machine's length scale. The model must outlive the auditor.
class Auditor {
 public:
  explicit Auditor(const Model& model);

  void add(const State& state, const Evaluation& evaluation);

  [[nodiscard]] AuditReport report() const;

 private:
  enum class Unit { force, torque, modal };
  struct Row {
    AuditRule rule;
    std::string name;
    Unit unit;
    double residual = 0.0;
    double scale = 0.0;
    double t = 0.0;

    void take(double new_residual, double new_scale, double at_t);
  };
  struct Entity {
    std::string name;
    std::vector<Row> rows;
    /// A joint that can carry nothing has no scale of its own: it is held against the machine's largest.
    bool is_idle = false;

    /// Residuals of the rows in their order, at a time, with the scales of forces and of torques there.
    void take(const VecX& residuals, double force, double torque, double at_t);
  };

  void add_body(int body, const State& state, const Evaluation& evaluation);
  void add_joint(std::size_t joint, const State& state, const Evaluation& evaluation);
  void add_element(std::size_t element, const State& state, const ElementWrenches& wrenches);
  using Scales = std::array<double, 3>;  // by unit
  [[nodiscard]] Scales largest_scales() const;
  static AuditFinding worst_of(const Entity& entity, AuditRule rule, const Scales& largest);

  const Model& model_;
  double length_;
  std::vector<std::vector<MassPoint>> mass_points_;  // of each body
  std::vector<Entity> bodies_;
  std::vector<Entity> joints_;
  std::vector<Entity> elements_;
  long states_ = 0;
};

/// Kinetic energy plus potential energy of gravity (zero at the origin) plus strain energy of the modes [J].
double mechanical_energy(const Model& model, const State& state);

/// How well a run keeps its energy: largest |E(t) - E(0) - work(t)|, relative to the largest of kinetic energy, range
/// of potential and strain energy, and work; at least a millionth of what the largest force would do along the
/// machine's length, which is what a machine at rest is held against.
struct EnergyReport {
  double error = 0.0;  // J
  double scale = 0.0;  // J
  double t = 0.0;      // s, where the error is largest

  [[nodiscard]] double relative() const { return scale > 0.0 ? error / scale : error; }
};
EnergyReport audit_energy(const Model& model, const Trajectory& trajectory);

}  // namespace concord::compare
