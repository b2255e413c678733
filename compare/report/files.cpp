#include "compare/report/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <mutex>
#include <set>
#include <stdexcept>

#include "common/error.h"

namespace concord::compare {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& path, const std::string& reason) {
  throw InputError({path.string(), 0, 0}, fmt::format("cannot be written: {}", reason));
}

std::string name_of(fs::file_type type) {
  switch (type) {
    case fs::file_type::directory:
      return "a folder";
    case fs::file_type::symlink:
      return "a symbolic link";
    case fs::file_type::fifo:
      return "a fifo";
    case fs::file_type::socket:
      return "a socket";
    default:
      return "a device";
  }
}

/// What is unfinished, by its temporary name. Who makes, moves or removes any of it holds the lock.
struct Unfinished {
  std::mutex lock;
  std::set<fs::path> paths;
  int made = 0;
};

Unfinished& unfinished() {
  static Unfinished all;
  return all;
}

/// A name beside `place` that no other program takes and that none has left there; the lock is held.
fs::path temporary_name(const fs::path& place) {
  fs::path path;
  std::error_code ignored;
  do {  // a program of the same number may have been killed
    path = place;
    path += fmt::format(".{}-{}.unfinished", getpid(), ++unfinished().made);
  } while (fs::exists(fs::symlink_status(path, ignored)));
  return path;
}

/// Makes a file in the folder and removes it: rights alone do not tell whether the place takes files.
void probe(const fs::path& wanted, const fs::path& folder) {
  const std::lock_guard guard(unfinished().lock);
  const fs::path path = temporary_name(folder / ".probe");
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file < 0) refuse(wanted, std::strerror(errno));
  ::close(file);
  ::unlink(path.c_str());
}

/// Refuses what a finished file must not replace.
void check_replaceable(const fs::path& path) {
  if (path.native().find('\0') != std::string::npos) refuse(path, "its name holds a NUL");
  if (!path.has_filename()) refuse(path, "it names a folder");
  std::error_code trouble;
  const fs::file_status status = fs::symlink_status(path, trouble);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    refuse(path, fmt::format("it is {}; only a regular file is replaced", name_of(status.type())));
  }
  if (!fs::exists(status) && status.type() != fs::file_type::not_found) refuse(path, trouble.message());
}

}  // namespace

WaitingLock::WaitingLock(const fs::path& place) : place_(::open(place.c_str(), O_RDONLY | O_CLOEXEC)) {
  // A file system without locks does without.
  while (place_ >= 0 && ::flock(place_, LOCK_EX) != 0 && errno == EINTR) {
  }
}

WaitingLock::~WaitingLock() {
  if (place_ >= 0) ::close(place_);
}

void check_target_folder(const fs::path& folder) {
  if (folder.native().find('\0') != std::string::npos) refuse(folder, "its name holds a NUL");
  fs::path there = folder;
  std::error_code trouble;
  while (true) {
    const fs::file_status status = fs::status(there.empty() ? fs::path(".") : there, trouble);
    if (fs::is_directory(status)) break;
    if (fs::exists(status)) refuse(folder, fmt::format("'{}' is no folder", there.string()));
    if (fs::is_symlink(fs::symlink_status(there, trouble))) {
      refuse(folder, fmt::format("'{}' is a symbolic link to nothing", there.string()));
    }
    if (status.type() != fs::file_type::not_found) refuse(folder, trouble.message());
    there = there.has_filename() ? there.parent_path() : there.parent_path().parent_path();
  }
  probe(folder, there.empty() ? fs::path(".") : there);
}

void check_target(const fs::path& path) {
  check_replaceable(path);
  check_target_folder(path.has_parent_path() ? path.parent_path() : fs::path("."));
}

std::filesystem::path scratch_place() {
  std::error_code trouble;
  std::filesystem::path place = std::filesystem::temp_directory_path(trouble);
  if (!trouble) return place;
  throw InputError({"TMPDIR", 0, 0}, "temporary files go to a folder that is none: see TMPDIR, TMP, TEMP and TEMPDIR");
}

