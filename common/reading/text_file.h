#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace concord {

/// A file that is read must be no longer than this.
inline constexpr std::uintmax_t kMostBytes = std::uintmax_t{64} << 20U;

/// Everything in a regular file; throws InputError if it cannot be read, is too long, or is a folder, a fifo or a
/// device, from which reading might never end: those are not waited for.
std::string read_text_file(const std::filesystem::path& file);

}  // namespace concord
