#pragma once

#include <array>
#include <functional>
#include <mutex>
#include <string_view>

#include "compare/quantities/align.h"

namespace concord::compare {

/// What a verification is doing: the rung, and the part of it that each solver has done, 0 to 1.
using TellProgress = std::function<void(std::string_view rung, const std::array<double, 2>& done)>;

/// Tells it from several threads, never at the same time.
class RungProgress {
 public:
  /// `tell`: may be empty; must outlive this.
  explicit RungProgress(const TellProgress& tell) : tell_(tell) {}

  void begin(std::string_view rung) {
    done_ = {};
    if (tell_) tell_(rung, done_);
  }

  void advance(std::string_view rung, Who who, double done) {
    if (!tell_) return;
    const std::lock_guard lock(guard_);
    done_[index(who)] = done;
    tell_(rung, done_);
  }

 private:
  const TellProgress& tell_;
  std::mutex guard_;
  std::array<double, 2> done_{};
};

}  // namespace concord::compare
