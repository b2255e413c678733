#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "common/model.h"
#include "common/results.h"
#include "compare/quantities/reference_file.h"
#include "compare/verdict/verdict.h"

/// What a column of a reference would fit that misses both solvers.
namespace concord::compare {

/// Both solvers' runs at the times of a reference.
struct RunsAtTimes {
  const Verdict& verdict;
  std::vector<std::size_t> samples;
  std::array<std::vector<const Sample*>, 2> at;  // of each solver

  [[nodiscard]] const Sample& sample(std::size_t who, std::size_t k) const { return *at[who][k]; }
};

/// What else of the same owner the numbers of a column that misses by more than `allowed` would fit: "it has the
/// other sign", on the other side, in other axes, or a multiple. Empty if nothing; of numbers that are all about zero,
/// which would fit much, a factor alone.
std::string what_would_fit(const Model& model, const RunsAtTimes& runs, const Reference& reference,
                           const ReferenceColumn& column, double allowed);

}  // namespace concord::compare
