#include "compare/report/file_hash.h"

#include <array>
#include <fstream>
#include <system_error>

namespace concord::compare {

std::uint64_t hash_of_file(const std::filesystem::path& file) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(file, unknown)) return 0;
  std::ifstream stream(file, std::ios::binary);
  std::uint64_t hash = 14695981039346656037U;
  std::array<char, 65536> chunk{};
  while (stream.read(chunk.data(), chunk.size()) || stream.gcount() > 0) {
    for (std::streamsize k = 0; k < stream.gcount(); ++k) {
      hash = (hash ^ static_cast<unsigned char>(chunk.at(static_cast<std::size_t>(k)))) * 1099511628211U;
    }
  }
  return hash;
}

}  // namespace concord::compare
