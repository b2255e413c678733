#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// Files that are there in full or not at all. What is not finished yet stands under a unique name that ends in
/// ".unfinished" beside its place, so that two programs may write the same results, and is removed when the program is
/// interrupted.
namespace concord::compare {

/// Throws InputError unless a file can be written at `path`: what is there already must be a regular file, and no
/// symbolic link, device, fifo or folder, for it will be replaced; the folder must be there or be possible. Creates
/// nothing.
void check_target(const std::filesystem::path& path);

/// Throws InputError unless `folder` is a folder in which files can be made, or can be made itself. Creates nothing.
void check_target_folder(const std::filesystem::path& folder);

/// Writes all of `text` or nothing. Creates the folder. Throws InputError if the path cannot be written,
/// std::runtime_error if the disk is full.
void write_file(const std::filesystem::path& path, std::string_view text);

/// FNV-1a of a text; `before`: that of what stands before it.
std::uint64_t hash_of(std::string_view text, std::uint64_t before = 14695981039346656037U);

/// FNV-1a of what a file holds: says whether it is still the same. 0 of what is no regular file.
std::uint64_t hash_of_file(const std::filesystem::path& file);

/// Where temporary files go: TMPDIR, TMP, TEMP or TEMPDIR, else /tmp. Throws InputError if it is no folder.
std::filesystem::path scratch_place();

/// Creates the folder and what leads to it. Throws InputError if that is not possible.
void make_folder(const std::filesystem::path& folder);

/// A file under a temporary name until it is finished.
class UnfinishedFile {
 public:
  /// Creates the folder and an empty file. Throws InputError if the path cannot be written.
  explicit UnfinishedFile(std::filesystem::path place);
  /// Removes the file unless it is finished.
  ~UnfinishedFile();
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

  /// Where to write until then.
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  /// Replaces what stands at its place. Throws InputError if that is not possible.
  void finish();

 private:
  std::filesystem::path place_;
  std::filesystem::path path_;
};

/// Several files of one folder that replace those of an earlier run together: no reader, no other program that does the
/// same and no interruption sees some of the new and some of the old.
class StagedFolder {
 public:
  /// Creates the folder and an empty one within it. Throws InputError if the path cannot be written.
  explicit StagedFolder(std::filesystem::path place);
  /// Removes what is not finished.
  ~StagedFolder();
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;

  /// Where to write until then.
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  /// Removes the `stale` files and moves all new ones to their place. Throws InputError if that is not possible.
  void finish(const std::vector<std::string>& stale);

 private:
  std::filesystem::path place_;
  std::filesystem::path path_;
};

/// Keeps other programs that lock the same file or folder, which is there, waiting as long as it lives.
class WaitingLock {
 public:
  explicit WaitingLock(const std::filesystem::path& place);
  ~WaitingLock();
  WaitingLock(const WaitingLock&) = delete;
  WaitingLock& operator=(const WaitingLock&) = delete;

 private:
  int place_;
};

/// Removes all that is unfinished and keeps other threads from making more: for a program that ends at once.
void abandon_unfinished_files();

}  // namespace concord::compare
