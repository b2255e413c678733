#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "compare/nightly/case.h"

namespace concord::compare::nightly {

/// By how much a case may fall behind its past before that counts as worse. Wall time is never judged.
struct Allowance {
  double margin = 1.0;  // digits of agreement
  double cost = 0.15;   // share of evaluations and steps
  double peak = 1e-4;   // of a peak value, relative to its scale
};

/// What is compared with the past, and what counts as worse.
struct Judging {
  Allowance allowance;
  std::map<std::string, Allowance> of_case;  // cases with an allowance of their own, by id
  int nights = 7;                            // whose median is taken
  bool against_baseline = true;
  bool against_median = false;

  [[nodiscard]] const Allowance& allowance_of(const std::string& id) const;
};

/// A suite file, with a name of its own for each model and variant.
struct Suite {
  std::filesystem::path file;
  std::string name;
  std::filesystem::path baselines;
  Judging judging;
  std::vector<Case> cases;  // sorted by id
};

/// Reads a suite (compare/nightly/README.md). Throws InputError with every complaint, each at its line and column: keys
/// that are not known, models that are not there, parameters that a model does not have, two cases of one name.
Suite read_suite(const std::filesystem::path& file);

/// Whether a case is meant: by `*`, `?` and `[...]` as in the shell if the pattern has any, else by a part of its name.
bool is_meant(std::string_view id, const std::string& pattern);

}  // namespace concord::compare::nightly
