#include "tests/second_reading/folder.h"

#include <algorithm>
#include <optional>

#include "common/error.h"
#include "common/reading/model_file.h"
#include "tests/second_reading/second_reading.h"

namespace concord::second_reading {

namespace {

std::optional<Model> model_in(const std::filesystem::path& file) {
  try {
    return read_model(file);
  } catch (const InputError&) {
    return {};
  }
}

}  // namespace

FolderReading read_folder_again(const std::filesystem::path& folder) {
  FolderReading all;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".toml") continue;
    const std::optional<Model> model = model_in(entry.path());
    if (!model) continue;
    const SecondReading found = read_again(*model, entry.path());
    const std::string name = entry.path().filename().string();
    for (const StatedValue& value : found.differing) all.differing.push_back(name + ": " + describe(value, name));
    for (const std::string& one : found.not_held) all.not_held.push_back(name + ": " + one);
    all.least_held = all.models == 0 ? found.held : std::min(all.least_held, found.held);
    ++all.models;
  }
  return all;
}

}  // namespace concord::second_reading
