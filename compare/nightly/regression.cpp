#include "compare/nightly/regression.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "compare/audit/digits.h"
#include "compare/report/console.h"
#include "compare/report/text_table.h"

namespace concord::compare::nightly {

namespace {

constexpr std::array<std::string_view, 9> kChangeKinds{"red",   "worse",     "gone",   "no baseline", "changed",
                                                       "flaky", "known red", "better", "new"};
/// A difference within 20 resolutions is round-off (compare/resolution/resolution).
const double kLuck = std::log10(20.0);
/// Digits of runs beyond this are luck, too: steps are summed up.
constexpr double kMostRunDigits = 13.0;

/// Collects the changes of one case: of each kind and measure the largest, and how many others there are.
class ChangeList {
 public:
  /// `is_same_question`: both results were asked the same; else all that changed but the ending is `changed`.
  ChangeList(const std::string& id, bool is_same_question) : id_(id), is_same_question_(is_same_question) {}

  void add(Change change) {
    change.id = id_;
    if (!is_same_question_ && change.measure != "ending") change.kind = ChangeKind::changed;
    const auto [entry, is_new] = changes_.try_emplace({change.kind, change.measure}, change);
    if (is_new) return;
    const int more = entry->second.more + 1;
    if (change.size > entry->second.size) entry->second = std::move(change);
    entry->second.more = more;
  }

  [[nodiscard]] std::vector<Change> list() const {
    std::vector<Change> all;
    for (const auto& [key, change] : changes_) all.push_back(change);
    return all;
  }

 private:
  std::string id_;
  bool is_same_question_;
  std::map<std::pair<ChangeKind, std::string>, Change> changes_;
};

std::optional<double> same_state_that_counts(const Component& one) {
  if (!one.same_state || !one.resolvable) return one.same_state;
  return std::min(*one.same_state, *one.resolvable - kLuck);
}

std::optional<double> run_that_counts(const std::optional<double>& digits) {
  return digits ? std::optional(std::min(*digits, kMostRunDigits)) : digits;
}

/// What is not known is taken for the same.
bool is_same_question(const Result& then, const Result& now) {
  return then.definition.empty() || now.definition.empty() || then.definition == now.definition;
}

/// Compares one case of two nights.
class CaseComparison {
 public:
  CaseComparison(const Result& then, const Result& now, const Judging& judging, const std::string& against)
      : then_(then),
        now_(now),
        allowance_(judging.allowance_of(now.id.empty() ? then.id : now.id)),
        against_(against),
        changes_(now.id.empty() ? then.id : now.id, is_same_question(then, now)) {}

  std::vector<Change> run() {
    if (then_.ending != now_.ending) {
      const bool is_better = now_.is_green();
      add(is_better ? ChangeKind::better : ChangeKind::worse, "", "ending", to_string(then_.ending),
          to_string(now_.ending));
    }
    // A case that was lost has nothing else to be compared.
    if (has_numbers(then_) && has_numbers(now_)) {
      compare_coverage();
      compare_costs();
      compare_components();
    }
    return changes_.list();
  }

 private:
  void add(ChangeKind kind, const std::string& component, const std::string& measure, const std::string& was,
           const std::string& is, double size = 1.0) {
    changes_.add({kind, "", component, measure, was, is, against_, size});
  }

  /// What was judged once and is not now was not agreed on.
  void compare_coverage() {
    if (now_.judged >= then_.judged) return;
    add(ChangeKind::worse, "", "judged", fmt::format("{} of {}", then_.judged, then_.total),
        fmt::format("{} of {}", now_.judged, now_.total), static_cast<double>(then_.judged - now_.judged));
  }

  static bool has_numbers(const Result& result) {
    return result.ending == Ending::agree || result.ending == Ending::differ || !result.components.empty();
  }

  void compare_costs() {
    constexpr std::array kNames{"cartesian", "relative"};
    for (std::size_t who = 0; who < 2; ++who) {
      compare_cost(fmt::format("evaluations of {}", kNames[who]), then_.cost[who].evaluations,
                   now_.cost[who].evaluations);
      compare_cost(fmt::format("steps of {}", kNames[who]), then_.cost[who].steps, now_.cost[who].steps);
    }
  }

  void compare_cost(const std::string& measure, long was, long is) {
    const auto rise = [](long from, long to) {
      return from > 0 ? static_cast<double>(to - from) / static_cast<double>(from) : (to > from ? 1.0 : 0.0);
    };
    const double up = rise(was, is);
    if (up <= allowance_.cost && rise(is, was) <= allowance_.cost) return;
    add(up > 0.0 ? ChangeKind::worse : ChangeKind::better, "", measure, fmt::format("{}", was),
        fmt::format("{} ({})", is, format_percent(up, 0)), std::abs(up));
  }

  void compare_components() {
    auto then = then_.components.begin();
    auto now = now_.components.begin();
    while (then != then_.components.end() || now != now_.components.end()) {
      const bool only_then = now == now_.components.end() || (then != then_.components.end() && then->name < now->name);
      const bool only_now = then == then_.components.end() || (now != now_.components.end() && now->name < then->name);
      if (only_then) {
        add(ChangeKind::gone, then->name, "component", "judged", "not judged");
        ++then;
      } else if (only_now) {
        add(ChangeKind::fresh, now->name, "component", "not judged", "judged");
        ++now;
      } else {
        compare_component(*then++, *now++);
      }
    }
  }

