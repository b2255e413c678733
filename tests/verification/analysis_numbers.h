#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <optional>
#include <string>

#include "closed_forms.h"
#include "common/error.h"
#include "compare/analyses/judge.h"

/// Numbers of an analysis that both solvers have done.
namespace concord::verification {

/// That of the first solver, by the name of its row, which must be there.
inline double value_of(const compare::analyses::AnalysisVerdict& found, const std::string& name) {
  const auto row =
      std::find_if(found.numbers.begin(), found.numbers.end(), [&](const auto& r) { return r.name == name; });
  REQUIRE(row != found.numbers.end());
  return row->values[0];
}

/// What statics says of a rare machine, which must agree; nothing where it is refused with the coordinate that moves.
inline std::optional<compare::analyses::AnalysisVerdict> statics_unless_refused(const Model& model) {
  try {
    auto rest = compare::analyses::judge_statics(model, kMakers);
    CHECK(rest.wrenches.outcome == compare::Outcome::agree);
    return rest;
  } catch (const SolverError& error) {
    CHECK_THAT(error.what(), Catch::Contains("nothing resists") || Catch::Contains("still accelerates") ||
                                 Catch::Contains("the equilibrium is not determined"));
    CHECK_THAT(error.what(), Catch::Contains(" of ") || Catch::Contains("orientation"));
    return std::nullopt;
  }
}

}  // namespace concord::verification
