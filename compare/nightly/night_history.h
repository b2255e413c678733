#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "compare/nightly/history.h"

namespace concord::compare::nightly {

/// The history of a night that goes on when its file can be written no more (a full disk, a lock that does not end):
/// in a copy that lasts as long as the night. The file keeps what was stored in it, so that the night can be resumed.
class NightHistory {
 public:
  /// As History(file). `spare`: where the copy would be made.
  NightHistory(const std::filesystem::path& file, std::filesystem::path spare);

  /// The history with all that was stored; its address changes when the copy takes its place.
  [[nodiscard]] History& get() { return *history_; }

  /// As History::store(). Throws what the file's own DatabaseError was if the copy cannot be made or written either.
  void store(long night, const Result& result);
  /// As History::finish(), of a night whose file has all of it.
  void finish(long night, const std::string& now);

  /// Why the file lacks cases, and what to do; empty if it has them all.
  [[nodiscard]] std::string trouble() const;

 private:
  void go_on_in_copy();

  std::unique_ptr<History> history_;
  std::filesystem::path spare_;
  std::optional<DatabaseError> trouble_;
  bool is_copy_ = false;
};

}  // namespace concord::compare::nightly
