#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compare/report/console.h"
#include "compare/verdict/refinement.h"
#include "compare/verdict/verify.h"

namespace concord::compare {

/// One line on a terminal that shows how far a run is; wiped when it goes.
class ProgressLine {
 public:
  explicit ProgressLine(const Console& console) : console_(console) {}
  ~ProgressLine() {
    if (!shown_.empty()) console_.err << "\r\033[K" << std::flush;
  }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void show(const std::string& text) {
    if (!console_.progress || text == shown_) return;
    shown_ = text;
    console_.err << "\r\033[K" << text << std::flush;
  }

 private:
  const Console& console_;
  std::string shown_;
};

inline int percent(double done) { return static_cast<int>(100.0 * std::clamp(done, 0.0, 1.0)); }

/// Which check of how many a comparison is at, how far, and how long it may take at the pace so far.
class ComparisonProgress {
 public:
  ComparisonProgress(const Console& console, std::string model, const VerifyOptions& options)
      : line_(console), model_(std::move(model)) {
    stages_ = {name_of(Check::same_state)};
    if (!options.integrates) return;
    stages_.insert(stages_.end(), {name_of(Check::same_run), "audit"});
    if (options.refines) stages_.emplace_back(name_of(Check::refined));
  }

  void show(std::string_view check, const std::array<double, 2>& done) {
    const Instant now = std::chrono::steady_clock::now();
    const double least = std::min(done[0], done[1]);
    if (check != check_) {
      check_ = check;
      since_ = now;
      at_first_ = least;
    }
    const auto place = std::find(stages_.begin(), stages_.end(), check);
    const auto at = static_cast<std::size_t>(place - stages_.begin());
    const std::string count = at < stages_.size() ? fmt::format("{} of {}, ", at + 1, stages_.size()) : "";
    const double so_far = std::chrono::duration<double>(now - since_).count();
    const bool is_known = so_far > 2.0 && least > at_first_ + 0.02 && least < 1.0;
    line_.show(fmt::format(
        "{}: {}{}, cartesian {} %, relative {} %{}", model_, count, check, percent(done[0]), percent(done[1]),
        is_known ? fmt::format(", {:.0f} s left of it", so_far * (1.0 - least) / (least - at_first_)) : ""));
  }

 private:
  using Instant = std::chrono::steady_clock::time_point;
  ProgressLine line_;
  std::string model_;
  std::vector<std::string> stages_;
  std::string check_;
  Instant since_;
  double at_first_ = 0.0;  // done when it was first shown: a check may be made beside others before
};

}  // namespace concord::compare
