#pragma once

#include <string>
#include <vector>

#include "compare/program/command_line.h"

namespace concord::compare::nightly {

/// Takes the options for sbatch from the end of a command line, all that stands behind `--slurm`.
std::vector<std::string> take_slurm_words(int& argc, char** argv);

/// Adds the commands `nightly`, `accept`, `history` and `diff`; `slurm_words`: what was taken from the line.
void add_nights(CommandLine& line, const std::vector<std::string>& slurm_words);

}  // namespace concord::compare::nightly
