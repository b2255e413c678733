#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace concord::second_reading {

/// What a second reading tells of the model files in a folder and below.
struct FolderReading {
  int models = 0;
  int least_held = 0;                  // numbers and words, of the model of which least was held
  std::vector<std::string> differing;  // "car.toml: body hub, mass: was not read as ..."
  std::vector<std::string> not_held;
};

/// Reads every file that `read_model` accepts, once by it and once more; others are modes files, suites or parts.
FolderReading read_folder_again(const std::filesystem::path& folder);

}  // namespace concord::second_reading
