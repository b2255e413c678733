#pragma once

#include <filesystem>
#include <iosfwd>

namespace concord::benchmarks {

/// Does every job that is counted once, in one thread, so that callgrind dumps one profile for each, and prints
/// "JOB,EVALUATIONS". Without callgrind it only prints. `data`: the folder of the models.
void do_jobs(const std::filesystem::path& data, std::ostream& out);

}  // namespace concord::benchmarks
