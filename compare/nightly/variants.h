#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compare/nightly/case.h"

/// One table of a suite makes many cases: every model, every combination of what it sweeps.
namespace concord::compare::nightly {

struct StartDraws {
  StartDraw first;  // seed and sizes
  int count = 0;
};

struct Sweep {
  std::vector<std::pair<std::string, std::vector<double>>> parameters;
  std::vector<std::pair<std::string, std::vector<std::string>>> cuts;  // by name
  std::vector<std::array<std::string, 2>> integrators;
  std::vector<double> rtol;
  std::optional<StartDraws> start;

  /// How many cases it makes of one.
  [[nodiscard]] double combinations() const;
};

/// All combinations, each named after `base.id`: "car/speed=20,cut=front,rtol=1e-09".
std::vector<Case> variants_of(const Case& base, const Sweep& sweep);

}  // namespace concord::compare::nightly
