#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

#include "compare/quantities/align.h"

namespace concord::compare {

/// What a verification is doing: the check, and the part of it that each solver has done, 0 to 1.
using TellProgress = std::function<void(std::string_view check, const std::array<double, 2>& done)>;

/// Tells it from several threads, never at the same time: of checks that are made beside the one that is waited for,
/// how far they are is told when these are waited for.
class CheckProgress {
 public:
  /// `tell`: may be empty; must outlive this.
  explicit CheckProgress(const TellProgress& tell) : tell_(tell) {}

  /// From now on this check is waited for; it begins anew.
  void begin(std::string_view check) {
    const std::lock_guard lock(guard_);
    done_[std::string(check)] = {};
    tell_now(check);
  }

  /// From now on this check is waited for, of which a part may be done.
  void wait_for(std::string_view check) {
    const std::lock_guard lock(guard_);
    tell_now(check);
  }

  /// Told again from hundredth to hundredth.
  void advance(std::string_view check, Who who, double done) {
    const std::lock_guard lock(guard_);
    double& known = done_[std::string(check)][index(who)];
    if (std::floor(100.0 * known) == std::floor(100.0 * done)) return;
    known = done;
    if (check == current_) tell_now(check);
  }

 private:
  void tell_now(std::string_view check) {
    current_ = check;
    if (tell_) tell_(check, done_[current_]);
  }

  const TellProgress& tell_;
  std::mutex guard_;
  std::string current_;
  std::map<std::string, std::array<double, 2>> done_;
};

}  // namespace concord::compare
