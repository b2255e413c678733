#include "compare/fuzz/command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <numeric>
#include <ostream>
#include <thread>

#include "common/reading/spelling.h"
#include "compare/fuzz/shrink.h"
#include "compare/random_machines/coverage.h"
#include "compare/random_machines/outcome.h"
#include "compare/random_machines/trial.h"
#include "compare/report/console.h"
#include "compare/report/files.h"
#include "compare/report/interrupt.h"
#include "compare/report/text_table.h"
#include "compare/workers/pool.h"

namespace concord::compare::fuzz {

namespace {

using Clock = std::chrono::steady_clock;

/// One machine of so many is compared at the tighter tolerance too: that costs as much as the rest of a comparison.
constexpr std::uint64_t kRefinedOnceIn = 4;

double seconds_since(Clock::time_point then) { return std::chrono::duration<double>(Clock::now() - then).count(); }

Style style_of(const std::string& name) {
  const auto& names = style_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<Style>(found - names.begin());
  throw InputError({"command line", 0, 0}, fmt::format("no style '{}': {}", name, suggestion(name, names, "styles")));
}

/// Writes a machine's model under a header, and its modes files beside it.
void write_model(const std::filesystem::path& file, const ModelText& text, const std::string& header = "") {
  for (const auto& [name, content] : text.beside) write_file(file.parent_path() / name, content);
  write_file(file, header + text.model);
}

/// A machine that ended wrongly.
struct Casualty {
  std::uint64_t number = 0;
  Outcome outcome;
};

/// How often an outcome was met, and by which machine first.
struct Met {
  long count = 0;
  std::uint64_t first = 0;
};

struct Slowest {
  std::uint64_t number = 0;
  double seconds = 0.0;
};

class Fuzz {
 public:
  Fuzz(const FuzzCommand& command, const SolverMakers& makers, const Console& console)
      : command_(command),
        console_(console),
        style_(style_of(command.style)),
        count_(command.count.value_or(command.minutes ? ~std::uint64_t{0} : 1000)),
        jobs_(command.jobs > 0 ? command.jobs : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()))),
        scratch_(scratch_place()),
        pool_([this, &makers](const std::string& input) { return work(input, makers); }, jobs_,
              {command.seconds, command.megabytes}) {}

  int run() {
    try_all(Clock::now());
    wipe_line();
    if (!command_.keep.empty()) keep_all();
    console_.out << format_outcomes() << '\n' << coverage_.format();
    doubt_refusals();
    tell_speed();
    return code_;
  }

 private:
  /// In a worker: a number is a machine of the seed, anything else the text of one.
  std::string work(const std::string& input, const SolverMakers& makers) const {
    if (input.front() != '#') return format_outcome(try_machine(unpack(input), folder_of_process(), makers));
    const std::uint64_t number = std::stoull(input.substr(1));
    const bool refines = number % kRefinedOnceIn == 0;
    return format_outcome(try_machine(write_machine(machine(number)), folder_of_process(), makers, refines));
  }

  [[nodiscard]] Machine machine(std::uint64_t number) const { return draw_machine(command_.seed, number, style_); }

  void try_all(Clock::time_point start) {
    std::uint64_t given = 0;
    const auto next = [&]() -> std::optional<std::string> {
      const bool is_late = command_.minutes && seconds_since(start) > 60.0 * *command_.minutes;
      if (given >= count_ || is_late) return std::nullopt;
      return fmt::format("#{}", command_.first + given++);
    };
    pool_.run(next, [&](std::size_t k, const workers::Report& report) {
      const std::uint64_t number = command_.first + k;
      const Outcome outcome = outcome_of(report);
      ++tried_;
      seconds_ += report.seconds;
      if (report.seconds > slowest_.seconds) slowest_ = {number, report.seconds};
      ++outcomes_.try_emplace({outcome.sort, outcome.kind}, Met{0, number}).first->second.count;
      if (outcome.ratios.largest > ratios_.largest) machine_of_largest_ratio_ = number;
      ratios_.add(outcome.ratios);
      const Machine drawn = machine(number);
      coverage_.add(drawn);
      if (drawn.should_be_judged()) {
        ++regular_;
        if (outcome.sort == Sort::refusal) ++regular_refused_[outcome.kind];
      }
      if (outcome.is_wrong()) {
        casualties_.push_back({number, outcome});
        wipe_line();
        console_.out << fmt::format("machine {}: {}\n{}\n", number, outcome.kind, indented(outcome.text)) << std::flush;
      }
      note_progress(fmt::format("{} machines were tried, {} ended wrongly", tried_, casualties_.size()));
      if (outcome.sort == Sort::lost) code_ = kCouldNotFinish;
      if ((outcome.sort == Sort::differ || outcome.sort == Sort::stop) && code_ == kAgree) code_ = kDiffer;
      show_progress(start);
    });
  }