void make_folder(const fs::path& folder) {
  if (folder.empty()) return;
  std::error_code trouble;
  fs::create_directories(folder, trouble);
  if (trouble) refuse(folder, trouble.message());
  if (!fs::is_directory(folder, trouble)) refuse(folder, "it is not a folder");
}

UnfinishedFile::UnfinishedFile(fs::path place) : place_(std::move(place)) {
  check_replaceable(place_);
  make_folder(place_.parent_path());
  const std::lock_guard guard(unfinished().lock);
  path_ = temporary_name(place_);
  const int file = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file < 0) refuse(place_, std::strerror(errno));
  ::close(file);
  unfinished().paths.insert(path_);
}

UnfinishedFile::~UnfinishedFile() {
  const std::lock_guard guard(unfinished().lock);
  if (unfinished().paths.erase(path_) == 0) return;  // finished
  std::error_code ignored;
  fs::remove(path_, ignored);
}

void UnfinishedFile::finish() {
  check_replaceable(place_);
  const std::lock_guard guard(unfinished().lock);
  std::error_code trouble;
  fs::rename(path_, place_, trouble);
  if (trouble) refuse(place_, trouble.message());
  unfinished().paths.erase(path_);
}

StagedFolder::StagedFolder(fs::path place) : place_(std::move(place)) {
  check_target_folder(place_);
  make_folder(place_);
  const std::lock_guard guard(unfinished().lock);
  path_ = temporary_name(place_ / ".results");
  std::error_code trouble;
  if (!fs::create_directory(path_, trouble)) refuse(place_, trouble ? trouble.message() : "a name is taken");
  unfinished().paths.insert(path_);
}

StagedFolder::~StagedFolder() {
  const std::lock_guard guard(unfinished().lock);
  unfinished().paths.erase(path_);
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

void StagedFolder::finish(const std::vector<std::string>& stale) {
  std::error_code trouble;
  std::vector<fs::path> names;
  for (const auto& entry : fs::directory_iterator(path_, trouble)) names.push_back(entry.path().filename());
  if (trouble) refuse(place_, trouble.message());
  std::sort(names.begin(), names.end());
  for (const fs::path& name : names) check_replaceable(place_ / name);
  const WaitingLock folder_lock(place_);
  const std::lock_guard guard(unfinished().lock);
  for (const std::string& name : stale) {
    fs::remove(place_ / name, trouble);
    if (trouble) refuse(place_ / name, trouble.message());
  }
  for (const fs::path& name : names) {
    fs::rename(path_ / name, place_ / name, trouble);
    if (trouble) refuse(place_ / name, trouble.message());
  }
}

void write_file(const fs::path& path, std::string_view text) {
  UnfinishedFile unfinished_file(path);
  {
    std::ofstream file(unfinished_file.path(), std::ios::binary);
    file << text;
    file.close();
    if (!file) throw std::runtime_error(fmt::format("{}: cannot be written: {}", path.string(), std::strerror(errno)));
  }
  unfinished_file.finish();
}

std::uint64_t hash_of(std::string_view text, std::uint64_t before) {
  for (const char letter : text) before = (before ^ static_cast<unsigned char>(letter)) * 1099511628211U;
  return before;
}

std::uint64_t hash_of_file(const fs::path& file) {
  std::error_code unknown;
  if (!fs::is_regular_file(file, unknown)) return 0;
  std::ifstream stream(file, std::ios::binary);
  std::uint64_t hash = hash_of("");
  std::array<char, 65536> chunk{};
  while (stream.read(chunk.data(), chunk.size()) || stream.gcount() > 0) {
    hash = hash_of({chunk.data(), static_cast<std::size_t>(stream.gcount())}, hash);
  }
  return hash;
}

void abandon_unfinished_files() {
  unfinished().lock.lock();  // for good
  for (const fs::path& path : unfinished().paths) {
    std::error_code trouble;
    int attempts = 0;
    do {  // a thread may just be making one more file in a folder
      fs::remove_all(path, trouble);
    } while (trouble && ++attempts < 100);
  }
}

}  // namespace concord::compare
