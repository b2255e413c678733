#pragma once

#include <string>

/// Who runs a night, and whether he still does.
namespace concord::compare::nightly {

/// Names this process so that no other one is meant: the start of the system, the number of the process
/// and its start.
std::string this_process();
/// Whether that process still runs on this system, or a cluster's jobs do. Throws slurm::SlurmError if Slurm does not
/// tell.
bool is_running(const std::string& process);

}  // namespace concord::compare::nightly