  void show_progress(Clock::time_point start) {
    if (!console_.progress) return;
    const double spent = seconds_since(start);
    double left = static_cast<double>(count_ - tried_) * spent / static_cast<double>(tried_);
    if (command_.minutes) left = std::min(left, std::max(0.0, 60.0 * *command_.minutes - spent));
    console_.err << fmt::format("\r\033[K{} machines, {} ended wrongly, {:.0f} s left", tried_, casualties_.size(),
                                left)
                 << std::flush;
  }

  void wipe_line() {
    if (console_.progress) console_.err << "\r\033[K" << std::flush;
  }

  void tell_speed() const {
    console_.err << fmt::format(
        "{} machines in {:.1f} s of processor time: {:.1f} machines per second and core; "
        "the slowest, machine {}, took {:.2f} s\n",
        tried_, seconds_, static_cast<double>(tried_) / std::max(seconds_, 1e-9), slowest_.number, slowest_.seconds);
  }

  void keep_all() {
    for (const Casualty& one : casualties_) {
      if (console_.progress) console_.err << fmt::format("\r\033[Kshrinking machine {}", one.number) << std::flush;
      const std::filesystem::path file = keep(one);
      wipe_line();
      console_.out << fmt::format("machine {} is kept as {}: {}\n", one.number, file.filename().string(),
                                  one.outcome.kind)
                   << std::flush;
    }
    if (!casualties_.empty()) console_.out << '\n';
  }

  static std::string indented(const std::string& text) {
    std::string lines;
    std::size_t at = 0;
    while (at < text.size()) {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      lines += "  " + text.substr(at, end - at) + '\n';
      at = end + 1;
    }
    return lines;
  }

  std::filesystem::path keep(const Casualty& one) {
    Machine smallest = shrink(machine(one.number), command_.seed, [&](const std::vector<Machine>& candidates) {
      return first_that_keeps(one, candidates);
    });
    smallest.name = fmt::format("fuzz_{}_{}", command_.seed, one.number);
    const ModelText text = write_machine(smallest);
    std::filesystem::path file = command_.keep / (smallest.name + ".toml");
    std::string header =
        fmt::format("# {}\n# concord compare {}\n# Machine {} of seed {}, style {}, shrunk:\n", one.outcome.kind,
                    file.filename().string(), one.number, command_.seed, command_.style);
    for (const char c : one.outcome.text) header += header.back() == '\n' ? std::string("# ") + c : std::string(1, c);
    if (header.back() != '\n') header += '\n';
    write_model(file, text, header);
    return file;
  }

  /// Candidates are tried side by side, some at a time, but the first of the list wins, whatever the number of workers.
  std::optional<std::size_t> first_that_keeps(const Casualty& one, const std::vector<Machine>& candidates) {
    std::optional<std::size_t> found;
    std::size_t given = 0;
    const auto next = [&]() -> std::optional<std::string> {
      if (found || given >= candidates.size()) return std::nullopt;
      return pack(write_machine(candidates[given++]));
    };
    pool_.run(next, [&](std::size_t k, const workers::Report& report) {
      if (!found && outcome_of(report).kind == one.outcome.kind) found = k;
    });
    return found;
  }

