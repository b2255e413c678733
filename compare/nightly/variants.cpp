#include "compare/nightly/variants.h"

#include <fmt/format.h>

#include <set>

#include "common/reading/model_file.h"
#include "compare/report/files.h"

namespace concord::compare::nightly {

namespace {

/// Replaces every case by `count` of its kind; `change` makes the k-th of one and returns its word.
template <class Change>
void multiply(std::vector<Case>& cases, std::size_t count, const Change& change) {
  if (count == 0) return;
  std::vector<Case> all;
  for (const Case& one : cases) {
    for (std::size_t k = 0; k < count; ++k) {
      Case& variant = all.emplace_back(one);
      const std::string word = change(k, variant);
      // The first word stands behind a slash of its own.
      variant.id += (one.id.ends_with('/') ? "" : ",") + word;
    }
  }
  cases = std::move(all);
}

/// Six digits of each value, or as many more as tell them apart.
std::vector<std::string> words_apart(const std::vector<double>& values) {
  constexpr int kAllDigits = 17;
  std::vector<std::string> words;
  for (int digits = 6; digits <= kAllDigits; ++digits) {
    words.clear();
    for (const double value : values) words.push_back(fmt::format("{:.{}g}", value, digits));
    if (std::set<std::string>(words.begin(), words.end()).size() == words.size()) break;
  }
  return words;
}

/// The model's file and those that it opens: included ones, modes.
std::string definition_of_model(const std::filesystem::path& model) {
  std::string text = fmt::format(" {} {:016x}", model.filename().string(), hash_of_file(model));
  std::set<std::string> told{model.lexically_normal().string()};
  for (const std::filesystem::path& file : files_of_model(model)) {
    if (!told.insert(file.lexically_normal().string()).second) continue;
    text += fmt::format(" +{} {:016x}", file.filename().string(), hash_of_file(file));
  }
  return text;
}

std::string words_of(const std::optional<double>& value) { return value ? fmt::format("{:.17g}", *value) : "-"; }

std::string definition_of_needs(const std::vector<NeedOverride>& needs) {
  std::string text;
  for (const NeedOverride& need : needs) {
    text += fmt::format(" need({},{},{},{},{},{},{},{})", need.joint, need.element, need.body, need.component,
                        words_of(need.same_state), words_of(need.same_run), words_of(need.refined), need.because);
  }
  return text;
}

}  // namespace

const std::vector<std::string>& work_names() {
  static const std::vector<std::string> names{"compare", "statics", "linearize", "kinematics",
                                              "inverse", "joint",   "fuzz",      "invariance"};
  return names;
}

const std::string& name_of(Work work) { return work_names()[static_cast<std::size_t>(work)]; }

double Sweep::combinations() const {
  double count = 1.0;
  const auto times = [&](std::size_t n) { count *= n == 0 ? 1.0 : static_cast<double>(n); };
  for (const auto& [name, values] : parameters) times(values.size());
  times(cuts.size());
  times(integrators.size());
  times(rtol.size());
  if (start) times(static_cast<std::size_t>(start->count));
  return count;
}

std::vector<Case> variants_of(const Case& base, const Sweep& sweep) {
  std::vector<Case> cases{base};
  cases.front().id += '/';
  for (const auto& [name, values] : sweep.parameters) {
    const std::vector<std::string> words = words_apart(values);
    multiply(cases, values.size(), [&, &parameter = name, &all = values](std::size_t k, Case& variant) {
      variant.parameters.emplace_back(parameter, all[k]);
      return fmt::format("{}={}", parameter, words[k]);
    });
  }
  multiply(cases, sweep.cuts.size(), [&](std::size_t k, Case& variant) {
    variant.cut = sweep.cuts[k].second;
    return "cut=" + sweep.cuts[k].first;
  });
  multiply(cases, sweep.integrators.size(), [&](std::size_t k, Case& variant) {
    variant.options.integrators = sweep.integrators[k];
    return fmt::format("{}+{}", sweep.integrators[k][0], sweep.integrators[k][1]);
  });
  const std::vector<std::string> tolerances = words_apart(sweep.rtol);
  multiply(cases, sweep.rtol.size(), [&](std::size_t k, Case& variant) {
    variant.options.rtol = sweep.rtol[k];
    return "rtol=" + tolerances[k];
  });
  multiply(cases, sweep.start ? static_cast<std::size_t>(sweep.start->count) : 0, [&](std::size_t k, Case& variant) {
    variant.start = sweep.start->first;
    variant.start->number = k;
    return fmt::format("start={}", k);
  });
  if (cases.size() == 1 && cases.front().id.ends_with('/')) cases.front().id.pop_back();
  return cases;
}

std::string definition_of(const Case& one) {
  std::string text = name_of(one.work);
  if (!one.model.empty()) text += definition_of_model(one.model);
  text += fmt::format(" until={} rtol={} samples={} states={} {}+{}", words_of(one.options.until),
                      words_of(one.options.rtol), one.options.samples.value_or(0), one.options.states.value_or(0),
                      one.options.integrators[0], one.options.integrators[1]);
  for (const auto& [name, value] : one.parameters) text += fmt::format(" {}={:.17g}", name, value);
  if (one.cut) text += " cut";
  for (const std::string& joint : one.cut.value_or(std::vector<std::string>())) text += fmt::format(" '{}'", joint);
  if (one.start) {
    text += fmt::format(" start({},{},{:.17g},{:.17g},{:.17g},{:.17g})", one.start->seed, one.start->number,
                        one.start->turn, one.start->slide, one.start->turn_speed, one.start->slide_speed);
  }
  text += definition_of_needs(one.needs);
  if (one.at_equilibrium) text += " at equilibrium";
  for (const auto& asked : one.accelerations) {
    text += fmt::format(" {}.{}={:.17g}", asked.joint, asked.coordinate, asked.value);
  }
  if (one.work == Work::joint) text += fmt::format(" {} {}", one.joint, one.poses);
  if (one.work == Work::fuzz)
    text += fmt::format(" {} {}+{} {}", one.fuzz.seed, one.fuzz.first, one.fuzz.count, one.fuzz.style);
  return text;
}

}  // namespace concord::compare::nightly
