#include "compare/files.h"

#include <fmt/format.h>

#include <fstream>

#include "common/error.h"

namespace concord::compare {

namespace {

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& reason) {
  throw InputError({path.string(), 0, 0}, fmt::format("cannot be written: {}", reason));
}

}  // namespace

void make_folder(const std::filesystem::path& folder) {
  if (folder.empty()) return;
  std::error_code trouble;
  std::filesystem::create_directories(folder, trouble);
  if (trouble) refuse(folder, trouble.message());
  if (!std::filesystem::is_directory(folder)) refuse(folder, "it is not a folder");
}

void write_file(const std::filesystem::path& path, const std::string& text) {
  make_folder(path.parent_path());
  std::filesystem::path unfinished = path;
  unfinished += ".unfinished";
  std::error_code trouble;
  {
    std::ofstream file(unfinished, std::ios::binary);
    file << text;
    file.close();
    if (!file) {
      std::filesystem::remove(unfinished, trouble);
      refuse(path, "the folder or the disk refuses");
    }
  }
  std::filesystem::rename(unfinished, path, trouble);
  if (!trouble) return;
  const std::string reason = trouble.message();
  std::filesystem::remove(unfinished, trouble);
  refuse(path, reason);
}

}  // namespace concord::compare