  void compare_component(const Component& then, const Component& now) {
    compare_digits("same state", now.name, same_state_that_counts(then), same_state_that_counts(now),
                   digits_cell(then.same_state, then.resolvable), digits_cell(now.same_state, now.resolvable));
    compare_digits("same run", now.name, run_that_counts(then.same_run), run_that_counts(now.same_run),
                   digits_cell(then.same_run), digits_cell(now.same_run));
    compare_digits("refined", now.name, run_that_counts(then.refined), run_that_counts(now.refined),
                   digits_cell(then.refined), digits_cell(now.refined));
    compare_peaks(then, now);
  }

  void compare_digits(const std::string& measure, const std::string& component, const std::optional<double>& then,
                      const std::optional<double>& now, const std::string& was, const std::string& is) {
    if (then && !now) add(ChangeKind::worse, component, measure, was, is, *then);
    if (!then || !now) return;
    const double fall = *then - *now;
    if (std::abs(fall) <= allowance_.margin) return;
    add(fall > 0.0 ? ChangeKind::worse : ChangeKind::better, component, measure, was, is, std::abs(fall));
  }

  void compare_peaks(const Component& then, const Component& now) {
    if (!then.peak || !now.peak) return;
    const double scale = std::max({then.scale, now.scale, 0.0});
    const double change = std::abs(*now.peak - *then.peak);
    if (change <= allowance_.peak * scale) return;
    add(ChangeKind::worse, now.name, "peak", fmt::format("{:.6g}", *then.peak), fmt::format("{:.6g}", *now.peak),
        scale > 0.0 ? change / scale : 1.0);
  }

