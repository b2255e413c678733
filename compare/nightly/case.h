#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/model.h"
#include "compare/analyses/inverse.h"
#include "compare/verdict/verify.h"
#include "compare/workers/pool.h"

namespace concord::compare::nightly {

enum class Work { compare, statics, linearize, kinematics, inverse, joint, fuzz, invariance };

/// "compare", "statics", ..., in the order of the enumeration.
const std::vector<std::string>& work_names();
const std::string& name_of(Work work);

/// A case that is red for a reason that is known, until a day.
struct KnownRed {
  std::string reason;
  std::string until;  // "2026-12-31": the last day on which it counts
};

/// The kept coordinates and speeds of the model's start, each moved by U[-1, 1] times one of these sizes.
struct StartDraw {
  std::uint64_t seed = 1;
  std::uint64_t number = 0;
  double turn = 0.0;         // rad
  double slide = 0.0;        // m
  double turn_speed = 0.0;   // rad/s
  double slide_speed = 0.0;  // m/s
};

struct FuzzShare {
  std::uint64_t seed = 1;
  std::uint64_t first = 0;
  std::uint64_t count = 100;
  std::string style = "mixed";
};

/// One thing that a night does: one variant of one model, one joint type, or one share of random machines.
struct Case {
  std::string id;        // unique in the suite: "car", "statics/car", "car/speed=20,cut=front"
  SourceLocation where;  // of its [[case]] in the suite: what its model cannot give is refused there
  Work work = Work::compare;
  std::filesystem::path model;

  VerifyOptions options;
  std::vector<std::pair<std::string, double>> parameters;  // instead of the model's own
  std::optional<std::vector<std::string>> cut;             // exactly these joints are named as cut
  std::optional<StartDraw> start;
  std::vector<NeedOverride> needs;  // after those of the model
  bool at_equilibrium = false;
  std::vector<analyses::AskedAcceleration> accelerations;

  std::string joint;
  int poses = 20;
  FuzzShare fuzz;

  workers::Limits limits;
  std::optional<KnownRed> known_red;
};

/// All that decides what the case does, as one line: two cases of one definition have the same result by the same
/// program. The contents of the model's files stand in it: of the model, of what it includes, of its modes.
std::string definition_of(const Case& one);

}  // namespace concord::compare::nightly
