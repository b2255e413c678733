#pragma once

#include <string>

#include "common/laws/time_function.h"
#include "compare/random_machines/machine.h"
#include "compare/random_machines/random.h"

/// Laws of time and of force, drawn and written.
namespace concord::compare::fuzz {

/// Units of a machine, by which everything in it is scaled.
struct Units {
  double length = 1.0;  // m
  double mass = 1.0;    // kg
  double time = 1.0;    // s
  /// How often a spring is as stiff, and a damper as strong, as lets motion go on at the pace of the unit of time.
  double stiffer = 1.0;
  double damped = 1.0;

  [[nodiscard]] double force() const { return mass * length / (time * time); }
};

/// A law of time and the table that states it.
struct LawPlan {
  TimeFunction law;
  Entries entries;
};

/// A law that is `start` at t = 0, or near it, and moves by about `reach` in the unit of time.
LawPlan draw_law(double start, double reach, double time, Random& random);

/// A law with a level: what loads and actuators follow.
LawPlan draw_load_law(double size, double time, Random& random);

std::string inline_text(const Entries& entries);

/// A force law of a coordinate or a length that is x at the start and moves by `reach`, with forces of the size
/// `force`; `units` give its time, and how stiff and damped it is. `is_line`: its free length is positive.
Entries draw_force_law(double x, double reach, double force, const Units& units, bool is_line, Random& random);

}  // namespace concord::compare::fuzz
