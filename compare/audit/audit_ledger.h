#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "common/types.h"

/// The third opinion's books: its rules, and the worst that each row of each rule met.
namespace concord::compare {

/// What the audit demands of every state.
enum class AuditRule {
  free_body,   // d'Alembert on every body: 6 + m rows against the total wrenches that act on it
  workless,    // reactions vanish along permitted directions, S^T [F; T] = 0 (S24)
  both_sides,  // F_j = -F_i, T_j = -(T_i + (r_Pi - r_Pj) x F_i), of joints and of force elements
  two_frames,  // components in the joint frame (or an element's end frame) and in global axes are one vector
  drivers,     // S^T [F; T] of the total wrench on the child is tau; total minus reaction is its coordinate wrench
  force_law,   // each element's wrench is what its law says of the state, and tau what springs, actuators and couplings
               // add
  kinematics,  // positions, velocities and accelerations of the bodies are such as the joints permit
  driver_law,  // a driven coordinate follows its law, q = f, u = f', udot = f''; coupled ones keep their relation
  derivatives,  // the derivatives of a joint type that is given by functions are those of the functions' values
  modal_data    // nodes, masses, stiffness and damping of a beam's modes are those of the beam that is stated
};
inline constexpr int kAuditRules = 10;

/// "free body", "workless", ...
std::string_view name_of(AuditRule rule);

/// What a solver does that breaks a rule: "is not in balance", "does not move as joints and laws say", ...
std::string_view breach_of(AuditRule rule);

inline constexpr double kAudit = 9.0;
/// Of the audit's rules on motions, which rest on difference quotients and on how well a run holds its constraints.
inline constexpr double kAuditByDifferences = 7.0;

/// Digits that a rule must reach: kAudit, or kAuditByDifferences where it rests on difference quotients.
double need_of(AuditRule rule);

/// The worst that a rule met, over all states added.
struct AuditFinding {
  /// -log10(residual / scale), between 0 and 16; 0 if the residual is not a number.
  double digits = 16.0;
  double residual = 0.0;  // N, N m, or J per unit of a modal coordinate; of motions m, rad, and their rates
  double scale = 0.0;
  double t = 0.0;  // s, where the residual is largest
  AuditRule rule = AuditRule::free_body;
  std::string where;  // a body, a joint, a force element or a coupling
  std::string row;    // "F_x", "mode 3", "T_y of reaction on parent", "tau"; empty if there was nothing to audit
  /// The scale is 1e-6 of the machine's largest, because the body's or joint's own is smaller.
  bool floored = false;

  [[nodiscard]] bool holds() const { return digits >= need_of(rule); }
  /// All of it in one line: "free body: coupler, T_y, t = 1.284 s: residual 3.1e-11, scale 2.4, 10.9 digits".
  [[nodiscard]] std::string text() const;
};

/// Keeps the finding that is farther below its need; one without a row counts for nothing.
void keep_worse(AuditFinding& kept, const AuditFinding& other);

/// What a row counts in; `own`: a row that is compared with nothing else, such as one of a modal coordinate.
enum class AuditUnit { force, torque, own, length, angle, speed, turning_speed, acceleration, turning_acceleration };
inline constexpr std::size_t kAuditUnits = 9;
/// Scales by unit.
using AuditScales = std::array<double, kAuditUnits>;

constexpr std::size_t index(AuditUnit unit) { return static_cast<std::size_t>(unit); }
constexpr AuditUnit unit_of_position(bool turns) { return turns ? AuditUnit::angle : AuditUnit::length; }
constexpr AuditUnit unit_of_speed(bool turns) { return turns ? AuditUnit::turning_speed : AuditUnit::speed; }
constexpr AuditUnit unit_of_acceleration(bool turns) {
  return turns ? AuditUnit::turning_acceleration : AuditUnit::acceleration;
}

/// One number that should vanish: its largest size and the peak of its scale.
struct AuditRow {
  AuditRule rule;
  std::string name;
  AuditUnit unit;
  double residual = 0.0;
  double scale = 0.0;
  double t = 0.0;

  void take(double new_residual, double new_scale, double at_t);
};

/// The rows of a body, a joint, a force element or a coupling.
struct AuditEntity {
  std::string name;
  std::vector<AuditRow> rows;
  /// A joint that can carry nothing has no scale of its own: it is compared with the machine's largest.
  bool is_idle = false;

  /// Residuals of all rows in their order, at a time, with the scales of each unit there.
  void take(const VecX& residuals, const AuditScales& scales, double at_t);
  /// The worst of a rule's rows, given the machine's largest scales, and the sizes of the terms that were summed
  /// somewhere in it, whose round-off is no breach.
  [[nodiscard]] AuditFinding worst(AuditRule rule, const AuditScales& largest, const AuditScales& terms) const;
  [[nodiscard]] int count(AuditRule rule) const;
  /// Raises the largest scales to those of the rows; `own` stays 0.
  void raise(AuditScales& largest) const;
};

}  // namespace concord::compare
