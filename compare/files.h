#pragma once

#include <filesystem>
#include <string>

namespace concord::compare {

/// Writes `text` under a temporary name beside `path`, then renames it: readers see all of it or nothing. Creates the
/// folder. Throws InputError if the place cannot be written.
void write_file(const std::filesystem::path& path, const std::string& text);

/// Creates the folder and what leads to it. Throws InputError if that is not possible.
void make_folder(const std::filesystem::path& folder);

}  // namespace concord::compare
