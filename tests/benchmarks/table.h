#pragma once

#include <filesystem>
#include <iosfwd>

namespace concord::benchmarks {

/// What both solvers take for evaluations and whole runs, and Simbody where this program has it: medians, and medians
/// of ratios, of processor times that are taken in turns. Tells on `progress` what is being measured. `data`: the
/// folder of the models. Whether all reactions agree to 11 digits.
bool print_table(const std::filesystem::path& data, std::ostream& out, std::ostream& progress);

}  // namespace concord::benchmarks