  [[nodiscard]] std::string format_outcomes() const {
    std::vector<std::vector<std::string>> lines{{"outcome", "machines", "share", "first"}};
    for (const auto& [outcome, met] : outcomes_) {
      const std::string name = outcome.first == Sort::agree     ? "agree"
                               : outcome.first == Sort::refusal ? "refused: " + outcome.second
                                                                : outcome.second;
      lines.push_back({name, fmt::format("{}", met.count), share(met.count, tried_), fmt::format("{}", met.first)});
    }
    std::string text = format_table(lines, {false, true, true, true});
    text += fmt::format("\nof {} regular machines {} refused\n", regular_, share(refused_of_regular(), regular_));
    for (const auto& [kind, count] : regular_refused_) text += fmt::format("  {}: {}\n", kind, share(count, regular_));
    if (ratios_.count() > 0) {
      text += fmt::format(
          "\ndifference over resolution at the same state, {} components: 99 % up to {:g}, 99.99 % up to {:g}, largest "
          "{:.3g} (machine {})\n",
          ratios_.count(), ratios_.edge_of(0.99), ratios_.edge_of(0.9999), ratios_.largest, machine_of_largest_ratio_);
    }
    return text;
  }

  [[nodiscard]] long refused_of_regular() const {
    return std::accumulate(regular_refused_.begin(), regular_refused_.end(), 0L,
                           [](long sum, const auto& kind) { return sum + kind.second; });
  }

  void doubt_refusals() {
    const long refused = refused_of_regular();
    if (!refuses_too_many(regular_, refused)) return;
    console_.out << fmt::format(
        "\n{} of regular machines are refused, where sound solvers refuse about 1 %: one of them is at fault, or the "
        "generator\n",
        share(refused, regular_));
    if (code_ == kAgree) code_ = kDiffer;
  }

  /// That of one worker process.
  [[nodiscard]] std::filesystem::path folder_of_process() const {
    return scratch_.path() / fmt::format("{}", getpid());
  }

  static std::string share(long part, long all) {
    return fmt::format("{:.2f} %", all == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(all));
  }

  const FuzzCommand& command_;
  const Console& console_;
  Style style_;
  std::uint64_t count_;
  int jobs_;
  StagedFolder scratch_;  // for modes files: it goes when the fuzz ends, or is interrupted
  workers::Pool pool_;
  long tried_ = 0;
  ResolutionRatios ratios_;
  std::uint64_t machine_of_largest_ratio_ = 0;
  double seconds_ = 0.0;
  Slowest slowest_;
  long regular_ = 0;
  std::map<std::pair<Sort, std::string>, Met> outcomes_;
  std::map<std::string, long> regular_refused_;
  Coverage coverage_;
  std::vector<Casualty> casualties_;
  int code_ = kAgree;
};

/// As drawn, not shrunk. Modes files are files of their own, so that they need a folder.
int print_machine(const FuzzCommand& command, const Console& console) {
  const Machine machine = draw_machine(command.seed, command.first, style_of(command.style));
  const ModelText text = write_machine(machine);
  if (!command.keep.empty()) {
    const std::filesystem::path file = command.keep / (machine.name + ".toml");
    write_model(file, text);
    console.out << fmt::format("{}\n", file.string());
    return kAgree;
  }
  console.out << text.model;
  if (!text.beside.empty()) {
    console.err << fmt::format("the model names {} that {} not printed: --keep FOLDER writes all files\n",
                               plural(static_cast<int>(text.beside.size()), "modes file", "modes files"),
                               text.beside.size() == 1 ? "is" : "are");
  }
  return kAgree;
}

}  // namespace

int fuzz_machines(const FuzzCommand& command, const SolverMakers& makers, const Console& console) {
  return guarded(console, [&] {
    if (!command.keep.empty()) check_target_folder(command.keep);
    if (command.print) return print_machine(command, console);
    return Fuzz(command, makers, console).run();
  });
}

}  // namespace concord::compare::fuzz
