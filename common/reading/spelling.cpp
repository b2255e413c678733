#include "common/reading/spelling.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "common/reading/absent_words.h"

namespace concord {

namespace {

/// Nobody wants guesses about longer words or among more names; they would take long.
constexpr std::size_t kLongestGuess = 100;
constexpr std::size_t kMostGuesses = 1000;
constexpr std::ptrdiff_t kMostListed = 60;

/// What other programs, and textbooks, call words of the format.
constexpr std::pair<std::string_view, std::string_view> kOtherNames[] = {
    {"prismatic", "translational"},
    {"slider", "translational"},
    {"hinge", "revolute"},
    {"pin", "revolute"},
    {"ball", "spherical"},
    {"socket", "spherical"},
    {"cardan", "universal"},
    {"hooke", "universal"},
    {"fixed", "weld"},
    {"rigid", "weld"},
    {"floating", "free"},
    {"rod", "distance"},
    {"helical", "screw"},
    {"sine", "harmonic"},
    {"sin", "harmonic"},
    {"cosine", "harmonic"},
    {"step", "smooth_step"},
    {"table", "spline"},
    {"local", "body"},
    {"world", "global"},
    {"mu", "friction"},
};

/// What may be the singular of a word, itself included.
std::vector<std::string> singulars_of(std::string_view word) {
  constexpr std::pair<std::string_view, std::string_view> kEndings[] = {
      {"ies", "y"}, {"es", ""}, {"es", "is"}, {"s", ""}};
  std::vector<std::string> singulars{std::string(word)};
  for (const auto& [plural, singular] : kEndings) {
    if (word.size() < plural.size() + 2 || !word.ends_with(plural)) continue;
    singulars.push_back(std::string(word.substr(0, word.size() - plural.size())).append(singular));
  }
  return singulars;
}

/// The candidate that is the word in another number or by another name, or nullptr.
const std::string* meant_by(std::string_view word, const std::vector<std::string>& candidates) {
  if (word.size() > kLongestGuess || candidates.size() > kMostGuesses) return nullptr;
  const auto in_other_number = std::find_if(candidates.begin(), candidates.end(), [word](const std::string& candidate) {
    return is_same_but_for_number(word, candidate);
  });
  if (in_other_number != candidates.end()) return &*in_other_number;
  for (const auto& [other, own] : kOtherNames) {
    const auto found = word == other ? std::find(candidates.begin(), candidates.end(), own) : candidates.end();
    if (found != candidates.end()) return &*found;
  }
  return nullptr;
}

}  // namespace

int edit_distance(std::string_view a, std::string_view b) {
  const auto rows = a.size() + 1;
  const auto columns = b.size() + 1;
  std::vector<int> cost(rows * columns);
  const auto at = [&](std::size_t i, std::size_t j) -> int& { return cost[i * columns + j]; };
  for (std::size_t i = 0; i < rows; ++i) at(i, 0) = static_cast<int>(i);
  for (std::size_t j = 0; j < columns; ++j) at(0, j) = static_cast<int>(j);
  for (std::size_t i = 1; i < rows; ++i) {
    for (std::size_t j = 1; j < columns; ++j) {
      const int replaced = at(i - 1, j - 1) + (a[i - 1] == b[j - 1] ? 0 : 1);
      at(i, j) = std::min({at(i - 1, j) + 1, at(i, j - 1) + 1, replaced});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) at(i, j) = std::min(at(i, j), at(i - 2, j - 2) + 1);
    }
  }
  return at(rows - 1, columns - 1);
}

bool is_same_but_for_number(std::string_view a, std::string_view b) {
  const std::vector<std::string> ours = singulars_of(a);
  const std::vector<std::string> theirs = singulars_of(b);
  return std::find_first_of(ours.begin(), ours.end(), theirs.begin(), theirs.end()) != ours.end();
}

std::string suggestion(std::string_view word, const std::vector<std::string>& candidates, std::string_view plural) {
  if (candidates.empty()) return fmt::format("there are no {}", plural);
  if (word.size() > kLongestGuess || candidates.size() > kMostGuesses) {
    return fmt::format("known {}: {}", plural, join_names(candidates));
  }
  if (const std::string* meant = meant_by(word, candidates)) {
    return fmt::format("did you mean '{}'?", *meant);
  }
  const auto distance_to = [word](const std::string& candidate) {
    return edit_distance(word, std::string_view(candidate).substr(0, 2 * kLongestGuess));
  };
  const auto nearest =
      std::min_element(candidates.begin(), candidates.end(),
                       [&](const std::string& a, const std::string& b) { return distance_to(a) < distance_to(b); });
  const int near_enough = static_cast<int>(std::max(word.size(), nearest->size())) / 3;
  if (distance_to(*nearest) <= near_enough && nearest->size() > 1) {
    return fmt::format("did you mean '{}'?", *nearest);
  }
  return fmt::format("known {}: {}", plural, join_names(candidates));
}

std::string help_with_word(std::string_view word, const std::vector<std::string>& candidates, std::string_view plural) {
  const std::string_view absent = what_is_absent(word);
  if (absent.empty() || meant_by(word, candidates) != nullptr) return suggestion(word, candidates, plural);
  return std::string(absent);
}

std::string join_names(const std::vector<std::string>& names) {
  if (std::ssize(names) <= kMostListed) return fmt::format("{}", fmt::join(names, ", "));
  return fmt::format("{}, ... ({} in all)", fmt::join(names.begin(), names.begin() + kMostListed, ", "), names.size());
}

}  // namespace concord
