#pragma once

#include <string>
#include <vector>

#include "common/joints/facts.h"
#include "common/joints/vocabulary.h"

namespace concord::joints {

/// A number that each joint of a type states for itself, such as the length of a rod.
struct Parameter {
  std::string name;
  std::string unit;
  double example;  // what the type in the catalogue has: the joint check uses it; positive, and so are all values
};

/// A joint type, said three times, none computed from another: see vocabulary.h for the words. Its reaction does no
/// work along what it permits (S24).
struct JointType {
  std::string name;
  std::vector<Forbid> forbids;
  std::vector<Permit> permits;
  std::vector<Read> reads;
  /// Numbers that a joint of this type must give, and the type that has them (in this order). The catalogue holds the
  /// type with the examples.
  std::vector<Parameter> parameters = {};
  JointType (*with_parameters)(const std::vector<double>& values) = nullptr;

  /// What the type forbids, and then permits, of the velocity alone; empty for most types. With them the motion's q
  /// reaches more places than its speeds have directions.
  std::vector<ForbidSpeed> forbids_speeds = {};
  std::vector<PermitSpeed> permits_speeds = {};

  /// Number of constraint rows of `forbids`, which hold for positions and velocities.
  [[nodiscard]] int rows() const;
  /// Number of constraint rows of `forbids_speeds`, which hold for velocities alone.
  [[nodiscard]] int nonholonomic_rows() const;
  /// Number of joint coordinates q and of joint speeds u of `permits`.
  [[nodiscard]] int n_q() const;
  [[nodiscard]] int n_u() const;
};

}  // namespace concord::joints
