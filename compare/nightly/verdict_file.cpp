#include "compare/nightly/verdict_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/error.h"
#include "common/reading/text_file.h"
#include "compare/nightly/record.h"
#include "compare/report/report_json.h"

namespace concord::compare::nightly {

namespace {

bool is_verdict(const Json& document) {
  return document.is_object() && document.contains("verdict") && document.contains("joints");
}

/// One object for each model, under its name.
bool are_verdicts(const Json& document) {
  return document.is_object() && !document.empty() && std::all_of(document.begin(), document.end(), is_verdict);
}

Component component_of_row(const char* owner, const Json& row) {
  Component one;
  one.name = fmt::format("{} {} on {}, {}", owner, row.at(owner).get<std::string>(), row.at("side").get<std::string>(),
                         row.at("component").get<std::string>());
  row.at("same_state_digits").get_to(one.same_state);
  row.at("same_state_resolvable_digits").get_to(one.resolvable);
  row.at("same_run_digits").get_to(one.same_run);
  row.at("refined_digits").get_to(one.refined);
  const Json& need = row.at("need");
  one.need = {need.at("same_state"), need.at("same_run"), need.at("refined")};
  one.scale = row.at("scale");
  return one;
}

/// What is not judged has no digits.
bool is_judged(const Component& one) { return one.same_state || one.same_run || one.refined; }

Ending ending_of_verdict(const std::string& verdict) {
  return verdict == "agree"       ? Ending::agree
         : verdict == "differ"    ? Ending::differ
         : verdict == "bad input" ? Ending::bad_input
                                  : Ending::failed;
}

Result result_of_verdict(const std::string& name, const Json& document) {
  if (document.at("format") != kVerdictFormat) {
    throw std::runtime_error(fmt::format("version {} of these results is not known: this program reads version {}",
                                         document.at("format").dump(), kVerdictFormat));
  }
  Result result;
  result.id = name;
  result.work = "compare";
  result.ending = ending_of_verdict(document.at("verdict"));
  if (document.contains("failures")) result.words = document.at("failures").at(0);
  result.judged = document.at("judged");
  result.total = document.at("total");
  for (const auto& [key, owner] : {std::pair{"joints", "joint"}, std::pair{"elements", "element"}}) {
    if (!document.contains(key)) continue;
    for (const Json& row : document.at(key)) {
      Component one = component_of_row(owner, row);
      if (is_judged(one)) result.components.push_back(std::move(one));
    }
  }
  Component& audit = result.components.emplace_back();
  audit.name = "audit";
  document.at("audit").at("digits").get_to(audit.same_state);
  constexpr std::array kSolvers{"cartesian", "relative"};
  for (std::size_t who = 0; who < 2; ++who) {
    const Json& solver = document.at("solvers").at(kSolvers[who]);
    result.cost[who] = {"", solver.at("steps"), solver.at("evaluations")};
    result.wall_s += solver.at("wall_s").get<double>();
  }
  put_in_order(result.components);
  return result;
}

ResultsFile results_of_verdicts(const Json& document) {
  const char* unknown = "not known";
  ResultsFile found{{{unknown, unknown, unknown, unknown}, "", {}}, true, is_verdict(document)};
  if (found.is_single) {
    found.night.results.push_back(result_of_verdict(document.value("name", ""), document));
    return found;
  }
  for (const auto& [name, verdict] : document.items()) found.night.results.push_back(result_of_verdict(name, verdict));
  std::sort(found.night.results.begin(), found.night.results.end(),
            [](const Result& a, const Result& b) { return a.id < b.id; });
  return found;
}

/// Nothing that a comparison wrote: to be read as a night's, which says what is wrong.
Json verdicts_in(const std::filesystem::path& file) {
  Json document = Json::parse(read_text_file(file), nullptr, false);
  return is_verdict(document) || are_verdicts(document) ? document : Json();
}

/// One case in both files, though its model may have been renamed between them; files of older versions hold no name.
std::string name_of_both(const std::string& one, const std::string& other) {
  if (one.empty() && other.empty()) return "model";
  if (one.empty() || other.empty() || one == other) return one.empty() ? other : one;
  return fmt::format("{} / {}", one, other);
}

void name_after(ResultsFile& single, const ResultsFile& other, const std::string& file) {
  std::string& id = single.night.results.front().id;
  if (other.night.results.size() == 1) {
    id = other.night.results.front().id;
  } else if (id.empty()) {
    throw InputError({file, 0, 0},
                     "holds one model without its name, the other file several: write both with the "
                     "same models by `concord compare --json`");
  }
}

}  // namespace

ResultsFile read_results_file(const std::filesystem::path& file) {
  const Json verdicts = verdicts_in(file);
  if (verdicts.is_null()) return {read_night_json(file), false, false};
  try {
    return results_of_verdicts(verdicts);
  } catch (const Json::exception& error) {
    throw InputError({file.string(), 0, 0}, fmt::format("cannot be read: {}", without_tag(error.what())));
  } catch (const std::runtime_error& error) {
    throw InputError({file.string(), 0, 0}, error.what());
  }
}

void require_comparable(ResultsFile& one, ResultsFile& other, const std::string& a, const std::string& b) {
  if (one.is_of_compare != other.is_of_compare) {
    throw InputError({one.is_of_compare ? a : b, 0, 0},
                     fmt::format("holds verdicts of `concord compare --json`, but {} results of nights: their "
                                 "components have other names",
                                 one.is_of_compare ? b : a));
  }
  if (one.is_single && other.is_single) {
    std::string& id = one.night.results.front().id;
    std::string& same = other.night.results.front().id;
    id = same = name_of_both(id, same);
  } else if (one.is_single) {
    name_after(one, other, a);
  } else if (other.is_single) {
    name_after(other, one, b);
  }
  const auto is_in_other = [&](const Result& result) {
    const auto is_it = [&](const Result& another) { return another.id == result.id; };
    return std::any_of(other.night.results.begin(), other.night.results.end(), is_it);
  };
  const auto& results = one.night.results;
  if (results.empty() || other.night.results.empty() || std::any_of(results.begin(), results.end(), is_in_other))
    return;
  throw InputError({b, 0, 0}, fmt::format("has no case in common with {}: results of '{}' and of '{}'", a,
                                          one.night.title, other.night.title));
}

}  // namespace concord::compare::nightly