  const Result& then_;
  const Result& now_;
  const Allowance& allowance_;
  const std::string& against_;
  ChangeList changes_;
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The median of what all nights have; nothing if none has it.
template <class Get>
std::optional<double> median_where(const std::vector<const Component*>& ones, const Get& get) {
  std::vector<double> values;
  for (const Component* one : ones) {
    if (const std::optional<double> value = get(*one)) values.push_back(*value);
  }
  return values.empty() ? std::nullopt : std::optional(median(std::move(values)));
}

Component median_component(const std::vector<const Component*>& ones) {
  Component middle = *ones.front();
  middle.same_state = median_where(ones, [](const Component& one) { return one.same_state; });
  middle.resolvable = median_where(ones, [](const Component& one) { return one.resolvable; });
  middle.same_run = median_where(ones, [](const Component& one) { return one.same_run; });
  middle.refined = median_where(ones, [](const Component& one) { return one.refined; });
  middle.peak = median_where(ones, [](const Component& one) { return one.peak; });
  return middle;
}

std::string first_line(const std::string& words) {
  constexpr std::size_t kMost = 160;
  std::string line = words.substr(0, words.find('\n'));
  if (line.size() > kMost) {
    std::size_t end = kMost;
    while (end > 0 && (static_cast<unsigned char>(line[end]) & 0xC0U) == 0x80U) --end;  // not within a character
    line = line.substr(0, end) + "...";
  }
  return line;
}

}  // namespace

std::string red_words(const Result& result) {
  return fmt::format("{}: {}", to_string(result.ending), first_line(result.words));
}

bool counts_as_known_red(const Case& one, const Result& now, const std::string& today) {
  const bool is_answer = now.ending == Ending::differ || now.ending == Ending::failed;
  return one.known_red && today <= one.known_red->until && is_answer;
}

namespace {

/// Why `known_red` does not excuse a red case: its last day is over, or the case crashed or stopped without an answer.
std::string words_of_no_excuse(const KnownRed& known, const std::string& today) {
  if (today > known.until) return fmt::format("known red until {}, which is over", known.until);
  return "known red, but for what a solver answers: this is no answer";
}

/// What a case's own ending says: nothing if it is green; `better` if it is green but was expected to be red; otherwise
/// `red`, or known red if the suite excuses it. A case is excused only if it ends as the baseline, if there is one.
std::optional<Change> own_change(const Case& one, const Result& now, const Result* baseline, const std::string& today) {
  const auto change = [&](ChangeKind kind, const std::string& was, const std::string& is, const char* against) {
    return Change{kind, one.id, "", "ending", was, is, against};
  };
  if (now.is_green()) {
    if (!one.known_red) return std::nullopt;
    const std::string was = "known red: " + one.known_red->reason;
    return change(ChangeKind::better, was, "agree: take its known_red away", "suite");
  }
  const std::string words = red_words(now);
  if (!counts_as_known_red(one, now, today)) {
    const std::string was = one.known_red ? words_of_no_excuse(*one.known_red, today) : "";
    return change(ChangeKind::red, was, words, "");
  }
  if (baseline != nullptr && !baseline->is_green() && baseline->ending != now.ending) {
    const std::string was = fmt::format("known red, accepted as '{}'", to_string(baseline->ending));
    return change(ChangeKind::red, was, words, "baseline");
  }
  const std::string was = fmt::format("{} (until {})", one.known_red->reason, one.known_red->until);
  return change(ChangeKind::known, was, words, "suite");
}

std::string counts_words(const Result& result) {
  return fmt::format("{}, {} and {} evaluations in {} and {} steps", to_string(result.ending),
                     result.cost[0].evaluations, result.cost[1].evaluations, result.cost[0].steps,
                     result.cost[1].steps);
}

bool has_same_counts(const Result& a, const Result& b) {
  const auto same = [](const Cost& x, const Cost& y) { return x.steps == y.steps && x.evaluations == y.evaluations; };
  return a.ending == b.ending && same(a.cost[0], b.cost[0]) && same(a.cost[1], b.cost[1]);
}

/// One program on one machine gives one result.
std::optional<Change> flaky_change(const Case& one, const Result& now, const std::vector<Entry>& earlier,
                                   const Origin& origin) {
  for (const Entry& entry : earlier) {
    const bool is_same_program = entry.night.origin == origin && !origin.commit.ends_with("-dirty");
    if (!is_same_program || entry.result.definition != now.definition || has_same_counts(entry.result, now)) continue;
    const std::string against = fmt::format("night {}", entry.night.id);
    return Change{ChangeKind::flaky, one.id, "", "same program", counts_words(entry.result),
                  counts_words(now), against};
  }
  return std::nullopt;
}

}  // namespace

std::string to_string(ChangeKind kind) { return std::string(kChangeKinds.at(static_cast<std::size_t>(kind))); }

std::vector<Change> changes_between(const Result& then, const Result& now, const Judging& judging,
                                    const std::string& against) {
  return CaseComparison(then, now, judging, against).run();
}

Result median_of(const std::vector<Entry>& nights) {
  Result middle = nights.front().result;
  std::map<std::string, std::vector<const Component*>> by_name;
  for (const Entry& entry : nights) {
    for (const Component& one : entry.result.components) by_name[one.name].push_back(&one);
  }
  middle.components.clear();
  for (const auto& [name, ones] : by_name) {
    if (2 * ones.size() > nights.size()) middle.components.push_back(median_component(ones));
  }
  for (std::size_t who = 0; who < 2; ++who) {
    std::vector<double> steps;
    std::vector<double> evaluations;
    for (const Entry& entry : nights) {
      steps.push_back(static_cast<double>(entry.result.cost[who].steps));
      evaluations.push_back(static_cast<double>(entry.result.cost[who].evaluations));
    }
    middle.cost[who].steps = std::lround(median(std::move(steps)));
    middle.cost[who].evaluations = std::lround(median(std::move(evaluations)));
  }
  return middle;
}

bool counts_as_past(const Result& then, const Result& now) {
  return then.is_green() && then.definition == now.definition;
}

std::vector<Change> judge_case(const Case& one, const Result& now, const Result* baseline,
                               const std::vector<Entry>& earlier, const Origin& origin, const Judging& judging,
                               const std::string& today) {
  std::vector<Change> changes;
  const auto own = own_change(one, now, judging.against_baseline ? baseline : nullptr, today);
  if (own) changes.push_back(*own);
  const auto take = [&](const std::vector<Change>& found) {
    for (const Change& change : found) {
      // How a case ended is reported once.
      if (change.measure != "ending" || !own) changes.push_back(change);
    }
  };
  if (now.ending == Ending::not_run) return changes;
  if (judging.against_baseline && baseline == nullptr) {
    const bool is_accepted = now.is_green() || counts_as_known_red(one, now, today);
    const char* advice = is_accepted ? "run concord accept" : "accept it when it is green";
    changes.push_back({ChangeKind::missing, one.id, "", "baseline", "-", advice, "baseline"});
  } else if (judging.against_baseline) {
    take(changes_between(*baseline, now, judging, "baseline"));
  }
  std::vector<Entry> green;
  for (const Entry& entry : earlier) {
    if (counts_as_past(entry.result, now)) green.push_back(entry);
  }
  if (judging.against_median && !green.empty()) {
    const std::string nights =
        green.size() == 1 ? "the night before" : fmt::format("median of {} nights", green.size());
    take(changes_between(median_of(green), now, judging, nights));
  }
  if (const auto flaky = flaky_change(one, now, earlier, origin)) changes.push_back(*flaky);
  return changes;
}

int exit_code(const Change& change, Ending ending) {
  switch (change.kind) {
    case ChangeKind::red:
      return exit_code(ending);
    case ChangeKind::worse:
    case ChangeKind::gone:
    case ChangeKind::flaky:
      return kDiffer;
    case ChangeKind::missing:
    case ChangeKind::changed:
      return kNoBaseline;
    default:
      return kAgree;
  }
}

int worse_code(int one, int other) {
  constexpr std::array kRank{0, 2, 3, 4, 1};  // of codes 0 to 4
  return kRank.at(static_cast<std::size_t>(one)) >= kRank.at(static_cast<std::size_t>(other)) ? one : other;
}

}  // namespace concord::compare::nightly
