#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "compare/random_machines/generator.h"
#include "compare/report/console.h"
#include "compare/states/branch.h"
#include "compare/verdict/verify.h"

namespace concord::compare::fuzz {

struct FuzzCommand {
  std::optional<std::uint64_t> count = {};  // machines; default: 1000, or as many as the minutes allow
  std::optional<double> minutes = {};       // stop after so long
  std::uint64_t seed = 1;
  std::uint64_t first = 0;          // number of the first machine
  int jobs = 0;                     // worker processes; 0: one for each processor
  std::filesystem::path keep = {};  // folder for failing machines, reduced; empty: none
  std::string style = "mixed";
  bool print = false;     // print the machine `first`, or keep it, instead of trying any
  double seconds = 60.0;  // limits of one machine
  double megabytes = 1024.0;
};

/// Compares random machines, each in a worker process, and reports their outcomes: on `out` every machine that ended
/// wrongly, the outcomes, the coverage; on `err` progress and speed. Returns 0 if none ended wrongly, 1 if solvers
/// differ or stop without a known reason, 3 if one crashes, hangs or exceeds its memory, 2 for a style that is not
/// known. What is written to `out` depends on seed, style, `first` and count alone.
int fuzz_machines(const FuzzCommand& command, const SolverMakers& makers, const Console& console);

}  // namespace concord::compare::fuzz
