#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

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

}  // namespace concord::verification
