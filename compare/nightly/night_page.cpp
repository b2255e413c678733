#include "compare/nightly/night_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "compare/nightly/judgement.h"
#include "compare/nightly/night.h"
#include "compare/nightly/record.h"
#include "compare/page/fill.h"

namespace concord::compare::nightly {

namespace {

// What keeps a page below 3 MB: a night of a case takes some 60 bytes, a step or a change some 250.
constexpr std::size_t kMostPoints = 18000;
constexpr std::size_t kMostSteps = 2500;
constexpr std::size_t kMostStepsOfACase = 40;
constexpr std::size_t kMostChanges = 2000;
constexpr std::size_t kMostWords = 500000;  // bytes
constexpr std::size_t kMostWordsOfACase = 4000;
constexpr int kFewestNights = 2;

Json digits_json(const std::optional<double>& digits) {
  if (!digits || !std::isfinite(*digits)) return nullptr;
  return std::round(*digits * 100.0) / 100.0;
}

double rounded_seconds(double seconds) { return std::round(seconds * 1000.0) / 1000.0; }

/// Digits that double precision resolves where the same state agrees least.
std::optional<double> resolvable_at_worst(const Result& result) {
  const Component* worst = nullptr;
  for (const Component& one : result.components) {
    if (one.same_state && (worst == nullptr || *one.same_state < *worst->same_state)) worst = &one;
  }
  return worst == nullptr ? std::nullopt : worst->resolvable;
}

bool has_cost(const Result& result) {
  return std::any_of(result.cost.begin(), result.cost.end(), [](const Cost& cost) { return cost.evaluations > 0; });
}

Json night_json(const Night& night) {
  Json said{{"id", night.id}, {"started", night.started}};
  said.update(Json(night.origin));
  return said;
}

/// The case over the nights; null where a night did not have it.
class TrendJson {
 public:
  explicit TrendJson(std::size_t nights) {
    const Json none = Json(std::vector<Json>(nights));
    for (const char* key : {"ending", "same_state", "resolvable", "same_run", "refined", "wall_s"}) trend_[key] = none;
    for (const char* key : {"evaluations", "steps"}) trend_[key] = Json::array({none, none});
  }

  void put(std::size_t at, const Result& result) {
    trend_["ending"][at] = to_string(result.ending);
    const auto [same_state, same_run, refined] = worst_digits(result);
    trend_["same_state"][at] = digits_json(same_state);
    trend_["resolvable"][at] = digits_json(resolvable_at_worst(result));
    trend_["same_run"][at] = digits_json(same_run);
    trend_["refined"][at] = digits_json(refined);
    trend_["wall_s"][at] = rounded_seconds(result.wall_s);
    // A case that was lost, or that integrates nothing, has no cost.
    for (std::size_t who = 0; who < 2 && has_cost(result); ++who) {
      trend_["evaluations"][who][at] = result.cost[who].evaluations;
      trend_["steps"][who][at] = result.cost[who].steps;
    }
  }

  Json take() { return std::move(trend_); }

 private:
  Json trend_;
};

Json step_json(const Change& change, std::size_t before, std::size_t night) {
  return {{"what", to_string(change.kind)}, {"before", before},  {"night", night},  {"component", change.component},
          {"measure", change.measure},      {"was", change.was}, {"is", change.is}, {"more", change.more}};
}

/// Words of a case, shortened within no character.
std::string shortened(const std::string& words, std::size_t most) {
  if (words.size() <= most) return words;
  std::size_t end = most;
  while (end > 0 && (static_cast<unsigned char>(words[end]) & 0xC0U) == 0x80U) --end;
  return words.substr(0, end) + " ...";
}

/// How much each may have of a budget so that those who have something share it.
template <class Size>
std::size_t share_of(const Json& cases, std::size_t budget, std::size_t most, std::size_t least, const Size& size) {
  std::size_t all = 0;
  std::size_t owners = 0;
  for (const Json& one : cases) {
    const std::size_t has = std::min(most, size(one));
    all += has;
    owners += has > 0 ? 1 : 0;
  }
  return all <= budget ? most : std::max(least, budget / owners);
}

void keep_late_steps(Json& cases) {
  const auto count = [](const Json& one) { return one.at("steps").size(); };
  const std::size_t most = share_of(cases, kMostSteps, kMostStepsOfACase, 1, count);
  for (Json& one : cases) {
    if (count(one) <= most) continue;
    const std::size_t left_out = count(one) - most;
    one["steps"].erase(one["steps"].begin(), one["steps"].begin() + static_cast<std::ptrdiff_t>(left_out));
    one["steps_left_out"] = left_out;
  }
}

void keep_first_words(Json& cases) {
  const auto words = [](const Json& one) -> const std::string& {
    return one.at("words").get_ref<const std::string&>();
  };
  const auto length = [&](const Json& one) { return words(one).size(); };
  const std::size_t most = share_of(cases, kMostWords, kMostWordsOfACase, 160, length);
  for (Json& one : cases) one["words"] = shortened(words(one), most);
}

class PageData {
 public:
  PageData(const NightPage& page, History& history) : page_(page), history_(history) {
    const auto cases = std::max<std::size_t>(1, page.report.cases.size());
    const auto room = static_cast<int>(kMostPoints / cases);
    last_ = std::clamp(room, std::min(kFewestNights, page.last), page.last);
    choose_nights();
  }

