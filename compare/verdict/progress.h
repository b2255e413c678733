#pragma once

#include <array>
#include <functional>
#include <mutex>
#include <string_view>

#include "compare/quantities/align.h"

namespace concord::compare {

/// What a verification is doing: the check, and the part of it that each solver has done, 0 to 1.
using TellProgress = std::function<void(std::string_view check, const std::array<double, 2>& done)>;

/// Tells it from several threads, never at the same time.
class CheckProgress {
 public:
  /// `tell`: may be empty; must outlive this.
  explicit CheckProgress(const TellProgress& tell) : tell_(tell) {}

  void begin(std::string_view check) {
    done_ = {};
    if (tell_) tell_(check, done_);
  }

  void advance(std::string_view check, Who who, double done) {
    if (!tell_) return;
    const std::lock_guard lock(guard_);
    done_[index(who)] = done;
    tell_(check, done_);
  }

 private:
  const TellProgress& tell_;
  std::mutex guard_;
  std::array<double, 2> done_{};
};

}  // namespace concord::compare
