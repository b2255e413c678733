#include "compare/nightly/night.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <ctime>
#include <limits>
#include <ostream>
#include <thread>

#include "compare/nightly/record.h"
#include "compare/nightly/trial.h"
#include "compare/report/files.h"
#include "compare/report/interrupt.h"
#include "compare/workers/pool.h"

namespace concord::compare::nightly {

namespace {

using Instant = std::chrono::steady_clock::time_point;

double seconds_from(Instant then) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - then).count();
}

/// What the user sees of a night while it runs.
class NightProgress {
 public:
  NightProgress(const Console& console, std::size_t cases, int jobs, std::map<std::string, double> expected)
      : console_(console), cases_(cases), jobs_(jobs), expected_(std::move(expected)) {}

  void start(const std::string& id) {
    running_.push_back(id);
    show(false);
  }

  void end(const Result& result) {
    running_.erase(std::find(running_.begin(), running_.end(), result.id));
    ++done_;
    seconds_ += result.wall_s;
    if (!result.is_green()) {
      ++red_;
      wipe();
      console_.err << fmt::format("{}: {}: {}\n", result.id, to_string(result.ending),
                                  result.words.substr(0, result.words.find('\n')));
    }
    show(done_ == cases_);
  }

  /// Time of the cases that are still to come, by what they took last time, else by the mean so far.
  [[nodiscard]] double seconds_left(const std::vector<const Case*>& to_come) const {
    const double mean = done_ == 0 ? 0.0 : seconds_ / static_cast<double>(done_);
    double left = 0.0;
    for (const Case* one : to_come) left += expected_seconds(one->id, mean);
    for (const std::string& id : running_) left += 0.5 * expected_seconds(id, mean);
    return left / jobs_;
  }

  void show(bool now) {
    const double since = shown_ ? seconds_from(*shown_) : 1e9;
    if (!now && since < (console_.progress ? 0.1 : 30.0)) return;
    shown_ = std::chrono::steady_clock::now();
    std::string text = fmt::format("{} of {} done, {} red", done_, cases_, red_);
    if (left_ && done_ > 0 && done_ < cases_) text += fmt::format(", {:.0f} s left", left_());
    if (!running_.empty()) text += ", running: " + running_words();
    console_.err << (console_.progress ? "\r\033[K" + text : text + "\n") << std::flush;
  }

  void wipe() {
    if (console_.progress) console_.err << "\r\033[K" << std::flush;
  }

  void set_left(std::function<double()> left) { left_ = std::move(left); }

 private:
  [[nodiscard]] double expected_seconds(const std::string& id, double otherwise) const {
    const auto known = expected_.find(id);
    return known == expected_.end() ? otherwise : known->second;
  }

  [[nodiscard]] std::string running_words() const {
    constexpr std::size_t kTold = 3;
    std::string text;
    for (std::size_t k = 0; k < std::min(kTold, running_.size()); ++k) text += (k > 0 ? ", " : "") + running_[k];
    return running_.size() > kTold ? text + ", ..." : text;
  }

  const Console& console_;
  std::size_t cases_;
  int jobs_;
  std::map<std::string, double> expected_;
  std::vector<std::string> running_;
  std::size_t done_ = 0;
  int red_ = 0;
  double seconds_ = 0.0;
  std::optional<Instant> shown_;
  std::function<double()> left_;
};

}  // namespace

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  return fmt::format("{:04}-{:02}-{:02} {:02}:{:02}:{:02}", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday,
                     parts.tm_hour, parts.tm_min, parts.tm_sec);
}

std::string page_name_of(const std::string& id) {
  std::string name = id;
  for (char& letter : name) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(letter)) != 0 || letter == '.' || letter == '-';
    if (!is_plain) letter = '_';
  }
  return fmt::format("case_{}_{:016x}.html", name.substr(0, 100), hash_of(id));
}

void put_longest_first(const std::map<std::string, double>& wall_times, std::vector<const Case*>& cases) {
  const auto expected = [&](const Case* one) {
    const auto known = wall_times.find(one->id);
    return known == wall_times.end() ? std::numeric_limits<double>::infinity() : known->second;
  };
  std::stable_sort(cases.begin(), cases.end(), [&](const Case* a, const Case* b) { return expected(a) > expected(b); });
}

Result not_run(const Case& one, const std::string& why) {
  Result result;
  result.id = one.id;
  result.work = name_of(one.work);
  result.words = why;
  return result;
}

bool run_cases(std::vector<const Case*> cases, const NightOptions& options, const StoreResult& store,
               const std::map<std::string, double>& wall_times, const SolverMakers& makers, const Console& console) {
  const StagedFolder scratch(scratch_place());
  const int jobs =
      options.jobs > 0 ? options.jobs : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  if (!options.minutes) put_longest_first(wall_times, cases);
  NightProgress progress(console, cases.size(), jobs, wall_times);
  std::size_t given = 0;
  progress.set_left([&] {
    return progress.seconds_left({cases.begin() + static_cast<std::ptrdiff_t>(given), cases.end()});
  });
  const Instant start = std::chrono::steady_clock::now();
  const auto next = [&]() -> std::optional<workers::Assignment> {
    const bool is_late = options.minutes && seconds_from(start) > 60.0 * *options.minutes;
    if (given == cases.size() || is_late) return std::nullopt;
    return workers::Assignment{std::to_string(given), cases[given]->limits};
  };
  std::vector<Instant> begun(cases.size());
  std::vector<std::string> asked(cases.size());  // a file that is edited meanwhile belongs to the next night
  bool is_complete = true;
  workers::Watch watch;
  watch.started = [&](std::size_t k) {
    ++given;
    begun[k] = std::chrono::steady_clock::now();
    asked[k] = definition_of(*cases[k]);
    progress.start(cases[k]->id);
  };
  watch.ended = [&](std::size_t k, const workers::Report& report) {
    Result result = result_of(cases[k]->id, name_of(cases[k]->work), report);
    is_complete = is_complete && result.ending != Ending::not_run;
    result.wall_s = seconds_from(begun[k]);
    result.definition = asked[k].empty() ? definition_of(*cases[k]) : asked[k];
    store(result);
    note_finished(result.id);
    progress.end(result);
  };
  watch.waited = [&] { progress.show(false); };
  const workers::Task task = [&](const std::string& input) {
    const Case& one = *cases[std::stoul(input)];
    const auto folder = scratch.path() / std::to_string(getpid());
    return dumped(try_case(one, folder, makers,
                           options.pages.empty() ? std::filesystem::path() : options.pages / page_name_of(one.id)));
  };
  workers::Pool(task, jobs, {}).run_apart(next, watch);
  progress.wipe();
  for (std::size_t k = given; k < cases.size(); ++k) store(not_run(*cases[k], kTimeIsUp));
  return is_complete && given == cases.size();
}

}  // namespace concord::compare::nightly
