#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/model.h"
#include "compare/analyses/inverse.h"
#include "compare/analyses/linearize.h"
#include "compare/states/branch.h"
#include "compare/verdict/verdict.h"
#include "compare/verdict/verify.h"

/// Each analysis by both solvers, and how far they agree.
namespace concord::compare::analyses {

/// Digits that what each solver finds for itself must have in common, beside those of poses (own_need()).
inline constexpr double kEigenvalue = 8.0;
inline constexpr double kRoundTrip = 10.0;
/// Of the accelerations that are asked for, as differences read them from the bodies.
inline constexpr double kAsAsked = 9.0;

/// Values of a row that sums up many numbers.
inline constexpr std::array kNoValues{std::numeric_limits<double>::quiet_NaN(),
                                      std::numeric_limits<double>::quiet_NaN()};

/// A number that both solvers give, beside wrenches: a coordinate of an equilibrium, an eigenvalue, a driver force; or,
/// without values, what has many numbers, as the shape of a mode.
struct NumberRow {
  std::string name;
  std::string unit;
  std::array<double, 2> values{};
  double digits = 16.0;
  double need = 0.0;
  /// Digits that 20 resolutions leave, where the resolution was measured: as many are enough.
  std::optional<double> resolvable = {};
  /// What a change of the value from one night to another is held against, if not the largest number of its unit.
  std::optional<double> scale = {};

  [[nodiscard]] bool agrees() const { return digits >= need || (resolvable && digits >= *resolvable); }
};

/// What a driven coordinate needs, by both solvers: judged with its joint's wrench, here for the reader.
struct AppliedForceRow {
  std::string name;           // "slide_z of cart"
  double acceleration = 0.0;  // that was asked for
  std::string unit;           // of the force
  std::array<double, 2> tau{};
  double digits = 16.0;
};

/// What an analysis found, and how far the solvers agree on it.
struct AnalysisVerdict {
  std::string analysis;  // "statics", ...
  /// Wrenches, rank, audit, findings and failures; its check "same run" is what each solver found for itself, and there
  /// is no refined one.
  Verdict wrenches;
  /// The machine whose wrenches these are, where it is not the one that was asked about: inverse dynamics drives it,
  /// and an equilibrium holds the speeds that are kept.
  std::optional<Model> machine;
  std::vector<NumberRow> numbers;
  /// Of inverse dynamics.
  std::vector<AppliedForceRow> forces;
  /// What it found, in words and tables.
  std::string text;
  std::array<std::optional<Linearization>, 2> linearizations;
  double own_need = 0.0;
};

/// Both solvers' equilibria: wrenches, joint and modal coordinates. See find_equilibrium().
AnalysisVerdict judge_statics(const Model& model, const SolverMakers& makers);

/// Both solvers' eigenvalues and mode shapes about the start or the equilibrium. See linearize().
AnalysisVerdict judge_linearization(const Model& model, const SolverMakers& makers, bool at_equilibrium);

/// Both solvers' driven motion. See run_kinematics(). The trajectories stand in the verdict.
AnalysisVerdict judge_kinematics(const Model& model, const SolverMakers& makers, const VerifyOptions& options);

/// Both solvers' forces for the accelerations asked for, and the way back: with those forces in actuators, both must
/// accelerate as the driven machine did.
AnalysisVerdict judge_inverse(const Model& model, const SolverMakers& makers,
                              const std::vector<AskedAcceleration>& asked);

}  // namespace concord::compare::analyses
