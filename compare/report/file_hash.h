#pragma once

#include <cstdint>
#include <filesystem>

namespace concord::compare {

/// FNV-1a of what a file holds: says whether it is still the same. 0 of what is no regular file.
std::uint64_t hash_of_file(const std::filesystem::path& file);

}  // namespace concord::compare