  Json json() {
    Json cases = Json::array();
    for (const CaseLine& line : page_.report.cases) cases.push_back(case_json(line));
    keep_late_steps(cases);
    keep_first_words(cases);
    Json turns = Json::object();
    Json changes = changes_json(turns);
    Json nights = Json::array();
    for (const Night& night : nights_) nights.push_back(night_json(night));
    const int code = page_.report.code;
    return {{"made", page::made_words()},
            {"title", page_.report.title},
            {"sentence", format_sentence(page_.report)},
            {"outcome", code == 0   ? "agree"
                        : code == 4 ? "open"
                                    : "differ"},
            {"notes", notes()},
            {"night", night_json(page_.night)},
            {"nights", std::move(nights)},
            {"turns", std::move(turns)},
            {"changes", std::move(changes)},
            {"cases", std::move(cases)}};
  }

 private:
  /// The suite's finished nights before this one, as many as are shown, and this one.
  void choose_nights() {
    for (const Night& night : history_.nights(page_.night.suite)) {
      if (night.id < page_.night.id && !night.finished.empty()) nights_.push_back(night);
    }
    earlier_ = nights_.size();
    const auto most = static_cast<std::size_t>(last_ - 1);
    if (nights_.size() > most) nights_.erase(nights_.begin(), nights_.end() - static_cast<std::ptrdiff_t>(most));
    nights_.push_back(page_.night);
    for (std::size_t k = 0; k < nights_.size(); ++k) place_[nights_[k].id] = k;
  }

  std::vector<std::string> notes() const {
    std::vector<std::string> all = page_.notes;
    const Origin& origin = page_.night.origin;
    all.push_back(fmt::format("{}, commit {}, {}; {}", origin.version, origin.commit, origin.compiler, origin.machine));
    if (earlier_ + 1 > nights_.size()) {
      all.push_back(fmt::format("The trends show the last {} nights; the history holds {} up to this one.",
                                nights_.size(), earlier_ + 1));
    }
    if (changes_left_out_ > 0) {
      all.push_back(fmt::format("The table shows the gravest {} changes; {} others are left out.", kMostChanges,
                                changes_left_out_));
    }
    return all;
  }

  Json changes_json(Json& turns) {
    Json list = Json::array();
    std::map<std::string, int> counts;
    for (const Change* change : all_changes(page_.report)) {
      ++counts[to_string(change->kind)];
      list.size() < kMostChanges ? list.push_back(change_json(*change)) : static_cast<void>(++changes_left_out_);
    }
    for (const auto& [turn, count] : counts) turns[turn] = count;
    return list;
  }

  /// The case in the nights that are shown, the earliest first, each with its place.
  std::vector<std::pair<std::size_t, Result>> entries_of(const std::string& id) {
    std::vector<std::pair<std::size_t, Result>> all;
    std::vector<Entry> before;
    if (nights_.size() > 1) {
      before = history_.before(page_.night.id, page_.night.suite, id, static_cast<int>(nights_.size()) - 1);
    }
    for (auto entry = before.rbegin(); entry != before.rend(); ++entry) {
      const auto place = place_.find(entry->night.id);
      if (place != place_.end()) all.emplace_back(place->second, std::move(entry->result));
    }
    all.emplace_back(nights_.size() - 1, result_of_case(history_, page_.night.id, id));
    return all;
  }

  std::string past_of(const CaseLine& line, bool is_first) const {
    if (!line.changes.empty() || page_.judging.against_baseline) return past_words(line);
    return is_first ? "first time" : "as before";
  }

  Json case_json(const CaseLine& line) {
    const auto entries = entries_of(line.id);
    TrendJson trend(nights_.size());
    Json steps = Json::array();
    for (std::size_t k = 0; k < entries.size(); ++k) {
      trend.put(entries[k].first, entries[k].second);
      if (k == 0) continue;
      for (const Change& change : changes_between(entries[k - 1].second, entries[k].second, page_.judging, "")) {
        steps.push_back(step_json(change, entries[k - 1].first, entries[k].first));
      }
    }
    const Result& now = entries.back().second;
    const std::string page = page_name_of(line.id);
    return {{"id", line.id},
            {"page", page_.pages.contains(page) ? Json(page) : Json()},
            {"work", line.work},
            {"ending", to_string(line.ending)},
            {"words", now.words},
            {"past", past_of(line, entries.size() == 1)},
            {"code", line.code},
            {"judged", line.judged},
            {"total", line.total},
            {"worst", {digits_json(line.worst[0]), digits_json(line.worst[1]), digits_json(line.worst[2])}},
            {"resolvable", digits_json(resolvable_at_worst(now))},
            {"evaluations", line.evaluations},
            {"steps_taken", line.steps},
            {"integrators", {now.cost[0].integrator, now.cost[1].integrator}},
            {"wall_s", rounded_seconds(now.wall_s)},
            {"trend", trend.take()},
            {"steps", std::move(steps)},
            {"steps_left_out", 0}};
  }

  const NightPage& page_;
  History& history_;
  int last_ = 0;
  std::size_t earlier_ = 0;
  std::size_t changes_left_out_ = 0;
  std::vector<Night> nights_;
  std::map<long, std::size_t> place_;
};

}  // namespace

std::string format_night_page(const NightPage& page, History& history) {
  const std::string headline = format_headline(page.report);
  return page::fill_page(page::night_parts(), "concord: " + headline.substr(0, headline.find('\n')),
                         PageData(page, history).json());
}

}  // namespace concord::compare::nightly
